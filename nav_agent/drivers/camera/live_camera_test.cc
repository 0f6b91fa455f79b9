#include "nav_agent/drivers/camera/live_camera.h"

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <utility>

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"

namespace treeline::camera_driver {
namespace {

using std::chrono::milliseconds;
using Answer = absl::StatusOr<std::optional<core::RgbdFrame>>;

core::RgbdFrame Numbered(int64_t sequence) {
  return {.stamp = {}, .sequence = sequence, .frame = {}};
}

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now{std::chrono::hours(1)};
};

// What the devices of an opener answer, one after another; then nothing.
struct Script {
  std::deque<absl::Status> openings;
  std::deque<Answer> answers;
  int opened = 0;
  int open_now = 0;
};

class FakeDevice final : public CameraDevice {
 public:
  FakeDevice(Script& script, FakeClock& clock)
      : script_(script), clock_(clock) {
    ++script_.open_now;
  }
  ~FakeDevice() override { --script_.open_now; }
  camera::RgbdCalibration Calibration() const override {
    return {.color = {},
            .depth = {},
            .color_from_depth = {},
            .depth_scale = 1.0 + 0.1 * script_.opened};
  }
  Answer Read(milliseconds timeout) override {
    if (script_.answers.empty()) {
      clock_.now += timeout;
      return std::nullopt;
    }
    Answer answer = std::move(script_.answers.front());
    script_.answers.pop_front();
    return answer;
  }

 private:
  Script& script_;
  FakeClock& clock_;
};

class FakeOpener final : public CameraOpener {
 public:
  FakeOpener(Script& script, FakeClock& clock)
      : script_(script), clock_(clock) {}
  absl::StatusOr<std::unique_ptr<CameraDevice>> Open() override {
    if (!script_.openings.empty()) {
      const absl::Status status = script_.openings.front();
      script_.openings.pop_front();
      if (!status.ok()) return status;
    }
    ++script_.opened;
    return std::make_unique<FakeDevice>(script_, clock_);
  }

 private:
  Script& script_;
  FakeClock& clock_;
};

class CameraWorkerTest : public ::testing::Test {
 protected:
  Script script_;
  FakeClock clock_;
  FakeOpener opener_{script_, clock_};
  FrameQueue queue_{8};
  CameraWorker worker_{{}, opener_, clock_, queue_};
};

TEST_F(CameraWorkerTest, FramesCarryTheirCalibration) {
  script_.answers = {Numbered(100), Numbered(101), Numbered(103)};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(worker_.Step().count(), 0);
  const auto frames = queue_.Take();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].sequence, 0);
  EXPECT_EQ(frames[2].sequence, 3);  // one was lost before it
  ASSERT_TRUE(frames[0].frame.calibration.has_value());
  EXPECT_EQ(frames[0].frame.calibration->depth_scale, 1.1);
  EXPECT_EQ(worker_.calibration().depth_scale, 1.1);
}

TEST_F(CameraWorkerTest, WaitsLongerEachTimeThereIsNoCamera) {
  for (int i = 0; i < 3; ++i) {
    script_.openings.push_back(absl::NotFoundError("no camera"));
  }
  const auto first = worker_.Step();
  worker_.Step();
  const auto third = worker_.Step();
  EXPECT_GT(first.count(), 0);
  EXPECT_GT(third, 2 * first);
  EXPECT_EQ(queue_.Health().state, core::DeviceState::kStarting);
  EXPECT_EQ(queue_.Health().cause, absl::NotFoundError("no camera"));
  EXPECT_EQ(worker_.Step().count(), 0);
  EXPECT_EQ(script_.opened, 1);
}

TEST_F(CameraWorkerTest, IsFoundAgainAfterItWasUnplugged) {
  script_.answers = {Numbered(7), absl::UnavailableError("unplugged"),
                     Numbered(0), Numbered(1)};
  worker_.Step();
  worker_.Step();
  EXPECT_GT(worker_.Step().count(), 0);
  EXPECT_EQ(script_.open_now, 0);
  EXPECT_EQ(queue_.Health().state, core::DeviceState::kLost);
  EXPECT_EQ(queue_.Health().losses, 1);
  for (int i = 0; i < 3; ++i) worker_.Step();
  EXPECT_EQ(queue_.Health().state, core::DeviceState::kRunning);
  EXPECT_EQ(script_.opened, 2);
  const auto frames = queue_.Take();
  ASSERT_EQ(frames.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[static_cast<size_t>(i)].sequence, i);
  }
}

TEST_F(CameraWorkerTest, ASilentCameraIsOpenedAgain) {
  script_.answers = {Numbered(0)};
  worker_.Step();
  worker_.Step();
  for (int i = 0; i < 19; ++i) EXPECT_EQ(worker_.Step().count(), 0) << i;
  EXPECT_GT(worker_.Step().count(), 0);
  EXPECT_EQ(queue_.Health().state, core::DeviceState::kLost);
  EXPECT_EQ(script_.open_now, 0);
  worker_.Step();
  EXPECT_EQ(script_.opened, 2);
}

TEST_F(CameraWorkerTest, BrokenFramesAreCountedAndPassed) {
  script_.answers = {absl::DataLossError("half a frame"), Numbered(1)};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(worker_.Step().count(), 0);
  EXPECT_EQ(queue_.Health().corrupt, 1);
  EXPECT_EQ(queue_.Health().received, 1);
}

TEST_F(CameraWorkerTest, StampsNeverRunBackwards) {
  for (const int ms : {100, 90, 120}) {
    core::RgbdFrame frame = Numbered(ms);
    frame.stamp = base::MonotonicTime(milliseconds(ms));
    script_.answers.emplace_back(frame);
  }
  for (int i = 0; i < 4; ++i) worker_.Step();
  const auto frames = queue_.Take();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].stamp, base::MonotonicTime(milliseconds(100)));
  EXPECT_EQ(frames[2].stamp, base::MonotonicTime(milliseconds(120)));
}

TEST_F(CameraWorkerTest, ADeviceThatCountsAnewDoesNotRepeatNumbers) {
  script_.answers = {Numbered(5), Numbered(6), Numbered(0)};
  for (int i = 0; i < 4; ++i) worker_.Step();
  const auto frames = queue_.Take();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[2].sequence, 2);
}

// The thread: that it runs, and ends while its device waits.
class OneFrameDevice final : public CameraDevice {
 public:
  explicit OneFrameDevice(absl::Notification& asked_again)
      : asked_again_(asked_again) {}
  camera::RgbdCalibration Calibration() const override { return {}; }
  Answer Read(milliseconds) override {
    if (++reads_ == 1) return Numbered(0);
    if (reads_ == 2) asked_again_.Notify();
    return std::nullopt;
  }

 private:
  absl::Notification& asked_again_;
  int reads_ = 0;
};

class OneFrameOpener final : public CameraOpener {
 public:
  explicit OneFrameOpener(absl::Notification& asked_again)
      : asked_again_(asked_again) {}
  absl::StatusOr<std::unique_ptr<CameraDevice>> Open() override {
    return std::make_unique<OneFrameDevice>(asked_again_);
  }

 private:
  absl::Notification& asked_again_;
};

TEST(LiveCamera, ReadsOnAThread) {
  absl::Notification asked_again;
  FakeClock clock;
  auto camera = LiveCamera::Create(
      {}, std::make_unique<OneFrameOpener>(asked_again), clock);
  ASSERT_TRUE(camera.ok()) << camera.status();
  asked_again.WaitForNotification();
  EXPECT_EQ((*camera)->TakeFrames().size(), 1u);
  EXPECT_EQ((*camera)->Health().state, core::DeviceState::kRunning);
}

TEST(LiveCamera, BadOptionsAreRefused) {
  FakeClock clock;
  Script script;
  EXPECT_FALSE(LiveCamera::Create({}, nullptr, clock).ok());
  EXPECT_FALSE(LiveCamera::Create({.silence_s = 0},
                                  std::make_unique<FakeOpener>(script, clock),
                                  clock)
                   .ok());
  EXPECT_FALSE(LiveCamera::Create({.max_waiting = core::kMaxWaiting + 1},
                                  std::make_unique<FakeOpener>(script, clock),
                                  clock)
                   .ok());
}

}  // namespace
}  // namespace treeline::camera_driver
