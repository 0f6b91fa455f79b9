// A lost robot whose camera is a recording: it is carried from one place of the
// sequence to another and asks, over the agent's own port, a server process.
// Measures the whole path: JPEG, PNG, socket, server, and back.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/relocalizer/connect_options.h"
#include "common/base/clock.h"
#include "gtest/gtest.h"
#include "nav_agent/app/relocalization/server_relocalization.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;

// As RelocalizationBehaviorOptions has it.
constexpr double kDeadline_s = 3;
// What a robot may be told wrong and still drive on.
constexpr double kRight_m = 0.5;
constexpr double kRight_deg = 20;
// From the confidence on of which one answer is enough.
constexpr double kSure = 0.9;

struct Ride {
  int asked = 0;
  int answered = 0;
  int localized = 0;
  int sure = 0;
  int wrong = 0;
  int sure_and_wrong = 0;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  std::vector<double> round_trips_ms;
};

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<size_t>(std::ceil(share * last))];
}

// The frames in an order that jumps: neighbours are a third of the sequence
// apart, so that each question comes from elsewhere than the one before.
std::vector<int> Jumps(int frames) {
  std::vector<int> order;
  const int third = (frames + 2) / 3;
  for (int i = 0; i < third; ++i) {
    for (int j = i; j < frames; j += third) order.push_back(j);
  }
  return order;
}

std::optional<absl::StatusOr<core::RelocalizationAnswer>> WaitFor(
    core::RelocalizationPort& port) {
  // As the robot does, step by step; the port has a deadline of its own.
  while (port.IsAsking()) {
    if (auto answer = port.TakeAnswer(); answer.has_value()) return answer;
    std::this_thread::yield();
  }
  return std::nullopt;
}

Ride RideThrough(const dataset::Dataset& frames, const std::vector<int>& order,
                 core::RelocalizationPort& port, const base::Clock& clock) {
  Ride ride;
  for (const int i : order) {
    auto loaded = frames.Load(i);
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    const std::optional<geometry::Rigid3>& truth =
        frames.frame(i).world_from_camera;
    if (!loaded.ok() || !truth.has_value()) continue;
    core::RgbdFrame frame;
    frame.stamp = clock.Now();
    frame.frame = *std::move(loaded);
    port.Ask(frame, kDeadline_s);
    ++ride.asked;
    const auto answer = WaitFor(port);
    if (!answer.has_value() || !answer->ok()) continue;
    ++ride.answered;
    EXPECT_EQ((*answer)->stamp, frame.stamp);
    ride.round_trips_ms.push_back(1e3 * (*answer)->round_trip_s);
    if (!(*answer)->localized) continue;
    ++ride.localized;
    const geometry::Rigid3 off = truth->Inverse() * (*answer)->map_from_camera;
    const double error_m = geometry::Norm(off.translation);
    const double error_deg =
        2 * std::acos(std::min(1.0, std::abs(off.rotation.w))) * 57.29578;
    const bool is_wrong = error_m > kRight_m || error_deg > kRight_deg;
    const bool is_sure = (*answer)->confidence >= kSure;
    ride.wrong += is_wrong ? 1 : 0;
    ride.sure += is_sure ? 1 : 0;
    ride.sure_and_wrong += is_sure && is_wrong ? 1 : 0;
    ride.errors_m.push_back(error_m);
    ride.errors_deg.push_back(error_deg);
  }
  return ride;
}

void Print(const char* name, const Ride& ride) {
  std::printf(
      "%s: %d asked, %d answered, %d localized, %d sure, %d wrong (%d sure); "
      "error p50 %.1f cm %.2f deg, worst %.1f cm %.2f deg; round trip p50 %.0f "
      "p95 %.0f p99 %.0f ms\n",
      name, ride.asked, ride.answered, ride.localized, ride.sure, ride.wrong,
      ride.sure_and_wrong, 100 * Percentile(ride.errors_m, 0.5),
      Percentile(ride.errors_deg, 0.5), 100 * Percentile(ride.errors_m, 1),
      Percentile(ride.errors_deg, 1), Percentile(ride.round_trips_ms, 0.5),
      Percentile(ride.round_trips_ms, 0.95),
      Percentile(ride.round_trips_ms, 0.99));
}

class CameraRecording : public ServerTest {
 protected:
  Ride Kidnap(const dataset::Dataset& frames, const std::string& scene) {
    const base::SteadyClock clock;
    auto port = relocalization::MakeServerRelocalization(
        relocalizer::ConnectOptions{.server = address_}, scene, clock);
    EXPECT_TRUE(port.ok()) << port.status();
    return RideThrough(frames, Jumps(frames.size()), **port, clock);
  }
};

TEST_F(CameraRecording, JumpsInTheRoomAreFound) {
  PutRoom();
  ASSERT_NO_FATAL_FAILURE(StartServer());
  const dataset::Dataset frames = HeldOutFrames();
  const Ride ride = Kidnap(frames, "room");
  Print("room", ride);
  EXPECT_EQ(ride.asked, frames.size());
  EXPECT_EQ(ride.answered, ride.asked);
  EXPECT_EQ(ride.sure_and_wrong, 0);
  // A small forest; what it does not know it must say.
  EXPECT_GE(2 * ride.localized, ride.asked);
}

TEST_F(CameraRecording, ASceneThatTheServerDoesNotHaveIsNotFound) {
  PutRoom();
  ASSERT_NO_FATAL_FAILURE(StartServer());
  const dataset::Dataset frames = HeldOutFrames();
  const Ride ride = Kidnap(frames.Subset(std::vector<int>{0}), "kitchen");
  EXPECT_EQ(ride.asked, 1);
  EXPECT_EQ(ride.answered, 0);
}

class RedKitchen : public CameraRecording {};

TEST_F(RedKitchen, JumpsInTheKitchenAreFoundAndNoneIsWrong) {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string folder =
      std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) +
      "/7scenes-redkitchen";
  if (!fs::is_directory(folder)) {
    GTEST_SKIP() << "no 7scenes-redkitchen in TREELINE_DATA";
  }
  // A model that is there already saves the training.
  const char* trained = std::getenv("TREELINE_KITCHEN_MODEL");
  const std::string model = models_ + "/redkitchen/1/model.treeline";
  if (trained != nullptr) {
    fs::create_directories(fs::path(model).parent_path());
    fs::create_symlink(trained, model);
  } else {
    const ProgramResult training = RunProgram(
        {TREELINE_PROGRAM, "train", "--dataset", "7scenes:" + folder,
         "--frames", folder + "/train.txt", "--poses",
         folder + "/poses-sfm.txt", "--trees", "3", "--frames-per-tree", "150",
         "--samples-per-frame", "300", "--quiet", "--output", model});
    ASSERT_EQ(training.exit_code, 0) << training.err;
  }
  ASSERT_NO_FATAL_FAILURE(StartServer());
  const auto frames =
      dataset::Dataset::Open({.uri = "7scenes:" + folder,
                              .frame_list = folder + "/test.txt",
                              .pose_file = folder + "/poses-sfm.txt"});
  ASSERT_TRUE(frames.ok()) << frames.status();
  const Ride ride = Kidnap(*frames, "redkitchen");
  Print("redkitchen", ride);
  EXPECT_EQ(ride.asked, frames->size());
  EXPECT_EQ(ride.answered, ride.asked);
  EXPECT_GE(ride.localized, 0.98 * ride.asked);
  EXPECT_EQ(ride.wrong, 0);
  EXPECT_LT(Percentile(ride.errors_m, 0.5), 0.03);
}

}  // namespace
}  // namespace treeline
