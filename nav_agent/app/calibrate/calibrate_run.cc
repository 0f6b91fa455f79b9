#include "nav_agent/app/calibrate/calibrate_run.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>
#include <variant>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/app/calibrate/calibration_picture.h"
#include "nav_agent/app/calibrate/camera_views.h"
#include "nav_agent/app/hardware/robot_hardware.h"
#include "nav_agent/calibration/calibration_text.h"
#include "nav_agent/calibration/robot_file_edit.h"
#include "nav_agent/calibration/wheel_path.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/ros_log/convert_log.h"

namespace treeline::calibrate_app {
namespace {

using calibration::Calibration;
using calibration::Drive;
using calibration::FileEntry;
using calibration::Setup;

absl::StatusOr<Drive> ReadDrive(const std::string& log,
                                ros_log::BagLogOptions bag,
                                std::vector<std::string>& notes) {
  bag.with_frames = false;
  calibration::DriveBuilder builder;
  TL_ASSIGN_OR_RETURN(
      ros_log::ConvertedLog read,
      ros_log::ReadAnyLog(log, bag, [&](const recording::LogEntry& entry) {
        builder.Take(entry);
        return absl::OkStatus();
      }));
  auto drive = builder.Build();
  if (!drive.ok()) return base::Annotate(drive.status(), log);
  for (std::string& note : read.notes) notes.push_back(std::move(note));
  for (const std::string& note : drive->notes) notes.push_back(note);
  if (read.from == "laser log") {
    notes.emplace_back(
        "a laser log tells poses, not wheels: left, right and track are those "
        "of wheels 0.54 m apart that would have made them");
  }
  return drive;
}

bool IsHardwareFile(const yaml::YamlNode& file) { return file.Has("base"); }

Setup SetupOf(const core::RobotModel& robot,
              const core::SensorCorrection& correction) {
  Setup setup = calibration::AssumedSetup(robot);
  setup.wheels.left_scale = correction.left_scale;
  setup.wheels.right_scale = correction.right_scale;
  setup.laser_delay_s = correction.laser_delay_s;
  return setup;
}

// Those of the laser that looks back: its place.
void AddRear(std::vector<FileEntry> rear, std::vector<FileEntry>& entries) {
  for (FileEntry& entry : rear) {
    const bool is_flat =
        absl::StartsWith(entry.key, "laser_") && entry.key != "laser_delay_s";
    if (entry.section == "laser") {
      entry.section = "rear_laser";
    } else if (entry.section.empty() && is_flat) {
      entry.key = "rear_" + entry.key;
    } else {
      continue;
    }
    entries.push_back(std::move(entry));
  }
}

// Wheels and laser say how the base moved; pictures how the camera did.
absl::StatusOr<calibration::CameraCalibration> CalibrateCameraOf(
    const CalibrateOptions& options, const Drive& drive, const Setup& found,
    const geometry::Rigid3& assumed, const std::stop_token& stop) {
  ros_log::BagLogOptions bag = options.bag;
  bag.with_frames = true;
  TL_ASSIGN_OR_RETURN(const CameraViews seen,
                      ViewsOfLog(options.log, bag, drive, stop));
  TL_ASSIGN_OR_RETURN(
      const calibration::CameraCalibration looks,
      calibration::CalibrateCamera(drive, found, seen.views, {}, assumed));
  // The floor is looked for where it is with the camera's own rotation.
  TL_ASSIGN_OR_RETURN(
      const std::vector<double> heights_m,
      HeightsOfLog(options.log, bag, looks.BaseFromCamera().rotation));
  return calibration::CalibrateCamera(drive, found, seen.views, heights_m,
                                      assumed);
}

std::vector<FileEntry> EntriesFor(const CalibrateResult& result,
                                  bool is_hardware, double laser_z_m,
                                  double rear_z_m) {
  std::vector<FileEntry> entries =
      is_hardware
          ? calibration::HardwareFileEntries(result.calibration)
          : calibration::RobotFileEntries(result.calibration, laser_z_m);
  if (result.rear) {
    AddRear(is_hardware ? calibration::HardwareFileEntries(*result.rear)
                        : calibration::RobotFileEntries(*result.rear, rear_z_m),
            entries);
  }
  if (result.camera) {
    const auto camera = is_hardware
                            ? calibration::CameraHardwareEntries(*result.camera)
                            : calibration::CameraFileEntries(*result.camera);
    entries.insert(entries.end(), camera.begin(), camera.end());
  }
  return entries;
}

// Changes the file, and checks that a robot can still be read of it.
absl::Status WriteInto(const std::string& path, CalibrateResult& result) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path, 65536));
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                      yaml::YamlNode::Parse(text, path));
  const bool is_hardware = IsHardwareFile(file);
  double laser_z_m = 0;
  double rear_z_m = 0;
  if (!is_hardware) {
    TL_ASSIGN_OR_RETURN(const core::RobotDescription robot,
                        core::ParseRobot(text, path));
    laser_z_m = robot.model.base_from_laser.translation.z;
    rear_z_m = robot.model.base_from_rear_laser.translation.z;
  }
  const std::vector<FileEntry> entries =
      EntriesFor(result, is_hardware, laser_z_m, rear_z_m);
  result.yaml = calibration::EntriesYaml(entries, "what was changed");
  TL_ASSIGN_OR_RETURN(const std::string edited,
                      calibration::WithEntries(text, path, entries));
  if (!is_hardware) {
    const auto robot = core::ParseRobot(edited, path);
    if (!robot.ok()) {
      return absl::FailedPreconditionError(
          absl::StrCat(path,
                       " was not changed, since then it would be no "
                       "robot's: ",
                       robot.status().message()));
    }
  }
  return base::WriteFileAtomically(path, edited);
}

// Laser logs do not say how high the laser is.
double HeightOr_m(double height_m, double otherwise_m) {
  return height_m > 0 ? height_m : otherwise_m;
}

// A robot's file or name, or a file of --hardware.
absl::StatusOr<core::RobotDescription> ReadEitherFile(
    const std::string& robot) {
  if (absl::EndsWith(robot, ".yaml") || absl::StrContains(robot, "/")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode file, yaml::YamlNode::Read(robot));
    if (IsHardwareFile(file)) {
      TL_ASSIGN_OR_RETURN(const hardware::HardwareConfig config,
                          hardware::ReadHardwareConfig(robot));
      return core::RobotDescription{.name = robot,
                                    .model = config.robot,
                                    .lasers = {},
                                    .correction = config.correction};
    }
  }
  return core::ReadRobot(robot);
}

absl::StatusOr<geometry::Rigid3> ReadCameraMount(const std::string& robot) {
  TL_ASSIGN_OR_RETURN(const core::RobotDescription description,
                      ReadEitherFile(robot));
  return description.model.base_from_camera;
}

std::string RobotYaml(const CalibrateOptions& options,
                      const CalibrateResult& result, const Drive& drive) {
  const core::RobotModel usual;
  const auto& front = drive.robot.base_from_laser.translation;
  const auto& rear = drive.robot.base_from_rear_laser.translation;
  return calibration::EntriesYaml(
      EntriesFor(result, false,
                 HeightOr_m(front.z, usual.base_from_laser.translation.z),
                 HeightOr_m(rear.z, usual.base_from_rear_laser.translation.z)),
      absl::StrCat("treeline-agent calibrate ", options.log));
}

absl::Status WriteAll(const CalibrateOptions& options, const Drive& drive,
                      CalibrateResult& result) {
  if (!options.yaml.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(options.yaml, result.yaml));
  }
  if (!options.json.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        options.json, calibration::CalibrationJson(result.calibration) + "\n"));
  }
  if (!options.picture.empty()) {
    TL_ASSIGN_OR_RETURN(const std::string png, image::EncodePng(DrawCalibration(
                                                   drive, result.calibration)));
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(options.picture, png));
  }
  if (!options.corrected.empty()) {
    const calibration::WheelPath path(drive.readings, drive.longest_gap_s);
    TL_RETURN_IF_ERROR(WriteCorrectedLog(
        options, result.calibration,
        path.HasGyroscope(drive.robot.wheel_track_m), options.corrected));
  }
  if (!options.write.empty()) return WriteInto(options.write, result);
  return absl::OkStatus();
}

// Corrects entries one by one.
class Corrector {
 public:
  Corrector(const Setup& found, bool has_gyroscope)
      : found_(found),
        has_gyroscope_(has_gyroscope),
        delay_(std::chrono::duration_cast<base::MonotonicTime::duration>(
            std::chrono::duration<double>(found.laser_delay_s))) {}

  void Correct(recording::LogEntry& entry) {
    if (auto* robot = std::get_if<core::RobotModel>(&entry)) {
      CorrectRobot(*robot);
    } else if (auto* scan = std::get_if<core::LaserScan>(&entry)) {
      scan->stamp -= delay_;
    } else if (auto* reading = std::get_if<core::BaseReading>(&entry)) {
      CorrectReading(*reading);
    }
  }

  void CorrectRobot(core::RobotModel& robot) const {
    robot.wheel_track_m = found_.wheels.track_m;
    // Wheels stand out of no body.
    robot.half_width_m =
        std::max(robot.half_width_m, found_.wheels.track_m / 2);
    robot.base_from_laser = {
        .rotation = geometry::Rotation3::FromAxisAngle(
            {0, 0, found_.base_from_laser.yaw_rad}),
        .translation = {found_.base_from_laser.translation.x,
                        found_.base_from_laser.translation.y,
                        robot.base_from_laser.translation.z}};
  }

 private:
  void CorrectReading(core::BaseReading& reading) {
    reading.left_wheel_m *= found_.wheels.left_scale;
    reading.right_wheel_m *= found_.wheels.right_scale;
    if (!has_gyroscope_) {
      const double interval_s =
          last_ ? base::SecondsBetween(last_->stamp, reading.stamp) : 0;
      reading.yaw_rate_radps =
          interval_s > 0 ? ((reading.right_wheel_m - last_->right_wheel_m) -
                            (reading.left_wheel_m - last_->left_wheel_m)) /
                               (found_.wheels.track_m * interval_s)
                         : 0;
    }
    last_ = reading;
  }

  const Setup found_;
  const bool has_gyroscope_;
  const base::MonotonicTime::duration delay_;
  std::optional<core::BaseReading> last_;
};

}  // namespace

absl::StatusOr<Setup> ReadSetup(const std::string& robot) {
  TL_ASSIGN_OR_RETURN(const core::RobotDescription description,
                      ReadEitherFile(robot));
  return SetupOf(description.model, description.correction);
}

absl::StatusOr<CalibrateResult> RunCalibration(const CalibrateOptions& options,
                                               const std::stop_token& stop) {
  CalibrateResult result;
  if (!options.corrected.empty() &&
      std::filesystem::exists(options.corrected)) {
    return absl::AlreadyExistsError(absl::StrCat(
        options.corrected, " is there already; remove it, or choose another"));
  }
  TL_ASSIGN_OR_RETURN(const Drive drive,
                      ReadDrive(options.log, options.bag, result.notes));
  Setup assumed = calibration::AssumedSetup(drive.robot);
  if (!options.robot.empty()) {
    TL_ASSIGN_OR_RETURN(assumed, ReadSetup(options.robot));
  } else if (!drive.has_robot) {
    result.notes.emplace_back(
        "the log says nothing of its robot: the default robot is assumed; "
        "--robot FILE says better");
  }
  TL_ASSIGN_OR_RETURN(result.calibration,
                      calibration::Calibrate(drive, assumed, stop));
  if (!options.rear_scan_topic.empty()) {
    ros_log::BagLogOptions bag = options.bag;
    bag.scan_topic = options.rear_scan_topic;
    std::vector<std::string> ignored;
    TL_ASSIGN_OR_RETURN(const Drive rear, ReadDrive(options.log, bag, ignored));
    Setup rear_assumed = result.calibration.found;
    rear_assumed.base_from_laser =
        calibration::AssumedSetup(rear.robot).base_from_laser;
    auto found = calibration::Calibrate(rear, rear_assumed, stop);
    if (!found.ok()) {
      return base::Annotate(found.status(), options.rear_scan_topic);
    }
    result.rear = *std::move(found);
  }
  if (options.with_camera) {
    geometry::Rigid3 camera = drive.robot.base_from_camera;
    if (!options.robot.empty()) {
      TL_ASSIGN_OR_RETURN(camera, ReadCameraMount(options.robot));
    }
    TL_ASSIGN_OR_RETURN(
        result.camera,
        CalibrateCameraOf(options, drive, result.calibration.found, camera,
                          stop));
  }
  result.yaml = RobotYaml(options, result, drive);
  TL_RETURN_IF_ERROR(WriteAll(options, drive, result));
  return result;
}

absl::Status WriteCorrectedLog(const CalibrateOptions& options,
                               const Calibration& calibration,
                               bool has_gyroscope, const std::string& to) {
  const base::SteadyClock clock;
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<recording::AgentLogWriter> writer,
      recording::AgentLogWriter::Open(to, /*append=*/false, clock));
  Corrector corrector(calibration.found, has_gyroscope);
  // Holds if the log names no robot; else that follows.
  core::RobotModel robot;
  corrector.CorrectRobot(robot);
  TL_RETURN_IF_ERROR(writer->Write(robot));
  TL_RETURN_IF_ERROR(ros_log::ReadAnyLog(options.log, options.bag,
                                         [&](recording::LogEntry entry) {
                                           corrector.Correct(entry);
                                           return writer->Write(entry);
                                         })
                         .status());
  return writer->Flush();
}

}  // namespace treeline::calibrate_app
