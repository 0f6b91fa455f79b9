#include "nav_agent/app/map/live_drive.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/hardware/robot_hardware.h"
#include "nav_agent/app/ros/ros_robot.h"
#include "simulation/simulator/paced_runner.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/scenario_reader.h"

namespace treeline::map_app {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(25);
constexpr auto kStatusEvery = std::chrono::seconds(1);

// A drive that goes on outside: real, or simulated.
class Drive {
 public:
  virtual ~Drive() = default;
  virtual LiveSensors Sensors() = 0;
  // Lets a little time pass. False at the end.
  virtual bool Wait() = 0;
};

class RealDrive final : public Drive {
 public:
  static absl::StatusOr<std::unique_ptr<Drive>> Open(
      const LiveMappingOptions& options) {
    auto drive = std::make_unique<RealDrive>();
    hardware::HardwareConfig config = {.laser = options.laser,
                                       .base = options.base,
                                       .rear_laser = {},
                                       .camera = options.camera,
                                       .robot = options.robot};
    if (!options.hardware.empty()) {
      TL_ASSIGN_OR_RETURN(config,
                          hardware::ReadHardwareConfig(options.hardware));
      // Maps are made of the laser ahead.
      config.rear_laser.clear();
    }
    drive->robot_ = config.robot;
    drive->correction_ = config.correction;
    if (options.seconds > 0) {
      drive->end_ = drive->clock_.Now() +
                    std::chrono::duration_cast<base::MonotonicTime::duration>(
                        std::chrono::duration<double>(options.seconds));
    }
    TL_ASSIGN_OR_RETURN(drive->hardware_,
                        hardware::RobotHardware::Open(config, drive->clock_));
    return drive;
  }

  LiveSensors Sensors() override {
    return {.laser = hardware_->laser(),
            .odometry = hardware_->base(),
            .camera = hardware_->camera(),
            .robot = robot_,
            .correction = correction_};
  }
  bool Wait() override {
    std::this_thread::sleep_for(kPoll);
    return !end_.has_value() || clock_.Now() < *end_;
  }

 private:
  base::SteadyClock clock_;
  core::RobotModel robot_;
  core::SensorCorrection correction_;
  std::optional<base::MonotonicTime> end_;
  std::unique_ptr<hardware::RobotHardware> hardware_;
};

// Somebody else drives; we listen.
class RosDrive final : public Drive {
 public:
  static absl::StatusOr<std::unique_ptr<Drive>> Open(
      const LiveMappingOptions& options, const std::stop_token& stop) {
    TL_ASSIGN_OR_RETURN(const ros_app::RosRobotConfig config,
                        ros_app::ReadRosRobotConfig(options.ros2));
    auto drive = std::make_unique<RosDrive>();
    TL_ASSIGN_OR_RETURN(
        drive->robot_,
        ros_app::RosRobot::Open(config, /*drives=*/false, drive->clock_,
                                [](const std::string& line) {
                                  std::fprintf(stderr, "%s\n", line.c_str());
                                }));
    TL_RETURN_IF_ERROR(drive->robot_->WaitUntilKnown(stop));
    if (stop.stop_requested()) {
      return absl::CancelledError(
          "nothing was recorded: it was ended before the robot was known");
    }
    drive->end_ = options.seconds > 0
                      ? drive->robot_->time().Now() +
                            simulator::FromSeconds(options.seconds)
                      : base::MonotonicTime::max();
    return drive;
  }

  LiveSensors Sensors() override {
    return {.laser = robot_->laser(),
            .odometry = robot_->odometry(),
            .camera = robot_->camera(),
            .robot = robot_->model(),
            .correction = robot_->config().correction};
  }
  bool Wait() override {
    std::this_thread::sleep_for(kPoll);
    return robot_->time().Now() < end_;
  }

 private:
  base::SteadyClock clock_;
  std::unique_ptr<ros_app::RosRobot> robot_;
  base::MonotonicTime end_;
};

class SimulatedDrive final : public Drive {
 public:
  static absl::StatusOr<std::unique_ptr<Drive>> Open(
      const LiveMappingOptions& options) {
    simulator::Scenario scenario;
    if (!options.scenario.empty()) {
      TL_ASSIGN_OR_RETURN(scenario, simulator::ReadScenario(options.scenario));
    }
    scenario.world = options.simulate;
    scenario.options.seed = options.seed;
    const bool has_camera = options.camera != "none";
    scenario.options.sensors.camera_hz =
        has_camera ? 1 / options.map.frame_interval_s : 0;
    scenario.world_options.paint = has_camera;
    TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
    TL_ASSIGN_OR_RETURN(
        std::unique_ptr<simulator::Simulator> simulator,
        simulator::Simulator::Create(std::move(world), scenario.options));
    simulator::TourAction tour;
    tour.options.speed_mps = options.speed_mps;
    TL_RETURN_IF_ERROR(tour.options.Validate());
    return std::make_unique<SimulatedDrive>(scenario, std::move(simulator),
                                            tour, options);
  }

  SimulatedDrive(const simulator::Scenario& scenario,
                 std::unique_ptr<simulator::Simulator> simulator,
                 const simulator::TourAction& tour,
                 const LiveMappingOptions& options)
      : simulator_(std::move(simulator)),
        player_(scenario, *simulator_),
        pace_(options.pace),
        end_(options.seconds > 0 ? simulator::FromSeconds(options.seconds)
                                 : simulator::SimTime::max()) {
    player_.DriveTour(tour);
  }

  LiveSensors Sensors() override {
    return {.laser = simulator_->laser(),
            .odometry = simulator_->odometry(),
            .camera = simulator_->options().sensors.camera_hz > 0
                          ? &simulator_->camera()
                          : nullptr,
            .robot = simulator_->options().robot};
  }
  bool Wait() override {
    const simulator::SimTime due = pace_.Due(real_clock_.Now());
    if (due > simulator::SimTime(0)) {
      // No more than the sensors keep for us.
      player_.Step(std::min<simulator::SimTime>(due, kPoll));
    } else {
      std::this_thread::sleep_for(pace_.Wait(real_clock_.Now()));
    }
    return !player_.is_tour_done() && !simulator_->state().is_fallen &&
           simulator_->now() < end_;
  }

 private:
  base::SteadyClock real_clock_;
  std::unique_ptr<simulator::Simulator> simulator_;
  simulator::ScenarioPlayer player_;
  simulator::Pace pace_;
  simulator::SimTime end_;
};

absl::StatusOr<std::unique_ptr<Drive>> OpenDrive(
    const LiveMappingOptions& options, const std::stop_token& stop) {
  if (!options.ros2.empty()) return RosDrive::Open(options, stop);
  return options.simulate.empty() ? RealDrive::Open(options)
                                  : SimulatedDrive::Open(options);
}

}  // namespace

absl::Status LiveMappingOptions::Validate() const {
  const bool has_devices = !(laser.empty() && base.empty());
  if (simulate.empty() && ros2.empty() && hardware.empty() &&
      (laser.empty() || base.empty())) {
    return absl::InvalidArgumentError(
        "who drives? Give --simulate WORLD, a robot that speaks ROS 2: --ros2 "
        "FILE, or the devices of a robot: --hardware FILE, or --laser ADDRESS "
        "--base ADDRESS");
  }
  if (int{!simulate.empty()} + int{!ros2.empty()} + int{!hardware.empty()} +
          int{has_devices} !=
      1) {
    return absl::InvalidArgumentError(
        "give one of --simulate, --ros2, --hardware, and --laser with --base");
  }
  if (camera != "none" && camera != "openni" &&
      !(camera == "simulated" && !simulate.empty())) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", camera,
                     "' is no camera; there are none, openni and, with "
                     "--simulate, simulated"));
  }
  if (!scenario.empty() && simulate.empty()) {
    return absl::InvalidArgumentError("--scenario is for --simulate");
  }
  if (!(pace > 0))
    return absl::InvalidArgumentError("the pace must be above 0");
  return absl::OkStatus();
}

absl::Status RecordLiveDrive(const LiveMappingOptions& options,
                             const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<Drive> drive,
                      OpenDrive(options, stop));
  const base::SteadyClock clock;
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<LiveMapper> mapper,
                      LiveMapper::Create(drive->Sensors(), options.map, clock));
  base::MonotonicTime next_status = clock.Now() + kStatusEvery;
  bool goes_on = true;
  while (goes_on && !stop.stop_requested()) {
    goes_on = drive->Wait();
    TL_RETURN_IF_ERROR(mapper->Poll());
    if (options.status && clock.Now() >= next_status) {
      next_status += kStatusEvery;
      options.status(mapper->Status());
    }
  }
  return mapper->Finish();
}

}  // namespace treeline::map_app
