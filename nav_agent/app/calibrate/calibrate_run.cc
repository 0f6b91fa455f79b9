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
#include "nav_agent/app/ros/any_robot_file.h"
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
using ros_app::RobotFileKind;

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
    } else if (entry.key == "base_from_laser") {
      entry.key = "base_from_rear_laser";
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

// model: how high lasers are; of a robot of ROS 2, the track, too, that its
// recording was made with.
std::vector<FileEntry> LaserEntries(const Calibration& calibration,
                                    RobotFileKind kind,
                                    const core::RobotModel& model,
                                    core::LaserMount laser) {
  const double z_m = model.BaseFrom(laser).translation.z;
  switch (kind) {
    case RobotFileKind::kHardware:
      return calibration::HardwareFileEntries(calibration);
    case RobotFileKind::kRos:
      return calibration::RosFileEntries(calibration, model.wheel_track_m, z_m);
    case RobotFileKind::kRobot:
      break;
  }
  return calibration::RobotFileEntries(calibration, z_m);
}

std::vector<FileEntry> CameraEntries(
    const calibration::CameraCalibration& calibration, RobotFileKind kind) {
  switch (kind) {
    case RobotFileKind::kHardware:
      return calibration::CameraHardwareEntries(calibration);
    case RobotFileKind::kRos:
      return calibration::CameraRosEntries(calibration);
    case RobotFileKind::kRobot:
      break;
  }
  return calibration::CameraFileEntries(calibration);
}

std::vector<FileEntry> EntriesFor(const CalibrateResult& result,
                                  RobotFileKind kind,
                                  const core::RobotModel& model) {
  std::vector<FileEntry> entries =
      LaserEntries(result.calibration, kind, model, core::LaserMount::kFront);
  if (result.rear) {
    AddRear(LaserEntries(*result.rear, kind, model, core::LaserMount::kRear),
            entries);
  }
  if (result.camera) {
    const auto camera = CameraEntries(*result.camera, kind);
    entries.insert(entries.end(), camera.begin(), camera.end());
  }
  return entries;
}

// Where sensors are is for /tf_static to say, unless the file does, upright:
// what it cannot be written as is told instead.
void LeaveMountsToTf(const yaml::YamlNode& file, const core::RobotModel& model,
                     CalibrateResult& result, std::vector<FileEntry>& entries) {
  const auto is_upright = [](const geometry::Rigid3& mount) {
    return (mount.rotation * geometry::Vec3{0, 0, 1}).z > 0;
  };
  std::erase_if(entries, [&](const FileEntry& entry) {
    if (!absl::StartsWith(entry.key, "base_from_")) return false;
    const bool is_camera = entry.key == "base_from_camera";
    if (file.Has(entry.key) && (is_camera || is_upright(model.base_from_laser)))
      return false;
    result.notes.push_back(absl::StrCat(
        entry.key, ": ", entry.value,
        " was found, and not written: /tf_static tells it, or it is upside "
        "down; change the robot's URDF"));
    return true;
  });
}

// Changes the file, and checks that a robot can still be read of it.
absl::Status WriteInto(const std::string& path, const Drive& drive,
                       CalibrateResult& result) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path, 65536));
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                      yaml::YamlNode::Parse(text, path));
  // That a robot can be read of it, before anything is changed.
  TL_ASSIGN_OR_RETURN(const ros_app::AnyRobotFile before,
                      ros_app::ReadAnyRobotFile(path));
  core::RobotModel model = before.robot.model;
  // What of the track was found is against that of the recording.
  if (before.kind == RobotFileKind::kRos) {
    model.wheel_track_m = drive.robot.wheel_track_m;
  }
  std::vector<FileEntry> entries = EntriesFor(result, before.kind, model);
  if (before.kind == RobotFileKind::kRos) {
    LeaveMountsToTf(file, model, result, entries);
  }
  result.yaml = calibration::EntriesYaml(entries, "what was changed");
  TL_ASSIGN_OR_RETURN(const std::string edited,
                      calibration::WithEntries(text, path, entries));
  if (before.kind == RobotFileKind::kRobot) {
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

// Of a robot of ROS 2 that does not say it, as `recorded`.
absl::StatusOr<geometry::Rigid3> ReadCameraMount(
    const std::string& robot, const geometry::Rigid3& recorded) {
  TL_ASSIGN_OR_RETURN(const ros_app::AnyRobotFile file,
                      ros_app::ReadAnyRobotFile(robot));
  return file.kind == RobotFileKind::kRos ? recorded
                                          : file.robot.model.base_from_camera;
}

std::string RobotYaml(const CalibrateOptions& options,
                      const CalibrateResult& result, const Drive& drive) {
  const core::RobotModel usual;
  core::RobotModel model = drive.robot;
  double& front_m = model.base_from_laser.translation.z;
  double& rear_m = model.base_from_rear_laser.translation.z;
  front_m = HeightOr_m(front_m, usual.base_from_laser.translation.z);
  rear_m = HeightOr_m(rear_m, usual.base_from_rear_laser.translation.z);
  return calibration::EntriesYaml(
      EntriesFor(result, RobotFileKind::kRobot, model),
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
  if (!options.write.empty()) return WriteInto(options.write, drive, result);
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

absl::StatusOr<Setup> ReadSetup(const std::string& robot,
                                const core::RobotModel& recorded) {
  TL_ASSIGN_OR_RETURN(const ros_app::AnyRobotFile file,
                      ros_app::ReadAnyRobotFile(robot));
  core::RobotModel model = file.robot.model;
  // Where its sensors are the recording says.
  if (file.kind == RobotFileKind::kRos) {
    model.base_from_laser = recorded.base_from_laser;
    model.wheel_track_m = recorded.wheel_track_m;
  }
  Setup setup = SetupOf(model, file.robot.correction);
  setup.noise = file.robot.noise;
  setup.wheels.track_m /= file.robot.correction.turn_scale;
  return setup;
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
    TL_ASSIGN_OR_RETURN(assumed, ReadSetup(options.robot, drive.robot));
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
      TL_ASSIGN_OR_RETURN(camera, ReadCameraMount(options.robot, camera));
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
