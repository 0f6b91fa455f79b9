#include "server/core/features/sift_extractor.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

struct Blob {
  double x, y, sigma, height;
};

image::ColorImage Paint(const std::vector<Blob>& blobs, int width, int height) {
  image::ColorImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 100;
      for (const Blob& blob : blobs) {
        const double dx = (x - blob.x) / blob.sigma;
        const double dy = (y - blob.y) / blob.sigma;
        sum += blob.height * std::exp(-0.5 * (dx * dx + dy * dy));
      }
      const auto value =
          static_cast<uint8_t>(std::lround(std::clamp(sum, 0.0, 255.0)));
      image.rgb.insert(image.rgb.end(), {value, value, value});
    }
  }
  return image;
}

image::ColorImage RandomBlobs() {
  std::vector<Blob> blobs;
  base::Random random(3, 0);
  for (int i = 0; i < 60; ++i) {
    blobs.push_back({random.NextUniform(10, 150), random.NextUniform(10, 110),
                     random.NextUniform(1.5, 5), random.NextUniform(-90, 90)});
  }
  return Paint(blobs, 160, 120);
}

TEST(SiftExtractorTest, PositionsAreThoseOfBlobsToATenthOfAPixel) {
  const std::vector<Blob> blobs = {
      {40.3, 30.8, 3, 120}, {100, 50, 4, -90}, {70.6, 90.1, 2.5, 130}};
  const auto features = ExtractSift(Paint(blobs, 160, 120), {});
  ASSERT_TRUE(features.ok()) << features.status();
  ASSERT_EQ(features->keypoints.size(), features->descriptors.size());
  for (const Blob& blob : blobs) {
    double nearest_px = 1e9;
    for (const SiftKeypoint& k : features->keypoints) {
      nearest_px = std::min(nearest_px,
                            std::hypot(k.pixel.x - blob.x, k.pixel.y - blob.y));
    }
    // Without the correction of OpenCV's shift it is 0.35.
    EXPECT_LT(nearest_px, 0.1) << blob.x;
  }
}

TEST(SiftExtractorTest, KeepsTheLargestFeaturesInOrder) {
  const image::ColorImage image = RandomBlobs();
  const auto all = ExtractSift(image, {.max_features = 0});
  const auto some = ExtractSift(image, {.max_features = 10});
  ASSERT_TRUE(all.ok() && some.ok());
  ASSERT_GT(all->size(), 20u);
  ASSERT_EQ(some->size(), 10u);
  for (size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(some->keypoints[i].pixel.x, all->keypoints[i].pixel.x);
    EXPECT_EQ(some->descriptors[i].values, all->descriptors[i].values);
    EXPECT_GE(all->keypoints[i].diameter_px, all->keypoints[i + 1].diameter_px);
  }
}

TEST(SiftExtractorTest, DescribingFoundKeypointsGivesTheirDescriptors) {
  const image::ColorImage image = RandomBlobs();
  const auto features = ExtractSift(image, {});
  ASSERT_TRUE(features.ok());
  const auto again = DescribeSift(image, features->keypoints);
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_EQ(again->size(), features->size());
  // The pyramid's level follows from the size, so few can differ.
  size_t same = 0;
  for (size_t i = 0; i < again->size(); ++i) {
    int largest = 0;
    for (size_t k = 0; k < 128; ++k) {
      largest = std::max(largest, std::abs((*again)[i].values[k] -
                                           features->descriptors[i].values[k]));
    }
    same += largest <= 3;
  }
  EXPECT_GE(same, features->size() * 9 / 10);
}

TEST(SiftExtractorTest, FlatAndTinyImagesHaveNoFeatures) {
  EXPECT_EQ(ExtractSift(Paint({}, 160, 120), {})->size(), 0u);
  EXPECT_EQ(ExtractSift(Paint({}, 1, 1), {})->size(), 0u);
  EXPECT_TRUE(DescribeSift(Paint({}, 160, 120), {})->empty());
}

TEST(SiftExtractorTest, RootSiftHasLength512) {
  std::vector<float> histogram(128);
  for (size_t i = 0; i < 128; ++i) histogram[i] = static_cast<float>(i % 7);
  const SiftDescriptor root = RootSift(histogram);
  double squares = 0;
  for (const uint8_t value : root.values) squares += double{1} * value * value;
  // Each of 128 values is rounded by at most a half.
  EXPECT_NEAR(std::sqrt(squares), 512, 6);
  EXPECT_NEAR(double{1} * root.values[4] / root.values[1], 2, 0.05);
  EXPECT_EQ(RootSift(std::vector<float>(128)).values, SiftDescriptor().values);
}

}  // namespace
}  // namespace treeline::features
