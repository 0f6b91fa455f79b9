#include "server/core/keyframes/direct_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/image/frame.h"
#include "gtest/gtest.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/planar_image.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/keyframes/testing_keyframe_model.h"

namespace treeline::keyframes {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kFocal_px = 260;
constexpr double kWall_m = 2;
constexpr uint16_t kCover_mm = 700;

// A wall with blots, seen from its front; what covers it is even but for a
// slope of light.
class DirectAlignmentTest : public testing::Test {
 protected:
  DirectAlignmentTest() {
    calibration_.color = calibration_.depth =
        *camera::Camera::Parse("PINHOLE,260,260,160,120", kWidth, kHeight);
    frame_ = PictureOf(0);
    const features::GrayPyramid pyramid = PyramidOf(frame_.color);
    Keyframes keyframes;
    keyframes.records.resize(1);
    for (int y = 20; y < kHeight - 20; y += 5) {
      for (int x = 20; x < kWidth - 20; x += 5) {
        KeyframePoint point;
        point.position_in_world = {
            static_cast<float>((x - kWidth / 2.0) / kFocal_px * kWall_m),
            static_cast<float>((y - kHeight / 2.0) / kFocal_px * kWall_m),
            static_cast<float>(kWall_m)};
        point.normal_in_world = {0, 0, -127};
        for (int l = 0; l < features::GrayPyramid::kLevels; ++l) {
          point.gray[static_cast<size_t>(l)] =
              static_cast<uint8_t>(std::lround(pyramid.level(l).At(
                  features::AtLevel(static_cast<float>(x), l),
                  features::AtLevel(static_cast<float>(y), l))));
        }
        keyframes.points.push_back(point);
      }
    }
    keyframes.records[0].points =
        static_cast<uint32_t>(keyframes.points.size());
    model_ = *ModelWithKeyframes(keyframes);
    map_ = *KeyframeMap::Read(*model_);
  }

  // What covers the `covered` first columns is `cover` bright.
  static image::Frame PictureOf(int covered, int cover = 0) {
    image::Frame frame;
    frame.color.width = kWidth;
    frame.color.height = kHeight;
    frame.depth.emplace();
    frame.depth->width = kWidth;
    frame.depth->height = kHeight;
    frame.depth->unit_m = 0.001;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool is_covered = x < covered;
        const double blots = 120 + 45 * std::sin(x / 9.0) * std::cos(y / 7.0) +
                             30 * std::sin((x + 2 * y) / 16.0);
        const double gray = is_covered ? cover + y / 24.0 : blots;
        for (int c = 0; c < 3; ++c) {
          frame.color.rgb.push_back(
              static_cast<uint8_t>(std::clamp(std::lround(gray), 0L, 255L)));
        }
        frame.depth->values.push_back(
            is_covered ? kCover_mm : static_cast<uint16_t>(1000 * kWall_m));
      }
    }
    return frame;
  }

  static features::GrayPyramid PyramidOf(const image::ColorImage& color) {
    features::GrayPyramid pyramid;
    pyramid.Assign(features::PlanarImage(color));
    return pyramid;
  }

  // From a centimetre beside.
  Alignment Align(const image::Frame& frame, const image::DepthImage* depth,
                  const AlignmentOptions& options = {}) {
    const geometry::Rigid3 start{{}, {0.01, 0, 0}};
    const std::optional<Alignment> aligned = AlignToKeyframes(
        map_, PyramidOf(frame.color), depth, calibration_, start, options);
    EXPECT_TRUE(aligned.has_value());
    return aligned.value_or(Alignment{});
  }

  static double Error_m(const Alignment& aligned) {
    return geometry::Norm(aligned.world_from_camera.translation);
  }

  camera::RgbdCalibration calibration_;
  image::Frame frame_;
  std::unique_ptr<const forest::ModelFile> model_;
  KeyframeMap map_;
};

TEST_F(DirectAlignmentTest, FindsThePoseOfAWholePicture) {
  const Alignment aligned = Align(frame_, &*frame_.depth);
  EXPECT_LT(Error_m(aligned), 0.001);
  EXPECT_GT(aligned.agreement, 0.97);
  EXPECT_GT(aligned.depth_agreement, 0.97);
}

TEST_F(DirectAlignmentTest, WhatCoversHalfThePictureDoesNotSetTheExposure) {
  for (const int cover : {5, 90, 115, 200}) {
    const image::Frame frame = PictureOf(kWidth / 2, cover);
    const Alignment aligned = Align(frame, nullptr);
    EXPECT_LT(Error_m(aligned), 0.003) << cover;
    // Some of what covers is as bright as the wall.
    EXPECT_GT(aligned.agreement, 0.45) << cover;
    EXPECT_LT(aligned.agreement, 0.75) << cover;
  }
}

TEST_F(DirectAlignmentTest, ALampOnOneSideIsEvenedWhereAskedFor) {
  image::Frame frame = frame_;
  size_t i = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // Three stops from left to right; a quarter is as white as it gets.
      const double gain = std::exp2(3.0 * x / kWidth - 1.5);
      for (int c = 0; c < 3; ++c, ++i) {
        frame.color.rgb[i] = static_cast<uint8_t>(
            std::min(255L, std::lround(gain * frame.color.rgb[i])));
      }
    }
  }
  const Alignment uneven = Align(frame, nullptr);
  EXPECT_LT(uneven.agreement, 0.6);
  const Alignment even = Align(frame, nullptr, {.evens_light = true});
  EXPECT_LT(Error_m(even), 0.002);
  EXPECT_GT(even.agreement, 0.9);
}

TEST_F(DirectAlignmentTest, APictureOfAWallBeforeTheWallIsContradicted) {
  const image::Frame nearer = PictureOf(kWidth);
  const Alignment aligned = Align(frame_, &*nearer.depth);
  EXPECT_GT(aligned.measured, 1000);
  EXPECT_LT(aligned.depth_agreement, 0.1);
}

}  // namespace
}  // namespace treeline::keyframes
