#include "server/core/features/pixel_difference_blocks.h"

#include <array>
#include <vector>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

image::ColorImage RandomImage(int width, int height) {
  image::ColorImage image{width, height, {}};
  base::Random random(3, 0);
  for (int i = 0; i < 3 * width * height; ++i) {
    image.rgb.push_back(static_cast<uint8_t>(random.NextBelow(256)));
  }
  return image;
}

PixelDifference RandomFeature(base::Random& random) {
  const auto delta = [&] {
    return static_cast<int16_t>(static_cast<int>(random.NextBelow(1023)) - 511);
  };
  PixelDifference feature;
  feature.dx = delta();
  feature.dy = delta();
  feature.c1 = static_cast<uint8_t>(random.NextBelow(3));
  feature.c2 = static_cast<uint8_t>(random.NextBelow(3));
  return feature;
}

// At corners, too, where most offsets leave the image, and near and far.
TEST(PixelDifferenceBlocksTest, AreWhatEachFeatureIsAlone) {
  const PlanarImage image(RandomImage(41, 23));
  base::Random random(5, 0);
  std::array<PixelDifferenceBlock, 3> blocks;
  std::vector<PixelDifference> features;
  for (size_t i = 0; i < blocks.size() * PixelDifferenceBlock::kFeatures; ++i) {
    features.push_back(RandomFeature(random));
    blocks[i / PixelDifferenceBlock::kFeatures].Set(
        i % PixelDifferenceBlock::kFeatures, features.back());
  }
  base::WithEachVectorTarget([&] {
    for (const int32_t q : {1, 900, 4096, 65535}) {
      for (const int32_t x : {0, 20, 40}) {
        for (const int32_t y : {0, 11, 22}) {
          std::vector<int16_t> values(features.size());
          EvaluateBlocks(blocks, image, x, y, q, values);
          for (size_t i = 0; i < features.size(); ++i) {
            ASSERT_EQ(values[i], Evaluate(features[i], image, x, y, q))
                << "feature " << i << " at " << x << ", " << y << ", q " << q;
          }
        }
      }
    }
  });
}

}  // namespace
}  // namespace treeline::features
