#include "server/core/features/sift_extractor.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"
#include "server/core/features/blob_picture.h"

namespace treeline::features {
namespace {

image::ColorImage Picture() {
  return PaintBlobs(RandomBlobs(60, 160, 120), 160, 120);
}

// The first `count` features of both.
void ExpectSame(const SiftFeatures& a, const SiftFeatures& b, size_t count) {
  ASSERT_LE(count, std::min(a.size(), b.size()));
  for (size_t i = 0; i < count; ++i) {
    EXPECT_EQ(a.keypoints[i].pixel.x, b.keypoints[i].pixel.x);
    EXPECT_EQ(a.keypoints[i].pixel.y, b.keypoints[i].pixel.y);
    EXPECT_EQ(a.keypoints[i].diameter_px, b.keypoints[i].diameter_px);
    EXPECT_EQ(a.keypoints[i].angle_deg, b.keypoints[i].angle_deg);
    EXPECT_EQ(a.keypoints[i].response, b.keypoints[i].response);
    EXPECT_EQ(a.descriptors[i].values, b.descriptors[i].values);
  }
}

TEST(SiftExtractorTest, PositionsAreThoseOfBlobsToATwentiethOfAPixel) {
  const std::vector<Blob> blobs = {
      {40.3, 30.8, 3, 120}, {100, 50, 4, -90}, {70.6, 90.1, 2.5, 130}};
  const SiftFeatures features = ExtractSift(PaintBlobs(blobs, 160, 120), {});
  ASSERT_EQ(features.keypoints.size(), features.descriptors.size());
  for (const Blob& blob : blobs) {
    const NearestFeature nearest = NearestTo(blob, features);
    ASSERT_NE(nearest.keypoint, nullptr);
    EXPECT_LT(nearest.distance_px, 0.05) << blob.x;
    // The difference of Gaussians with blurs s and 2^(1/3) s is largest at a
    // blob of 2^(1/6) s; the diameter is 2 s.
    EXPECT_NEAR(nearest.keypoint->diameter_px / (2 * blob.sigma), 0.89, 0.08)
        << blob.x;
  }
}

// Coarse octaves come first, and a list that they fill is finished.
TEST(SiftExtractorTest, FewFeaturesAreTheFirstOfAll) {
  const image::ColorImage image =
      PaintBlobs(RandomBlobs(900, 640, 480), 640, 480);
  const SiftFeatures all = ExtractSift(image, {.max_features = 0});
  for (size_t i = 0; i + 1 < all.size(); ++i) {
    ASSERT_GE(all.keypoints[i].diameter_px, all.keypoints[i + 1].diameter_px);
  }
  const auto doubled = std::ranges::count_if(
      all.keypoints,
      [](const SiftKeypoint& k) { return k.diameter_px < 3.5F; });
  ASSERT_GT(doubled, 100);
  ASSERT_GT(all.size(), static_cast<size_t>(doubled) + 500);
  SiftExtractor sift;
  for (size_t count = 1; count < 2 * all.size(); count = count * 5 / 3 + 1) {
    const SiftFeatures some =
        sift.Extract(image, {.max_features = static_cast<int>(count)});
    ASSERT_EQ(some.size(), std::min(count, all.size()));
    ExpectSame(some, all, some.size());
  }
}

TEST(SiftExtractorTest, LessContrastGivesMore) {
  EXPECT_GT(ExtractSift(Picture(), {.contrast = 0.01}).size(),
            ExtractSift(Picture(), {.contrast = 0.08}).size() + 10);
}

// A corner between light and dark has one direction, a saddle has two.
TEST(SiftExtractorTest, APlaceHasAFeatureForEachOfItsDirections) {
  const SiftFeatures features = ExtractSift(
      PaintBlobs({{80, 60, 4, 90}, {88, 60, 4, -60}, {80, 68, 4, -60}}, 160,
                 120),
      {});
  size_t several = 0;
  for (size_t i = 0; i + 1 < features.size(); ++i) {
    const SiftKeypoint& a = features.keypoints[i];
    const SiftKeypoint& b = features.keypoints[i + 1];
    if (a.pixel.x != b.pixel.x || a.pixel.y != b.pixel.y) continue;
    EXPECT_NE(a.angle_deg, b.angle_deg);
    EXPECT_NE(features.descriptors[i].values,
              features.descriptors[i + 1].values);
    ++several;
  }
  EXPECT_GE(several, 1u);
}

TEST(SiftExtractorTest, DescribingFoundKeypointsGivesTheirDescriptors) {
  const image::ColorImage image = Picture();
  const SiftFeatures features = ExtractSift(image, {});
  const std::vector<SiftDescriptor> again =
      DescribeSift(image, features.keypoints);
  ASSERT_EQ(again.size(), features.size());
  for (size_t i = 0; i < again.size(); ++i) {
    // Positions are rounded on their way.
    for (size_t k = 0; k < 128; ++k) {
      ASSERT_NEAR(again[i].values[k], features.descriptors[i].values[k], 1)
          << i;
    }
  }
}

TEST(SiftExtractorTest, DescribesKeypointsOfAnySizeAnywhere) {
  const std::vector<SiftKeypoint> keypoints = {
      {{0, 0}, 0, 0, 0},         {{-3, 130}, 1, 90, 0}, {{80, 60}, 1e9F, 45, 0},
      {{159, 119}, 100, 300, 0}, {{80, 60}, 8, 360, 0}, {{20, 119}, 3, 10, 0}};
  for (const SiftDescriptor& d : DescribeSift(Picture(), keypoints)) {
    int squares = 0;
    for (const uint8_t v : d.values) squares += v * v;
    // All zero where nothing is seen, else of length 512, or rounded to it.
    if (squares > 0) {
      EXPECT_NEAR(std::sqrt(squares), 512, 6);
    }
  }
}

TEST(SiftExtractorTest, FlatAndTinyImagesHaveNoFeatures) {
  EXPECT_EQ(ExtractSift(PaintBlobs({}, 160, 120), {}).size(), 0u);
  for (const int side : {1, 7, 8, 13}) {
    EXPECT_EQ(ExtractSift(PaintBlobs({}, side, side), {}).size(), 0u) << side;
    const std::vector<SiftKeypoint> keypoint = {{{0, 0}, 3, 0, 0}};
    EXPECT_EQ(DescribeSift(PaintBlobs({}, side, 20), keypoint)[0].values,
              SiftDescriptor().values);
  }
  EXPECT_TRUE(DescribeSift(PaintBlobs({}, 160, 120), {}).empty());
}

TEST(SiftExtractorTest, TakesPicturesOfAnyShape) {
  SiftExtractor sift;
  for (const auto& [width, height] :
       {std::pair(97, 61), {20, 9}, {700, 12}, {333, 201}, {31, 33}}) {
    const SiftFeatures features = sift.Extract(
        PaintBlobs(RandomBlobs(width * height / 100 + 5, width, height), width,
                   height),
        {});
    for (const SiftKeypoint& k : features.keypoints) {
      EXPECT_GE(k.pixel.x, 0);
      EXPECT_LT(k.pixel.x, width);
      EXPECT_GE(k.pixel.y, 0);
      EXPECT_LT(k.pixel.y, height);
    }
  }
}

TEST(SiftExtractorTest, IsAFunctionOfThePicture) {
  SiftExtractor used;
  used.Extract(PaintBlobs(RandomBlobs(90, 200, 90), 200, 90), {});
  const SiftFeatures a = used.Extract(Picture(), {});
  const SiftFeatures b = ExtractSift(Picture(), {});
  ASSERT_GT(a.size(), 20u);
  ASSERT_EQ(a.size(), b.size());
  ExpectSame(a, b, a.size());
}

TEST(SiftExtractorTest, AllVectorInstructionsFindTheSame) {
  const SiftFeatures usual = ExtractSift(Picture(), {});
  base::WithEachVectorTarget([&] {
    const SiftFeatures other = ExtractSift(Picture(), {});
    // Sums are rounded in another order: what is near a threshold may change
    // sides.
    size_t same = 0;
    for (size_t i = 0; i < usual.size(); ++i) {
      for (size_t j = 0; j < other.size(); ++j) {
        const SiftKeypoint& a = usual.keypoints[i];
        const SiftKeypoint& b = other.keypoints[j];
        if (std::hypot(a.pixel.x - b.pixel.x, a.pixel.y - b.pixel.y) > 0.01 ||
            std::abs(a.angle_deg - b.angle_deg) > 0.1F) {
          continue;
        }
        int largest = 0;
        for (size_t k = 0; k < 128; ++k) {
          largest = std::max(largest, std::abs(usual.descriptors[i].values[k] -
                                               other.descriptors[j].values[k]));
        }
        if (largest > 2) continue;
        ++same;
        break;
      }
    }
    EXPECT_GE(same, usual.size() * 98 / 100);
  });
}

}  // namespace
}  // namespace treeline::features
