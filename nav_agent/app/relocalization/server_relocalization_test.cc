#include "nav_agent/app/relocalization/server_relocalization.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "absl/synchronization/notification.h"
#include "client/relocalizer/connect_options.h"
#include "common/image/decode.h"
#include "gtest/gtest.h"

namespace treeline::relocalization {
namespace {

class StepClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    return base::MonotonicTime() + std::chrono::milliseconds(now_ms_.load());
  }
  void Advance(int64_t ms) { now_ms_ += ms; }

 private:
  std::atomic<int64_t> now_ms_{1000};
};

// Does with a query what the test says.
class FakeRelocalizer final : public relocalizer::Relocalizer {
 public:
  std::function<absl::StatusOr<relocalizer::LocalizeAnswer>(
      const relocalizer::LocalizeQuery&, const relocalizer::CallOptions&)>
      localize;

  absl::StatusOr<relocalizer::LocalizeAnswer> Localize(
      const relocalizer::LocalizeQuery& query,
      const relocalizer::CallOptions& options) override {
    return localize(query, options);
  }
  absl::StatusOr<std::vector<relocalizer::SceneDescription>> ListScenes(
      const relocalizer::CallOptions&) override {
    return absl::UnimplementedError("");
  }
  absl::StatusOr<relocalizer::SceneDescription> GetScene(
      const std::string&, const relocalizer::CallOptions&) override {
    return absl::UnimplementedError("");
  }
  absl::StatusOr<relocalizer::SceneDescription> LoadScene(
      const std::string&, const std::string&,
      const relocalizer::CallOptions&) override {
    return absl::UnimplementedError("");
  }
  absl::StatusOr<relocalizer::SceneDescription> UnloadScene(
      const std::string&, const std::string&,
      const relocalizer::CallOptions&) override {
    return absl::UnimplementedError("");
  }
  std::unique_ptr<relocalizer::LocalizeStream> OpenStream(
      const relocalizer::StreamOptions&) override {
    return nullptr;
  }
};

core::RgbdFrame SmallFrame(bool is_registered) {
  core::RgbdFrame frame;
  frame.stamp = base::MonotonicTime() + std::chrono::seconds(7);
  frame.frame.color = {.width = 32, .height = 24, .rgb = {}};
  frame.frame.color.rgb.assign(32 * 24 * 3, 90);
  frame.frame.depth = image::DepthImage{
      .width = 32, .height = 24, .values = {}, .unit_m = 0.001};
  frame.frame.depth->values.assign(32 * 24, 1234);
  camera::RgbdCalibration calibration;
  calibration.color = *camera::Camera::Parse("PINHOLE,30,30,15.5,11.5", 32, 24);
  calibration.depth = calibration.color;
  if (!is_registered) calibration.color_from_depth.translation = {0.03, 0, 0};
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  frame.frame.calibration = calibration;
  return frame;
}

// Waits for real, as short as can be: the worker is a thread.
std::optional<absl::StatusOr<core::RelocalizationAnswer>> WaitFor(
    core::RelocalizationPort& port) {
  for (int i = 0; i < 20000; ++i) {
    if (auto answer = port.TakeAnswer(); answer.has_value()) return answer;
    std::this_thread::yield();
  }
  return std::nullopt;
}

TEST(EncodeFrame, SendsThePictureTheDepthAndItsCameras) {
  const auto query = EncodeFrame(SmallFrame(false).frame, 92);
  ASSERT_TRUE(query.ok()) << query.status();
  const auto& color = std::get<wire::EncodedImage>(query->color);
  EXPECT_EQ(image::SniffFormat(color.bytes), image::ImageFormat::kJpeg);
  EXPECT_EQ(image::DecodeColor(color.bytes)->width, 32);
  ASSERT_TRUE(query->depth.has_value());
  EXPECT_EQ(query->depth->registration, wire::DepthRegistration::kExplicit);
  ASSERT_TRUE(query->depth->geometry.has_value());
  EXPECT_EQ(query->depth->geometry->color_from_depth.translation.x, 0.03);
  const auto depth = image::DecodeDepthPng(
      std::get<wire::EncodedImage>(query->depth->image).bytes, 0.001);
  ASSERT_TRUE(depth.ok());
  EXPECT_EQ(depth->values[5], 1234);
  EXPECT_EQ(EncodeFrame(SmallFrame(true).frame, 92)->depth->registration,
            wire::DepthRegistration::kRegisteredToColor);
  EXPECT_EQ(EncodeFrame({}, 92).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(ServerRelocalization, HandsOverTheAnswerOnceAndWithoutAPrior) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  relocalizer->localize = [](const relocalizer::LocalizeQuery& query,
                             const relocalizer::CallOptions&) {
    EXPECT_EQ(query.scene, "office");
    EXPECT_TRUE(query.priors.empty());
    EXPECT_EQ(query.frame.orientation,
              (image::Orientation{image::QuarterTurn::kNone, true}));
    relocalizer::LocalizeAnswer answer;
    answer.localized = true;
    answer.confidence = 0.8;
    answer.inliers = 12;
    answer.world_from_camera.translation = {1, 2, 3};
    answer.pose_sensor = camera::RgbdSensor::kColor;
    return answer;
  };
  const base::SteadyClock clock;
  auto port =
      *MakeServerRelocalization(relocalizer, {.scene = "office"}, clock);
  EXPECT_FALSE(port->IsAsking());
  EXPECT_FALSE(port->TakeAnswer().has_value());
  port->Ask(SmallFrame(false), 20);
  EXPECT_TRUE(port->IsAsking());
  const auto answer = WaitFor(*port);
  ASSERT_TRUE(answer.has_value() && answer->ok());
  EXPECT_EQ((*answer)->inliers, 12);
  EXPECT_EQ((*answer)->stamp, SmallFrame(false).stamp);
  EXPECT_GT((*answer)->round_trip_s, 0);
  // Of the sensor that the calibration names: the depth camera.
  EXPECT_NEAR((*answer)->map_from_camera.translation.x, 1.03, 1e-12);
  EXPECT_FALSE(port->IsAsking());
  EXPECT_FALSE(port->TakeAnswer().has_value());
}

TEST(ServerRelocalization, ANewQuestionCancelsTheOldOne) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  std::atomic<int> calls = 0;
  absl::Notification first_is_there;
  relocalizer->localize = [&](const relocalizer::LocalizeQuery&,
                              const relocalizer::CallOptions& options)
      -> absl::StatusOr<relocalizer::LocalizeAnswer> {
    relocalizer::LocalizeAnswer answer;
    answer.inliers = ++calls;
    if (calls == 1) {
      first_is_there.Notify();
      while (!options.stop.stop_requested()) std::this_thread::yield();
      return absl::CancelledError("cancelled");
    }
    return answer;
  };
  const base::SteadyClock clock;
  auto port = *MakeServerRelocalization(relocalizer, {}, clock);
  port->Ask(SmallFrame(true), 20);
  first_is_there.WaitForNotification();
  port->Ask(SmallFrame(true), 20);
  const auto answer = WaitFor(*port);
  ASSERT_TRUE(answer.has_value() && answer->ok());
  EXPECT_EQ((*answer)->inliers, 2);
}

TEST(ServerRelocalization, TheDeadlineIsKeptThoughTheCallHangs) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  absl::Notification is_there;
  relocalizer->localize = [&is_there](const relocalizer::LocalizeQuery&,
                                      const relocalizer::CallOptions& options)
      -> absl::StatusOr<relocalizer::LocalizeAnswer> {
    is_there.Notify();
    while (!options.stop.stop_requested()) std::this_thread::yield();
    return absl::CancelledError("cancelled");
  };
  StepClock clock;
  auto port = *MakeServerRelocalization(relocalizer, {}, clock);
  port->Ask(SmallFrame(true), 3);
  is_there.WaitForNotification();
  clock.Advance(2999);
  EXPECT_FALSE(port->TakeAnswer().has_value());
  EXPECT_TRUE(port->IsAsking());
  clock.Advance(1);
  const auto answer = port->TakeAnswer();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->status().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_FALSE(port->IsAsking());
}

TEST(ServerRelocalization, CanGoAwayWhileItAsks) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  absl::Notification is_there;
  relocalizer->localize = [&is_there](const relocalizer::LocalizeQuery&,
                                      const relocalizer::CallOptions& options)
      -> absl::StatusOr<relocalizer::LocalizeAnswer> {
    is_there.Notify();
    while (!options.stop.stop_requested()) std::this_thread::yield();
    return absl::CancelledError("cancelled");
  };
  const base::SteadyClock clock;
  auto port = *MakeServerRelocalization(relocalizer, {}, clock);
  port->Ask(SmallFrame(true), 20);
  is_there.WaitForNotification();
  port.reset();
}

TEST(ServerRelocalization, SaysThatNobodyListens) {
  const base::SteadyClock clock;
  // Port 1 of this machine: nobody listens there.
  auto port = MakeServerRelocalization(
      relocalizer::ConnectOptions{.server = "127.0.0.1:1", .max_attempts = 1},
      "office", clock);
  ASSERT_TRUE(port.ok()) << port.status();
  (*port)->Ask(SmallFrame(true), 2);
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> answer;
  while (!answer.has_value()) {
    answer = (*port)->TakeAnswer();
    std::this_thread::yield();
  }
  EXPECT_TRUE(answer->status().code() == absl::StatusCode::kUnavailable ||
              answer->status().code() == absl::StatusCode::kDeadlineExceeded)
      << answer->status();
}

TEST(SynchronousRelocalization, HandsOverWhenTheRoundTripHasPassed) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  relocalizer->localize = [](const relocalizer::LocalizeQuery&,
                             const relocalizer::CallOptions&) {
    return relocalizer::LocalizeAnswer();
  };
  StepClock clock;
  auto port =
      *MakeSynchronousRelocalization(relocalizer, {}, clock, {.extra_s = 1.0});
  port->Ask(SmallFrame(true), 30);
  EXPECT_TRUE(port->IsAsking());
  clock.Advance(999);
  EXPECT_FALSE(port->TakeAnswer().has_value());
  // What the call itself took is far less than this.
  clock.Advance(20000);
  const auto answer = port->TakeAnswer();
  ASSERT_TRUE(answer.has_value() && answer->ok());
  EXPECT_GE((*answer)->round_trip_s, 1.0);
}

TEST(SynchronousRelocalization, TooSlowIsTooLate) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  relocalizer->localize = [](const relocalizer::LocalizeQuery&,
                             const relocalizer::CallOptions&) {
    return relocalizer::LocalizeAnswer();
  };
  StepClock clock;
  auto port =
      *MakeSynchronousRelocalization(relocalizer, {}, clock, {.extra_s = 60});
  port->Ask(SmallFrame(true), 3);
  clock.Advance(2999);
  EXPECT_FALSE(port->TakeAnswer().has_value());
  clock.Advance(1);
  const auto answer = port->TakeAnswer();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST(SynchronousRelocalization, AnswersInAFixedTimeHoweverLongItTook) {
  auto relocalizer = std::make_shared<FakeRelocalizer>();
  std::chrono::milliseconds timeout{0};
  absl::Status status;
  relocalizer->localize = [&](const relocalizer::LocalizeQuery&,
                              const relocalizer::CallOptions& call)
      -> absl::StatusOr<relocalizer::LocalizeAnswer> {
    timeout = call.timeout;
    if (!status.ok()) return status;
    return relocalizer::LocalizeAnswer();
  };
  StepClock clock;
  auto port = *MakeSynchronousRelocalization(
      relocalizer, {}, clock, {.latency_s = 0.5, .real_timeout_s = 60});
  port->Ask(SmallFrame(true), 3);
  EXPECT_EQ(timeout, std::chrono::seconds(60));
  clock.Advance(499);
  EXPECT_FALSE(port->TakeAnswer().has_value());
  clock.Advance(1);
  auto answer = port->TakeAnswer();
  ASSERT_TRUE(answer.has_value() && answer->ok());
  EXPECT_EQ((*answer)->round_trip_s, 0.5);
  // A server that does not answer is waited for as long as the robot would.
  status = absl::DeadlineExceededError("silent");
  port->Ask(SmallFrame(true), 3);
  clock.Advance(2999);
  EXPECT_FALSE(port->TakeAnswer().has_value());
  clock.Advance(1);
  answer = port->TakeAnswer();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->status().code(), absl::StatusCode::kDeadlineExceeded);
}

}  // namespace
}  // namespace treeline::relocalization
