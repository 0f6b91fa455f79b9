#include "server/tools/app/calibrate_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "server/core/training/rgbd_calibrator.h"
#include "server/tools/calibration_text.h"
#include "server/tools/dataset_flags.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
Depth and colour cameras sit beside each other, so depth pixel (x, y) does not
see what colour pixel (x, y) sees. This estimates the offset, the depth scale
and what else the frames determine, and writes it as JSON. `treeline train`
does the same by itself; write a file to look at it, or to share it between
recordings of one camera.

Examples:
  treeline calibrate --dataset 7scenes:kitchen --frames train.txt \
      --output kinect.json
  treeline train --dataset 7scenes:kitchen --frames train.txt \
      --calibration kinect.json --output kitchen.treeline)";

struct CalibrateFlags {
  dataset::DatasetOptions dataset;
  training::CalibratorOptions calibrator;
  std::string output_path;
  bool quiet = false;
};

absl::Status Calibrate(const CalibrateFlags& flags,
                       const std::stop_token& stop) {
  if (!flags.output_path.empty()) {
    TL_RETURN_IF_ERROR(base::CheckWritable(flags.output_path));
  }
  TL_ASSIGN_OR_RETURN(const dataset::Dataset dataset,
                      dataset::Dataset::Open(flags.dataset));
  TL_ASSIGN_OR_RETURN(
      const training::CalibrationReport report,
      training::CalibrateRgbd(dataset, flags.calibrator, flags.quiet, stop));
  std::fputs(tools::CalibrationText(report).c_str(), stdout);
  if (flags.output_path.empty()) return absl::OkStatus();
  return base::WriteFileAtomically(
      flags.output_path, camera::CalibrationToJson(report.calibration));
}

}  // namespace

cli::Command AddCalibrateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibrate", "Estimate how depth and colour fit together");
  command->footer(kFooter);
  auto flags = std::make_shared<CalibrateFlags>();
  tools::AddDatasetFlags(*command, flags->dataset);
  command
      ->add_option("--output", flags->output_path,
                   "Write the calibration here (JSON)")
      ->type_name("FILE");
  command
      ->add_option("--calibration-frames", flags->calibrator.frames,
                   "Frames to look at, spread over the recording")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--threads", flags->calibrator.threads,
                   "Threads; 0: one a processor")
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return Calibrate(*flags, stop);
          }};
}

}  // namespace treeline::tools_app
