#include "evaluation/yardsticks/opencv_sift.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "server/core/features/blob_picture.h"

namespace treeline::yardsticks {
namespace {

using features::SiftDescriptor;
using features::SiftFeatures;
using features::SiftKeypoint;

image::ColorImage Picture() {
  return features::PaintBlobs(features::RandomBlobs(900, 640, 480), 640, 480);
}

double Distance(const SiftDescriptor& a, const SiftDescriptor& b) {
  int sum = 0;
  for (size_t i = 0; i < a.values.size(); ++i) {
    const int difference = a.values[i] - b.values[i];
    sum += difference * difference;
  }
  return std::sqrt(sum);
}

double Median(std::vector<double> values) {
  const auto middle =
      values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

TEST(OpenCvSiftTest, PositionsAreThoseOfBlobsToATenthOfAPixel) {
  const std::vector<features::Blob> blobs = {
      {40.3, 30.8, 3, 120}, {100, 50, 4, -90}, {70.6, 90.1, 2.5, 130}};
  const auto found =
      ExtractOpenCvSift(features::PaintBlobs(blobs, 160, 120), {});
  ASSERT_TRUE(found.ok()) << found.status();
  for (const features::Blob& blob : blobs) {
    double nearest_px = 1e9;
    for (const SiftKeypoint& k : found->keypoints) {
      nearest_px = std::min(nearest_px,
                            std::hypot(k.pixel.x - blob.x, k.pixel.y - blob.y));
    }
    // Without the correction of OpenCV's shift it is 0.35.
    EXPECT_LT(nearest_px, 0.1) << blob.x;
  }
}

// Models that were trained with OpenCV's features are asked with ours.
TEST(OpenCvSiftTest, OursAreAlike) {
  const image::ColorImage picture = Picture();
  const auto theirs = ExtractOpenCvSift(picture, {.max_features = 0});
  ASSERT_TRUE(theirs.ok()) << theirs.status();
  const SiftFeatures ours = features::ExtractSift(picture, {.max_features = 0});
  const double count = static_cast<double>(theirs->size());
  EXPECT_NEAR(static_cast<double>(ours.size()), count, 0.05 * count);
  std::vector<double> distances;
  for (size_t i = 0; i < theirs->size(); ++i) {
    const SiftKeypoint& a = theirs->keypoints[i];
    for (size_t j = 0; j < ours.size(); ++j) {
      const SiftKeypoint& b = ours.keypoints[j];
      const double turn =
          std::remainder(double{a.angle_deg} - double{b.angle_deg}, 360);
      if (std::hypot(a.pixel.x - b.pixel.x, a.pixel.y - b.pixel.y) < 0.5 &&
          std::abs(std::log2(a.diameter_px / b.diameter_px)) < 0.25F &&
          std::abs(turn) < 10) {
        distances.push_back(
            Distance(theirs->descriptors[i], ours.descriptors[j]));
        break;
      }
    }
  }
  EXPECT_GT(static_cast<double>(distances.size()), 0.9 * count);
  // Descriptors have a norm of 512; unlike features are some 300 apart.
  EXPECT_LT(Median(distances), 60);
}

TEST(OpenCvSiftTest, OursDescribeTheSameKeypointsAlike) {
  const image::ColorImage picture = Picture();
  const auto theirs = ExtractOpenCvSift(picture, {});
  ASSERT_TRUE(theirs.ok()) << theirs.status();
  const std::vector<SiftDescriptor> ours =
      features::DescribeSift(picture, theirs->keypoints);
  std::vector<double> distances;
  for (size_t i = 0; i < ours.size(); ++i) {
    distances.push_back(Distance(theirs->descriptors[i], ours[i]));
  }
  EXPECT_LT(Median(distances), 60);
}

TEST(OpenCvSiftTest, FlatAndTinyImagesHaveNoFeatures) {
  EXPECT_EQ(ExtractOpenCvSift(features::PaintBlobs({}, 160, 120), {})->size(),
            0u);
  EXPECT_EQ(ExtractOpenCvSift(features::PaintBlobs({}, 1, 1), {})->size(), 0u);
}

// OpenCV's number of threads is not to be set by two threads at once: its pool
// is then taken down twice.
TEST(OpenCvSiftTest, ManyThreadsExtractAtOnce) {
  const image::ColorImage image =
      features::PaintBlobs(features::RandomBlobs(6, 32, 24), 32, 24);
  std::atomic<int> failed = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < 100; ++k) {
          if (!ExtractOpenCvSift(image, {}).ok()) ++failed;
        }
      });
    }
  }
  EXPECT_EQ(failed, 0);
}

}  // namespace
}  // namespace treeline::yardsticks
