#include "nav_agent/drivers/camera/v4l2/v4l2_camera.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/synchronization/notification.h"
#include "common/image/decode.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/camera/v4l2/v4l2.h"

namespace treeline::v4l2_camera {
namespace {

using std::chrono::milliseconds;

V4l2Image Yuyv(int width, int height, std::string bytes) {
  V4l2Image image;
  image.format = V4l2Format::kYuyv;
  image.width = width;
  image.height = height;
  image.stride_bytes = 2 * width;
  image.bytes = std::move(bytes);
  return image;
}

V4l2Image Jpeg(int width, int height) {
  image::ColorImage color = {.width = width, .height = height, .rgb = {}};
  color.rgb.assign(static_cast<size_t>(3 * width * height), 100);
  V4l2Image image;
  image.width = width;
  image.height = height;
  image.bytes = *image::EncodeJpeg(color, 95);
  return image;
}

TEST(V4l2Camera, YuyvBecomesRgb) {
  // Two greys; then red of BT.601: Y 76, Cb 85, Cr 255.
  const auto color = ColorFromYuyv(
      Yuyv(2, 2, std::string("\x00\x80\xFF\x80\x4C\x55\x4C\xFF", 8)));
  ASSERT_TRUE(color.ok()) << color.status();
  EXPECT_EQ(color->rgb, (std::vector<uint8_t>{0, 0, 0, 255, 255, 255, 254, 0, 0,
                                              254, 0, 0}));
}

TEST(V4l2Camera, RowsMayBePadded) {
  V4l2Image image =
      Yuyv(2, 2, std::string(4, '\x80') + "PADDING." + std::string(4, '\x80'));
  image.stride_bytes = 12;
  const auto color = ColorFromYuyv(image);
  ASSERT_TRUE(color.ok()) << color.status();
  EXPECT_EQ(color->rgb, std::vector<uint8_t>(12, 128));
}

TEST(V4l2Camera, TooFewBytesAreNoImage) {
  const std::string bytes(64, 'x');
  EXPECT_TRUE(ColorFromYuyv(Yuyv(8, 4, bytes)).ok());
  for (const auto& [width, height] :
       {std::pair(8, 5), std::pair(10, 4), std::pair(7, 2), std::pair(0, 4),
        std::pair(4, -1)}) {
    EXPECT_EQ(ColorFromYuyv(Yuyv(width, height, bytes)).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(V4l2Camera, BrokenImagesAreLostData) {
  EXPECT_TRUE(DecodeV4l2(Jpeg(16, 8)).ok());
  V4l2Image incomplete = Jpeg(16, 8);
  incomplete.corrupt = true;
  V4l2Image cut = Jpeg(16, 8);
  cut.bytes.resize(cut.bytes.size() / 2);
  V4l2Image other_size = Jpeg(16, 8);
  other_size.width = 32;
  for (const V4l2Image& image :
       {incomplete, cut, other_size, Yuyv(8, 4, "short")}) {
    EXPECT_EQ(DecodeV4l2(image).status().code(), absl::StatusCode::kDataLoss);
  }
}

// Sends one image, and tells when it is asked for the next.
class OneImageDevice final : public V4l2Device {
 public:
  explicit OneImageDevice(absl::Notification& asked_again)
      : asked_again_(asked_again) {}
  absl::StatusOr<std::optional<V4l2Image>> Read(milliseconds) override {
    ++reads_;
    if (reads_ == 2) asked_again_.Notify();
    if (reads_ > 1) return std::nullopt;
    V4l2Image image = Jpeg(16, 8);
    image.stamp = base::MonotonicTime(std::chrono::seconds(100));
    return image;
  }

 private:
  absl::Notification& asked_again_;
  int reads_ = 0;
};

class OneImageSystem final : public V4l2System {
 public:
  explicit OneImageSystem(absl::Notification& asked_again)
      : asked_again_(asked_again) {}
  absl::StatusOr<std::unique_ptr<V4l2Device>> Open(const V4l2Mode&) override {
    return std::make_unique<OneImageDevice>(asked_again_);
  }

 private:
  absl::Notification& asked_again_;
};

V4l2CameraOptions SmallCamera() {
  V4l2CameraOptions options = {.mode = {.width = 16, .height = 8},
                               .latency_s = 0.02};
  options.calibration.color =
      *camera::Camera::Parse("PINHOLE,20,20,7.5,3.5", 16, 8);
  return options;
}

TEST(V4l2Camera, FramesHaveColorAndNoDepth) {
  absl::Notification asked_again;
  base::SteadyClock clock;
  const auto camera = MakeV4l2Camera(
      SmallCamera(), std::make_unique<OneImageSystem>(asked_again), clock);
  ASSERT_TRUE(camera.ok()) << camera.status();
  asked_again.WaitForNotification();
  const auto frames = (*camera)->TakeFrames();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_FALSE(frames[0].frame.depth.has_value());
  EXPECT_EQ(frames[0].frame.color.width, 16);
  EXPECT_EQ(frames[0].frame.calibration->color.fx(), 20);
  EXPECT_EQ(frames[0].stamp,
            base::MonotonicTime(std::chrono::seconds(100)) - milliseconds(20));
}

TEST(V4l2Camera, BadOptionsAreRefused) {
  absl::Notification asked_again;
  base::SteadyClock clock;
  V4l2CameraOptions wrong_size = SmallCamera();
  wrong_size.mode.width = 32;
  V4l2CameraOptions early = SmallCamera();
  early.latency_s = -0.1;
  for (const V4l2CameraOptions& options : {wrong_size, early}) {
    EXPECT_EQ(MakeV4l2Camera(
                  options, std::make_unique<OneImageSystem>(asked_again), clock)
                  .status()
                  .code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(V4l2, WhatIsNoCameraIsReported) {
  const auto system = MakeV4l2();
  EXPECT_EQ(system->Open({.path = "/dev/no-such-video"}).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(system->Open({.path = "/dev/null"}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::v4l2_camera
