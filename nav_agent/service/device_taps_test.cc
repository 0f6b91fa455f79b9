#include "nav_agent/service/device_taps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>
#include <utility>
#include <vector>

#include "common/image/decode.h"
#include "nav_agent/service/battery_tap.h"

namespace treeline::agent_service {
namespace {

using std::chrono::milliseconds;

core::RgbdFrame FrameAt(int ms, uint8_t shade) {
  core::RgbdFrame frame;
  frame.stamp = base::MonotonicTime(milliseconds(ms));
  frame.frame.color = {.width = 16,
                       .height = 16,
                       .rgb = std::vector<uint8_t>(16 * 16 * 3, shade)};
  return frame;
}

uint8_t ShadeOf(const PictureKeeper& keeper) {
  const auto jpeg = keeper.Jpeg();
  EXPECT_TRUE(jpeg.ok()) << jpeg.status();
  return image::DecodeColor(**jpeg, {})->rgb[0];
}

TEST(BatteryTap, RemembersTheNewestVoltageThatTheBaseTold) {
  class Wheels final : public core::Odometry {
   public:
    std::vector<core::BaseReading> TakeReadings() override {
      return std::exchange(waiting, {});
    }
    core::DeviceHealth Health() const override { return {}; }
    std::vector<core::BaseReading> waiting;
  };
  Wheels wheels;
  BatteryTap tap(wheels);
  wheels.waiting.resize(2);
  EXPECT_EQ(tap.TakeReadings().size(), 2U);
  EXPECT_EQ(tap.battery(), std::nullopt);
  wheels.waiting.resize(3);
  wheels.waiting[0].battery_v = 72;
  wheels.waiting[1].battery_v = 71.5;
  EXPECT_EQ(tap.TakeReadings().size(), 3U);
  // The last one did not tell.
  EXPECT_EQ(tap.battery(), core::Battery{.voltage_v = 71.5});
}

TEST(PictureKeeper, KeepsTheNewestOfEveryInterval) {
  PictureKeeper keeper(milliseconds(200));
  EXPECT_TRUE(absl::IsNotFound(keeper.Jpeg().status()));
  keeper.Keep(FrameAt(1000, 50));
  // A grey picture survives JPEG to a step or two.
  EXPECT_NEAR(ShadeOf(keeper), 50, 2);
  keeper.Keep(FrameAt(1100, 150));
  EXPECT_NEAR(ShadeOf(keeper), 50, 2);
  keeper.Keep(FrameAt(1200, 150));
  EXPECT_NEAR(ShadeOf(keeper), 150, 2);
  // The clock of a camera that was started anew.
  keeper.Keep(FrameAt(10, 250));
  EXPECT_NEAR(ShadeOf(keeper), 250, 2);
  // Without colour there is nothing to show.
  core::RgbdFrame dark;
  dark.stamp = base::MonotonicTime(milliseconds(9000));
  keeper.Keep(dark);
  EXPECT_NEAR(ShadeOf(keeper), 250, 2);
}

TEST(PictureKeeper, MarksThePixelsOfItsPictureOnly) {
  PictureKeeper keeper(milliseconds(0));
  const auto picture = [&keeper] {
    return *image::DecodeColor(**keeper.Jpeg(), {});
  };
  const auto is_marked = [](const image::ColorImage& image, int x, int y) {
    const size_t index = (static_cast<size_t>(y) * 16 + x) * 3;
    return image.rgb[index + 1] > image.rgb[index] + 60;
  };
  // No picture yet.
  keeper.Mark(FrameAt(1000, 50).stamp, std::vector<geometry::Vec2>{{4, 4}});
  keeper.Keep(FrameAt(1000, 50));
  // Another one's.
  keeper.Mark(FrameAt(900, 50).stamp, std::vector<geometry::Vec2>{{4, 4}});
  EXPECT_FALSE(is_marked(picture(), 4, 4));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  keeper.Mark(FrameAt(1000, 50).stamp,
              std::vector<geometry::Vec2>{
                  {4.5, 4.5}, {15, 0}, {-1, 3}, {3, 16}, {nan, 3}, {1e30, 3}});
  EXPECT_TRUE(is_marked(picture(), 4, 4));
  EXPECT_TRUE(is_marked(picture(), 15, 0));
  EXPECT_FALSE(is_marked(picture(), 10, 10));
  keeper.Keep(FrameAt(1001, 50));
  EXPECT_FALSE(is_marked(picture(), 4, 4));
}

// Has so many frames, once.
class FewFramesCamera final : public core::RgbdCamera {
 public:
  explicit FewFramesCamera(int frames) : frames_(frames) {}

  camera::RgbdCalibration Calibration() const override { return {}; }
  std::vector<core::RgbdFrame> TakeFrames() override {
    std::vector<core::RgbdFrame> taken;
    const int count = std::exchange(frames_, 0);
    for (int i = 0; i < count; ++i) {
      taken.push_back(FrameAt(i, static_cast<uint8_t>(10 * i)));
    }
    return taken;
  }
  core::DeviceHealth Health() const override {
    core::DeviceHealth health;
    health.received = 7;
    return health;
  }

 private:
  int frames_;
};

TEST(BackgroundCamera, KeepsTheNewestFewAndShowsAll) {
  FewFramesCamera camera(10);
  std::atomic<int> shown = 0;
  BackgroundCamera background(camera, [&](const core::RgbdFrame&) { ++shown; });
  while (shown < 10) std::this_thread::yield();
  EXPECT_EQ(background.Health().received, 7);
  std::vector<core::RgbdFrame> taken;
  // The last one is handed over just after it was shown.
  while (taken.empty() || taken.back().stamp != FrameAt(9, 0).stamp) {
    for (core::RgbdFrame& frame : background.TakeFrames()) {
      taken.push_back(std::move(frame));
    }
  }
  EXPECT_LE(taken.size(), 5U);
  EXPECT_TRUE(background.TakeFrames().empty());
}

class DeadServer final : public core::RelocalizationPort {
 public:
  void Ask(const core::RgbdFrame& /*frame*/, double timeout_s) override {
    timeout = timeout_s;
  }
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> TakeAnswer()
      override {
    return absl::StatusOr<core::RelocalizationAnswer>(
        absl::UnavailableError("nobody there"));
  }
  bool IsAsking() const override { return timeout > 0; }
  void Cancel() override { timeout = 0; }

  double timeout = 0;
};

TEST(WatchedServer, KeepsTheQuestionAndTheError) {
  DeadServer server;
  PictureKeeper keeper(milliseconds(0));
  WatchedServer watched(server, keeper);
  EXPECT_TRUE(watched.last_error().ok());
  watched.Ask(FrameAt(0, 120), 2.5);
  EXPECT_EQ(server.timeout, 2.5);
  EXPECT_TRUE(watched.IsAsking());
  EXPECT_NEAR(ShadeOf(keeper), 120, 2);
  EXPECT_TRUE(watched.TakeAnswer().has_value());
  EXPECT_TRUE(absl::IsUnavailable(watched.last_error()));
  watched.Cancel();
  EXPECT_FALSE(watched.IsAsking());
}

}  // namespace
}  // namespace treeline::agent_service
