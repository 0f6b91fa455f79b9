#include "nav_agent/app/run/ros_agent_robot.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::run_app {
namespace {

// A simulation that is paused is looked at so often; its robot is told to stand
// and a stop is heard.
constexpr auto kPatience = std::chrono::milliseconds(50);
constexpr auto kLookUp = std::chrono::milliseconds(1);

}  // namespace

absl::StatusOr<std::unique_ptr<RosAgentRobot>> RosAgentRobot::Open(
    const std::string& config_path, const base::Clock& real_clock,
    ros_app::RosRobot::Warn warn,
    const std::function<void(const std::string& line)>& announce) {
  TL_ASSIGN_OR_RETURN(const ros_app::RosRobotConfig config,
                      ros_app::ReadRosRobotConfig(config_path));
  TL_ASSIGN_OR_RETURN(std::unique_ptr<ros_app::RosRobot> robot,
                      ros_app::RosRobot::Open(config, /*drives=*/true,
                                              real_clock, std::move(warn)));
  announce(absl::StrCat("ros2 in domain ", robot->domain().id()));
  return std::unique_ptr<RosAgentRobot>(new RosAgentRobot(std::move(robot)));
}

void RosAgentRobot::Advance(std::chrono::nanoseconds duration) {
  const robot_ports::RosTime& time = robot_->time();
  if (!time.is_simulated()) return;
  const base::MonotonicTime now = time.Now();
  // What was missed is not made up for.
  due_ = std::max(due_ + duration, now);
  const auto patience = std::chrono::steady_clock::now() + kPatience;
  while (time.Now() < due_ && std::chrono::steady_clock::now() < patience) {
    std::this_thread::sleep_for(kLookUp);
  }
}

}  // namespace treeline::run_app
