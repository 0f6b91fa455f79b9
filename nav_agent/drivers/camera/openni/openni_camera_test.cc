#include "nav_agent/drivers/camera/openni/openni_camera.h"

#include <chrono>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::openni_camera {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

const base::MonotonicTime kStart{std::chrono::hours(1)};
constexpr double kDegree_rad = std::numbers::pi / 180;
// The Xtion's, as OpenNI2 tells them.
constexpr OpenNiFieldOfView kColorView = {.width = 640,
                                          .height = 480,
                                          .horizontal_rad = 58 * kDegree_rad,
                                          .vertical_rad = 45 * kDegree_rad};

OpenNiImage Image(bool depth, int index, microseconds device_time) {
  OpenNiImage image;
  image.device_time = device_time;
  image.arrival = kStart + device_time + milliseconds(20);
  image.index = index;
  if (depth) {
    image.image = image::DepthImage{
        .width = 1, .height = 1, .values = {static_cast<uint16_t>(index)}};
  } else {
    image.image = image::ColorImage{
        .width = 1, .height = 1, .rgb = {static_cast<uint8_t>(index), 0, 0}};
  }
  return image;
}

class FakeDevice final : public OpenNiDevice {
 public:
  explicit FakeDevice(std::deque<OpenNiImage> images, bool registered = true)
      : images_(std::move(images)), registered_(registered) {}
  OpenNiFieldOfView ColorFieldOfView() const override { return kColorView; }
  OpenNiFieldOfView DepthFieldOfView() const override { return kColorView; }
  bool registered() const override { return registered_; }
  absl::StatusOr<std::optional<OpenNiImage>> Read(milliseconds) override {
    if (images_.empty()) return absl::UnavailableError("unplugged");
    OpenNiImage image = std::move(images_.front());
    images_.pop_front();
    return image;
  }

 private:
  std::deque<OpenNiImage> images_;
  const bool registered_;
};

struct Outcome {
  std::vector<core::RgbdFrame> frames;
  int unpaired = 0;
};

Outcome ReadAll(std::deque<OpenNiImage> images,
                const OpenNiCameraOptions& options = {}) {
  OpenNiCameraDevice camera(options,
                            std::make_unique<FakeDevice>(std::move(images)));
  Outcome outcome;
  while (true) {
    auto frame = camera.Read(milliseconds(1));
    if (absl::IsUnavailable(frame.status())) return outcome;
    if (absl::IsDataLoss(frame.status())) {
      ++outcome.unpaired;
    } else if (frame->has_value()) {
      outcome.frames.push_back(**std::move(frame));
    }
  }
}

int ColorOf(const core::RgbdFrame& frame) { return frame.frame.color.rgb[0]; }
int DepthOf(const core::RgbdFrame& frame) {
  return frame.frame.depth->values[0];
}

TEST(OpenNiCamera, PairsColorAndDepthWhicheverComesFirst) {
  std::deque<OpenNiImage> images;
  for (int i = 0; i < 10; ++i) {
    const microseconds time(33333 * i);
    images.push_back(Image(i % 2 == 0, i, time));
    images.push_back(Image(i % 2 != 0, i, time + microseconds(900)));
  }
  const Outcome outcome = ReadAll(images);
  ASSERT_EQ(outcome.frames.size(), 10u);
  EXPECT_EQ(outcome.unpaired, 0);
  for (int i = 0; i < 10; ++i) {
    const core::RgbdFrame& frame = outcome.frames[static_cast<size_t>(i)];
    EXPECT_EQ(ColorOf(frame), i);
    EXPECT_EQ(DepthOf(frame), i);
    EXPECT_EQ(frame.sequence, i);
  }
}

TEST(OpenNiCamera, ALostImageCostsItsPartnerAlone) {
  for (const bool lost_depth : {false, true}) {
    std::deque<OpenNiImage> images;
    for (int i = 0; i < 6; ++i) {
      for (const bool depth : {false, true}) {
        if (i == 3 && depth == lost_depth) continue;
        images.push_back(Image(depth, i, microseconds(33333 * i)));
      }
    }
    const Outcome outcome = ReadAll(images);
    EXPECT_EQ(outcome.frames.size(), 5u);
    EXPECT_EQ(outcome.unpaired, 1);
    for (const core::RgbdFrame& frame : outcome.frames) {
      EXPECT_EQ(ColorOf(frame), DepthOf(frame));
      EXPECT_NE(ColorOf(frame), 3);
    }
  }
}

TEST(OpenNiCamera, WhatWasTakenTooFarApartIsNotPaired) {
  const OpenNiCameraOptions options = {.max_pair_difference_s = 0.005};
  const Outcome apart = ReadAll(
      {Image(false, 0, microseconds(0)), Image(true, 0, microseconds(5100))},
      options);
  EXPECT_TRUE(apart.frames.empty());
  EXPECT_EQ(apart.unpaired, 1);
  const Outcome together = ReadAll(
      {Image(false, 0, microseconds(0)), Image(true, 0, microseconds(4900))},
      options);
  EXPECT_EQ(together.frames.size(), 1u);
}

TEST(OpenNiCamera, StampsAreTheColorsLessTheLatency) {
  const Outcome outcome = ReadAll(
      {Image(true, 0, microseconds(500)), Image(false, 0, microseconds(0))},
      {.latency_s = 0.025});
  ASSERT_EQ(outcome.frames.size(), 1u);
  EXPECT_EQ(outcome.frames[0].stamp, kStart - milliseconds(5));
}

TEST(OpenNiCamera, FieldsOfViewGiveAPinhole) {
  const auto calibration =
      CalibrationByFieldOfView(kColorView, kColorView, /*registered=*/true);
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_NEAR(calibration->color.fx(), 320 / std::tan(29 * kDegree_rad), 1e-9);
  EXPECT_NEAR(calibration->color.fy(), 240 / std::tan(22.5 * kDegree_rad),
              1e-9);
  EXPECT_EQ(calibration->color.cx(), 319.5);
  EXPECT_EQ(calibration->depth, calibration->color);
  EXPECT_EQ(calibration->color_from_depth, geometry::Rigid3{});
  // The left edge of the image is half the field of view away.
  EXPECT_NEAR(std::atan(calibration->color.Unproject({.x = -0.5, .y = 0})->x),
              -29 * kDegree_rad, 1e-9);
}

// What the depth camera sees straight ahead is to the left of the colour
// camera, which sits to its right.
TEST(OpenNiCamera, UnregisteredDepthHasABaseline) {
  const auto calibration =
      CalibrationByFieldOfView(kColorView, kColorView, /*registered=*/false);
  ASSERT_TRUE(calibration.ok());
  const geometry::Vec3 in_color =
      calibration->color_from_depth * geometry::Vec3{.x = 0, .y = 0, .z = 1};
  EXPECT_EQ(in_color.x, -0.025);
}

class FakeSystem final : public OpenNiSystem {
 public:
  absl::StatusOr<std::unique_ptr<OpenNiDevice>> Open(
      const OpenNiMode&) override {
    return std::make_unique<FakeDevice>(std::deque<OpenNiImage>());
  }
};

TEST(OpenNiCamera, BadOptionsAreRefused) {
  base::SteadyClock clock;
  const OpenNiCameraOptions bad[] = {
      {.mode = {.width = 0}},
      {.max_pair_difference_s = 0},
      {.latency_s = -1},
      {.live = {.silence_s = 0}},
  };
  for (const OpenNiCameraOptions& options : bad) {
    EXPECT_EQ(MakeOpenNiCamera(options, std::make_unique<FakeSystem>(), clock)
                  .status()
                  .code(),
              absl::StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(MakeOpenNiCamera({}, nullptr, clock).ok());
}

}  // namespace
}  // namespace treeline::openni_camera
