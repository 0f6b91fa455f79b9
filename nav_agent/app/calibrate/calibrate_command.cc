#include "nav_agent/app/calibrate/calibrate_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/calibrate/calibrate_run.h"
#include "nav_agent/calibration/calibration_text.h"

namespace treeline::calibrate_app {
namespace {

constexpr const char* kFooter = R"(
Drive for three minutes or more where walls and furniture are within range:
straight ahead, turns on the spot both ways, some of them quick. LOG is an agent
log, a recording of ROS (.mcap, .db3, .bag, a folder) or a public laser log.
Recordings hold measurements uncorrected, so what is found replaces what the
robot's file says. What the numbers mean: docs/how-to/calibrate-a-robot.md.

Examples:
  treeline-agent calibrate drive.tlog --picture drive.png
  treeline-agent calibrate drive.tlog --robot robot.yaml --write robot.yaml
  treeline-agent calibrate walk.mcap --rear-scan-topic /rear/scan
  treeline-agent calibrate drive.tlog --camera
  treeline-agent calibrate today.tlog --check robot.yaml
  treeline-agent calibrate drive.tlog --corrected better.tlog

Exit codes: 0 done, and with --check the file fits; 1 it does not, or nothing
was found; 2 wrong usage.)";

struct CalibrateFlags {
  CalibrateOptions options;
  std::string check;
};

// Says what no longer fits.
absl::Status Check(const std::string& file,
                   const calibration::Calibration& found) {
  const auto misfits = calibration::FindMisfits(found);
  for (const calibration::Misfit& misfit : misfits) {
    std::printf("%s: %s is %.4f %s in %s, %.4f +- %.4f in this drive\n",
                "does not fit", calibration::NameOf(misfit.quantity),
                misfit.assumed, calibration::UnitOf(misfit.quantity),
                file.c_str(), misfit.found, misfit.sigma);
  }
  const std::string noise = calibration::NoiseMisfit(found);
  if (!noise.empty()) {
    std::printf("does not fit: %s in %s\n", noise.c_str(), file.c_str());
  }
  if (misfits.empty() && noise.empty()) {
    std::printf("%s fits this drive, as far as the drive shows it\n",
                file.c_str());
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      file, " does not fit the drive; calibrate anew (--write ", file, ")"));
}

absl::Status RunCommand(CalibrateFlags flags, const std::stop_token& stop) {
  if (!flags.check.empty()) flags.options.robot = flags.check;
  TL_ASSIGN_OR_RETURN(const CalibrateResult result,
                      RunCalibration(flags.options, stop));
  for (const std::string& note : result.notes) {
    std::printf("note: %s\n", note.c_str());
  }
  std::printf("%s", calibration::CalibrationTable(result.calibration).c_str());
  if (result.rear) {
    std::printf("\nthe laser of %s:\n%s", flags.options.rear_scan_topic.c_str(),
                calibration::CalibrationTable(*result.rear).c_str());
  }
  if (result.camera) {
    std::printf("\n%s", calibration::CameraTable(*result.camera).c_str());
  }
  std::printf("\n%s", result.yaml.c_str());
  if (!flags.options.write.empty()) {
    std::printf("%s was changed\n", flags.options.write.c_str());
  }
  if (flags.check.empty()) return absl::OkStatus();
  return Check(flags.check, result.calibration);
}

void AddOutputs(CLI::App& command, CalibrateFlags& flags) {
  CalibrateOptions& options = flags.options;
  command
      .add_option("--robot", options.robot,
                  "What is assumed: a robot's file or name, or a file of "
                  "--hardware (default: what the log says of its robot)")
      ->type_name("ROBOT");
  command.add_flag("--camera", options.with_camera,
                   "Calibrate the RGB-D camera, too; follows its pictures, "
                   "some minutes");
  CLI::Option* write =
      command
          .add_option("--write", options.write,
                      "Change this file, which must be there: a robot's or one "
                      "of --hardware; comments stay")
          ->type_name("FILE")
          ->check(CLI::ExistingFile);
  command
      .add_option("--check", flags.check,
                  "Only say whether this file, of either kind, still fits")
      ->type_name("ROBOT")
      ->excludes(write);
  command.add_option("--yaml", options.yaml, "Write the result as YAML")
      ->type_name("FILE");
  command.add_option("--json", options.json, "Write the result as JSON")
      ->type_name("FILE");
  command
      .add_option("--picture", options.picture,
                  "Draw ways and differences, before and after")
      ->type_name("FILE.png");
  command
      .add_option("--corrected", options.corrected,
                  "Write the log anew, as an agent log with the calibration in "
                  "effect")
      ->type_name("FILE");
}

void AddTopics(CLI::App& command, CalibrateOptions& options) {
  constexpr const char* kRos = "Recordings of ROS";
  command
      .add_option("--scan-topic", options.bag.scan_topic,
                  "Scans (default: /scan, or the most)")
      ->type_name("TOPIC")
      ->group(kRos);
  command
      .add_option("--odometry-topic", options.bag.odometry_topic,
                  "Odometry (default: /odom, or the most)")
      ->type_name("TOPIC")
      ->group(kRos);
  command
      .add_option("--rear-scan-topic", options.rear_scan_topic,
                  "A second laser, that is calibrated, too")
      ->type_name("TOPIC")
      ->group(kRos);
}

}  // namespace

cli::Command AddCalibrateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibrate", "Wheels, laser and delay of a robot, from a recorded drive");
  command->footer(kFooter);
  auto flags = std::make_shared<CalibrateFlags>();
  command->add_option("log", flags->options.log, "The recorded drive")
      ->type_name("LOG")
      ->required();
  AddOutputs(*command, *flags);
  AddTopics(*command, flags->options);
  return {command, [flags](const std::stop_token& stop) {
            return RunCommand(*flags, stop);
          }};
}

}  // namespace treeline::calibrate_app
