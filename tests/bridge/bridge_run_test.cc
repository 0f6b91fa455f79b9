// The bridge and a robot in another process (robot_player.cc) that know each
// other over DDS alone: found at the start, carried away, found again.
#include "nav_agent/app/bridge/bridge_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "nav_agent/bridge/dds/testing_domain.h"
#include "nav_agent/core/robot_model.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

// A server that reads the truth in the pictures of the player.
class TruthfulServer final : public core::RelocalizationPort {
 public:
  void Ask(const core::RgbdFrame& frame, double /*timeout_s*/) override {
    core::RelocalizationAnswer answer;
    answer.stamp = frame.stamp;
    answer.localized = true;
    answer.confidence = 0.97;
    std::array<double, 3> truth{};
    if (frame.frame.color.rgb.size() == sizeof(truth)) {
      std::memcpy(truth.data(), frame.frame.color.rgb.data(), sizeof(truth));
    }
    const geometry::Rigid3 map_from_base = {
        .rotation = geometry::Rotation3::FromAxisAngle({0, 0, truth[2]}),
        .translation = {truth[0], truth[1], 0}};
    answer.map_from_camera =
        map_from_base * core::RobotModel::UprightCamera({0.1, 0, 1}, 0.2);
    for (size_t i = 0; i < 6; ++i) answer.covariance[7 * i] = 1e-4;
    answer_ = answer;
  }
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> TakeAnswer()
      override {
    auto answer = std::exchange(answer_, std::nullopt);
    if (!answer.has_value()) return std::nullopt;
    return *answer;
  }
  bool IsAsking() const override { return answer_.has_value(); }
  void Cancel() override { answer_.reset(); }

 private:
  std::optional<core::RelocalizationAnswer> answer_;
};

// The numbers of "place off 0.012 m 0.003 rad".
std::pair<double, double> OffOf(const std::string& line) {
  double m = 0;
  double rad = 0;
  EXPECT_EQ(std::sscanf(line.c_str(), "place off %lf m %lf rad", &m, &rad), 2)
      << line;
  return {m, rad};
}

TEST(BridgeRunTest, ARobotOverDdsAloneIsFoundCarriedAwayAndFoundAgain) {
  const int domain = dds::TestingDomain();
  bridge_app::BridgeConfig config;
  config.domain_id = domain;
  config.interface = "lo";
  config.server = "in this process";
  config.name_space = "robot1";
  config.image = "camera/image_raw/compressed";
  config.remap = {"odom:=/robot1/odom"};
  TruthfulServer server;
  const auto log =
      logging::LogToStandardError("bridge_run_test", logging::LogFormat::kText);
  absl::Status status;
  std::jthread bridge([&](const std::stop_token& stop) {
    status = bridge_app::RunBridge(
        config, {}, server, *log, [](const std::string&) {}, stop);
  });
  Process player({TREELINE_ROBOT_PLAYER, std::to_string(domain), "90", "8",
                  "181", "20000", "/robot1"});
  const auto first = player.WaitForLine("place off");
  ASSERT_TRUE(first.has_value()) << player.err();
  // Centimetres of way pass between the odometry and the player's reading, and
  // the gate's search moves by steps of 5 cm and 0.02 rad.
  EXPECT_LT(OffOf(*first).first, 0.2);
  EXPECT_LT(OffOf(*first).second, 0.15);
  ASSERT_TRUE(player.WaitForLine("kidnapped").has_value()) << player.err();
  // What is printed after that is of the robot that was carried away.
  std::string again;
  for (int i = 0; i < 600 && again.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const std::string out = player.out();
    const size_t from = out.find("kidnapped");
    const size_t line = out.find("place off", from);
    if (line != std::string::npos && out.find('\n', line) != std::string::npos)
      again = out.substr(line, out.find('\n', line) - line);
  }
  ASSERT_FALSE(again.empty()) << player.out() << player.err();
  EXPECT_LT(OffOf(again).first, 0.2);
  EXPECT_LT(OffOf(again).second, 0.15);
  bridge.request_stop();
  bridge.join();
  EXPECT_TRUE(status.ok()) << status;
}

}  // namespace
}  // namespace treeline
