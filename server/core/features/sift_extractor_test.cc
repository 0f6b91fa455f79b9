#include "server/core/features/sift_extractor.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "server/core/features/blob_picture.h"

namespace treeline::features {
namespace {

image::ColorImage Picture() {
  return PaintBlobs(RandomBlobs(60, 160, 120), 160, 120);
}

TEST(SiftExtractorTest, PositionsAreThoseOfBlobsToATenthOfAPixel) {
  const std::vector<Blob> blobs = {
      {40.3, 30.8, 3, 120}, {100, 50, 4, -90}, {70.6, 90.1, 2.5, 130}};
  const auto features = ExtractSift(PaintBlobs(blobs, 160, 120), {});
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
  const image::ColorImage image = Picture();
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
  const image::ColorImage image = Picture();
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
  EXPECT_EQ(ExtractSift(PaintBlobs({}, 160, 120), {})->size(), 0u);
  EXPECT_EQ(ExtractSift(PaintBlobs({}, 1, 1), {})->size(), 0u);
  EXPECT_TRUE(DescribeSift(PaintBlobs({}, 160, 120), {})->empty());
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

// OpenCV's number of threads is not to be set by two threads at once: its pool
// is then taken down twice.
TEST(SiftExtractorTest, ManyThreadsExtractAtOnce) {
  const image::ColorImage image = PaintBlobs(RandomBlobs(6, 32, 24), 32, 24);
  std::atomic<int> failed = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < 3000; ++k) {
          if (!DescribeSift(image, {}).ok()) ++failed;
        }
        if (!ExtractSift(image, {}).ok()) ++failed;
      });
    }
  }
  EXPECT_EQ(failed, 0);
}

}  // namespace
}  // namespace treeline::features
