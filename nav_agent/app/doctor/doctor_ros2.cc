#include "nav_agent/app/doctor/doctor_ros2.h"

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/app/ros/ros_robot.h"

namespace treeline::doctor_app {
namespace {

constexpr auto kLookUp = std::chrono::milliseconds(10);
// Fewer are too few to be guided by.
constexpr double kFewReadings_hz = 10;
constexpr const char* kHowTo =
    "docs/how-to/drive-a-ros2-robot.md has the messages and what to do";

Finding Fails(const char* what, absl::string_view found, const char* mend) {
  return {.what = what,
          .verdict = Verdict::kFail,
          .found = std::string(found),
          .mend = mend};
}

// True as long as `seconds` of real time have not passed since `begin`.
bool IsWithin(base::MonotonicTime begin, double seconds,
              const base::Clock& clock) {
  return base::SecondsBetween(begin, clock.Now()) < seconds;
}

// "": all is known.
absl::StatusOr<std::string> WaitFor(ros_app::RosRobot& robot, double seconds,
                                    const base::Clock& clock,
                                    const std::stop_token& stop) {
  const base::MonotonicTime begin = clock.Now();
  absl::StatusOr<std::string> missing = robot.Missing();
  while (missing.ok() && !missing->empty() && !stop.stop_requested() &&
         IsWithin(begin, seconds, clock)) {
    std::this_thread::sleep_for(kLookUp);
    missing = robot.Missing();
  }
  return missing;
}

Finding JudgeOdometry(const ros_app::RosRobotConfig& config, int64_t readings,
                      double seconds, const core::DeviceHealth& health) {
  const double hz = static_cast<double>(readings) / seconds;
  Finding finding{
      .what = absl::StrCat("odometry: ", config.odom),
      .verdict = Verdict::kOk,
      .found = absl::StrFormat("%.1f Hz; %d refused", hz, health.corrupt),
      .mend = ""};
  if (hz < kFewReadings_hz || health.corrupt > 0) {
    finding.verdict = Verdict::kWarn;
    finding.mend =
        "50 Hz are usual; the log of `run` says why some are refused";
  }
  return finding;
}

Finding JudgeVelocities(const ros_app::RosRobotConfig& config,
                        const core::DeviceHealth& health) {
  if (health.state == core::DeviceState::kRunning) {
    return {.what = absl::StrCat("velocities: ", config.cmd_vel),
            .verdict = Verdict::kOk,
            .found = "somebody listens",
            .mend = ""};
  }
  return Fails("velocities", health.cause.message(), kHowTo);
}

}  // namespace

std::vector<Finding> ExamineRos2(const std::string& path, double listen_s,
                                 const std::stop_token& stop) {
  const absl::StatusOr<ros_app::RosRobotConfig> config =
      ros_app::ReadRosRobotConfig(path);
  if (!config.ok()) {
    return {Fails("robot", config.status().message(),
                  "mend the file; docs/reference/ros2-robot.md has the keys")};
  }
  const base::SteadyClock clock;
  const auto robot = ros_app::RosRobot::Open(*config, /*drives=*/true, clock,
                                             [](const std::string&) {});
  if (!robot.ok()) return {Fails("robot", robot.status().message(), kHowTo)};
  const auto missing = WaitFor(**robot, listen_s, clock, stop);
  if (!missing.ok()) {
    return {Fails("robot", missing.status().message(), kHowTo)};
  }
  if (!missing->empty()) return {Fails("robot", *missing, kHowTo)};
  std::vector<Finding> findings = {
      {.what = "robot",
       .verdict = Verdict::kOk,
       .found = absl::StrCat("is heard in domain ", (*robot)->domain().id(),
                             ", and tells where its sensors are"),
       .mend = ""}};
  // What came meanwhile does not count.
  HeardLaser laser;
  int64_t readings = 0;
  (*robot)->laser().TakeScans();
  (*robot)->odometry().TakeReadings();
  const base::MonotonicTime begin = clock.Now();
  while (!stop.stop_requested() && IsWithin(begin, listen_s, clock)) {
    std::this_thread::sleep_for(kLookUp);
    for (core::LaserScan& scan : (*robot)->laser().TakeScans()) {
      laser.scans.push_back(std::move(scan));
    }
    readings +=
        static_cast<int64_t>((*robot)->odometry().TakeReadings().size());
  }
  laser.name = absl::StrCat("laser: ", config->scan);
  laser.info = (*robot)->laser().Info();
  laser.health = (*robot)->laser().Health();
  laser.seconds = base::SecondsBetween(begin, clock.Now());
  // Many drivers do not say how often they scan, and a simulation has its own
  // time.
  if (!laser.scans.empty() &&
      (config->use_sim_time || !(laser.info.scan_interval_s > 0))) {
    laser.info.scan_interval_s =
        laser.seconds / static_cast<double>(laser.scans.size());
  }
  for (Finding& finding : JudgeLaser(laser)) {
    findings.push_back(std::move(finding));
  }
  findings.push_back(JudgeOdometry(*config, readings, laser.seconds,
                                   (*robot)->odometry().Health()));
  findings.push_back(JudgeVelocities(*config, (*robot)->base().Health()));
  return findings;
}

}  // namespace treeline::doctor_app
