#include "server/core/features/gray_pyramid.h"

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

image::ColorImage RandomImage(int width, int height) {
  image::ColorImage image{width, height, {}};
  base::Random random(7, 0);
  image.rgb.resize(static_cast<size_t>(3 * width * height));
  for (uint8_t& value : image.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  return image;
}

// As the header defines it.
int Gray(const image::ColorImage& image, int x, int y) {
  const uint8_t* rgb = image.rgb.data() + 3 * (y * image.width + x);
  return (rgb[0] + 2 * rgb[1] + rgb[2] + 2) / 4;
}

int Mean(const GrayPyramid::Level& below, int x, int y) {
  const uint8_t* top = below.gray.data() + 2 * y * below.width + 2 * x;
  const uint8_t* bottom = top + below.width;
  return (top[0] + top[1] + bottom[0] + bottom[1] + 2) / 4;
}

void Check(int width, int height) {
  const image::ColorImage image = RandomImage(width, height);
  GrayPyramid pyramid;
  pyramid.Assign(PlanarImage(RandomImage(70, 9)));
  pyramid.Assign(PlanarImage(image));
  for (int l = 0; l < GrayPyramid::kLevels; ++l) {
    const GrayPyramid::Level& level = pyramid.level(l);
    ASSERT_EQ(level.width, width >> l);
    ASSERT_EQ(level.height, height >> l);
    for (int y = 0; y < level.height; ++y) {
      for (int x = 0; x < level.width; ++x) {
        const int expected =
            l == 0 ? Gray(image, x, y) : Mean(pyramid.level(l - 1), x, y);
        ASSERT_EQ(level.gray[static_cast<size_t>(y * level.width + x)],
                  expected)
            << width << " x " << height << ", level " << l << ": " << x << ", "
            << y;
      }
    }
  }
}

TEST(GrayPyramidTest, EveryPixelIsTheMeanOfThoseBelow) {
  base::WithEachVectorTarget([&] {
    for (const int width : {1, 3, 64, 129, 170}) {
      for (const int height : {1, 2, 37}) Check(width, height);
    }
  });
}

}  // namespace
}  // namespace treeline::features
