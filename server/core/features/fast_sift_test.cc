#include "server/core/features/fast_sift.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <vector>

#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"
#include "server/core/features/blob_picture.h"

namespace treeline::features {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

image::ColorImage Picture() {
  return PaintBlobs(RandomBlobs(900, kWidth, kHeight), kWidth, kHeight);
}

int SquaredDistance(const SiftDescriptor& a, const SiftDescriptor& b) {
  int sum = 0;
  for (size_t i = 0; i < a.values.size(); ++i) {
    const int difference = a.values[i] - b.values[i];
    sum += difference * difference;
  }
  return sum;
}

// Descriptors have a norm of 512: unlike features are some 300 apart.
constexpr int kAlike = 120 * 120;

// The share of the features of `before` that `after` has, too: at the place
// that `moved` says, within `max_px`, with a descriptor alike.
double ShareFound(const SiftFeatures& before, const SiftFeatures& after,
                  const std::function<camera::Pixel(camera::Pixel)>& moved,
                  double max_px) {
  int found = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const camera::Pixel at = moved(before.keypoints[i].pixel);
    for (size_t j = 0; j < after.size(); ++j) {
      const camera::Pixel& other = after.keypoints[j].pixel;
      if (std::hypot(at.x - other.x, at.y - other.y) < max_px &&
          SquaredDistance(before.descriptors[i], after.descriptors[j]) <
              kAlike) {
        ++found;
        break;
      }
    }
  }
  return static_cast<double>(found) / static_cast<double>(before.size());
}

camera::Pixel Same(camera::Pixel pixel) { return pixel; }

TEST(FastSiftTest, StandsOnBlobsAtTheirSize) {
  const std::vector<Blob> blobs = {{81.3, 60.8, 6, 120},
                                   {200, 100, 9, -90},
                                   {140.6, 180.1, 5, 130},
                                   {300.5, 300.5, 14, 100},
                                   {500.2, 200.9, 20, -80}};
  const SiftFeatures features =
      FastSift().Extract(PaintBlobs(blobs, kWidth, kHeight));
  ASSERT_EQ(features.keypoints.size(), features.descriptors.size());
  for (const Blob& blob : blobs) {
    const NearestFeature nearest = NearestTo(blob, features);
    ASSERT_NE(nearest.keypoint, nullptr);
    // A tenth of a pixel of the octave, which is no larger than the blob.
    EXPECT_LT(nearest.distance_px, 0.1 * blob.sigma) << blob.x;
    // The difference of Gaussians with blurs s and 2^(1/3) s is largest at a
    // blob of 2^(1/6) s; the diameter is 2 s.
    EXPECT_NEAR(nearest.keypoint->diameter_px / (2 * blob.sigma), 0.89, 0.08)
        << blob.x;
  }
}

TEST(FastSiftTest, KeepsWhatWasAskedFor) {
  FastSift sift;
  const SiftFeatures all = sift.Extract(Picture(), {.max_features = 400});
  EXPECT_EQ(all.size(), 400u);
  const SiftFeatures few = sift.Extract(Picture(), {.max_features = 50});
  ASSERT_EQ(few.size(), 50u);
  for (size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few.keypoints[i].pixel.x, all.keypoints[i].pixel.x);
    EXPECT_EQ(few.descriptors[i].values, all.descriptors[i].values);
  }
}

TEST(FastSiftTest, SpreadsFeaturesOverThePicture) {
  // The left half has twice the contrast of the right one.
  std::vector<Blob> blobs = RandomBlobs(900, kWidth, kHeight);
  for (Blob& blob : blobs) {
    if (blob.x > kWidth / 2) blob.height /= 2;
  }
  const SiftFeatures features = FastSift().Extract(
      PaintBlobs(blobs, kWidth, kHeight), {.max_features = 300});
  const auto right = std::ranges::count_if(
      features.keypoints,
      [](const SiftKeypoint& k) { return k.pixel.x > kWidth / 2; });
  EXPECT_GE(right, 50);
}

TEST(FastSiftTest, FindsTheSameInOtherLight) {
  FastSift sift;
  const image::ColorImage picture = Picture();
  // All of them: which are the strongest changes with the gamma.
  constexpr FastSiftOptions kAll{.max_features = 5000};
  const SiftFeatures before = sift.Extract(picture, kAll);
  const auto share = [&](const std::function<double(double)>& change) {
    return ShareFound(before, sift.Extract(ChangeValues(picture, change), kAll),
                      Same, 1.0);
  };
  // The weakest drown in the rounding to bytes.
  EXPECT_GT(share([](double v) { return 0.35 * v; }), 0.8);
  EXPECT_GT(share([](double v) { return 0.6 * v + 60; }), 0.9);
  EXPECT_GT(share([](double v) { return 255 * std::pow(v / 255, 2); }), 0.6);
  EXPECT_GT(share([](double v) { return 255 * std::pow(v / 255, 0.5); }), 0.6);
}

TEST(FastSiftTest, TurnsWithThePicture) {
  FastSift sift;
  const image::ColorImage picture = Picture();
  image::ColorImage turned{kHeight, kWidth, picture.rgb};  // clockwise
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      std::copy_n(picture.rgb.data() + 3 * (y * kWidth + x), 3,
                  turned.rgb.data() + 3 * (x * kHeight + kHeight - 1 - y));
    }
  }
  const auto move = [](camera::Pixel p) {
    return camera::Pixel{kHeight - 1 - p.y, p.x};
  };
  const SiftFeatures before = sift.Extract(picture);
  // Other octaves than the first have other pixels.
  EXPECT_GT(ShareFound(before, sift.Extract(turned), move, 0.5), 0.8);
  // Upright features do not.
  EXPECT_LT(ShareFound(sift.Extract(picture, {.upright = true}),
                       sift.Extract(turned, {.upright = true}), move, 0.5),
            0.1);
}

TEST(FastSiftTest, FindsInAWindowWhatItFindsInTheWholePicture) {
  constexpr int kLeft = 200;
  constexpr int kTop = 100;
  const image::ColorImage picture = Picture();
  image::ColorImage window{kWidth / 2, kHeight / 2, {}};
  for (int y = 0; y < window.height; ++y) {
    const auto row = picture.rgb.begin() + 3 * ((kTop + y) * kWidth + kLeft);
    window.rgb.insert(window.rgb.end(), row, row + 3 * window.width);
  }
  const auto move = [](camera::Pixel p) {
    return camera::Pixel{p.x - kLeft, p.y - kTop};
  };
  FastSift sift;
  const SiftFeatures whole = sift.Extract(picture);
  SiftFeatures inside;  // and not at the window's edge
  for (size_t i = 0; i < whole.size(); ++i) {
    const camera::Pixel at = move(whole.keypoints[i].pixel);
    if (at.x < 30 || at.y < 30 || at.x > window.width - 30 ||
        at.y > window.height - 30) {
      continue;
    }
    inside.keypoints.push_back(whole.keypoints[i]);
    inside.descriptors.push_back(whole.descriptors[i]);
  }
  ASSERT_GT(inside.size(), 30u);
  constexpr int kFew = 150;
  const double as_it_is =
      ShareFound(inside, sift.Extract(window, {.max_features = kFew}), move, 1);
  const double reduced = ShareFound(
      inside,
      sift.Extract(window, {.max_features = kFew, .least_reduction = 2}), move,
      1);
  EXPECT_GT(reduced, 0.9);
  EXPECT_GT(reduced, as_it_is + 0.1);
}

TEST(FastSiftTest, UprightFeaturesHaveNoAngle) {
  const SiftFeatures features =
      FastSift().Extract(Picture(), {.upright = true});
  ASSERT_GT(features.size(), 100u);
  for (const SiftKeypoint& k : features.keypoints) EXPECT_EQ(k.angle_deg, 0);
}

TEST(FastSiftTest, IsAFunctionOfThePicture) {
  FastSift used;
  used.Extract(ChangeValues(Picture(), [](double v) { return 255 - v; }));
  used.Extract(PaintBlobs(RandomBlobs(50, 100, 90), 100, 90));
  const SiftFeatures a = used.Extract(Picture());
  const SiftFeatures b = FastSift().Extract(Picture());
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.keypoints[i].pixel.x, b.keypoints[i].pixel.x);
    EXPECT_EQ(a.keypoints[i].pixel.y, b.keypoints[i].pixel.y);
    EXPECT_EQ(a.keypoints[i].angle_deg, b.keypoints[i].angle_deg);
    EXPECT_EQ(a.descriptors[i].values, b.descriptors[i].values);
  }
}

TEST(FastSiftTest, AllVectorInstructionsFindTheSame) {
  const image::ColorImage picture = Picture();
  const SiftFeatures usual = FastSift().Extract(picture);
  base::WithEachVectorTarget([&] {
    const SiftFeatures other = FastSift().Extract(picture);
    // Sums are rounded in another order: what is near a threshold may change
    // sides.
    EXPECT_GT(ShareFound(usual, other, Same, 0.01), 0.99);
  });
}

TEST(FastSiftTest, HasNothingToSayOfABlankOrTinyPicture) {
  FastSift sift;
  EXPECT_EQ(sift.Extract(image::ColorImage{
                             640, 480, std::vector<uint8_t>(640 * 480 * 3, 90)})
                .size(),
            0u);
  for (const int side : {0, 1, 7, 20}) {
    EXPECT_EQ(sift.Extract(image::ColorImage{
                               side, side,
                               std::vector<uint8_t>(
                                   static_cast<size_t>(3 * side * side), 90)})
                  .size(),
              0u)
        << side;
  }
}

TEST(FastSiftTest, TakesPicturesOfAnyShape) {
  FastSift sift;
  for (const auto& [width, height] :
       {std::pair(97, 61), {1283, 717}, {2000, 90}, {333, 801}}) {
    const SiftFeatures features = sift.Extract(
        PaintBlobs(RandomBlobs(width * height / 300, width, height), width,
                   height),
        {.max_features = 200});
    EXPECT_GT(features.size(), 5u) << width;
    for (const SiftKeypoint& k : features.keypoints) {
      EXPECT_GE(k.pixel.x, 0);
      EXPECT_LT(k.pixel.x, width);
      EXPECT_GE(k.pixel.y, 0);
      EXPECT_LT(k.pixel.y, height);
    }
  }
}

}  // namespace
}  // namespace treeline::features
