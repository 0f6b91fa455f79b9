// treeline train: recorded frames in, one model file out.
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "server/core/forest/model_file.h"
#include "server/core/forest/model_info_json.h"
#include "server/core/training/forest_trainer.h"
#include "server/core/training/rgbd_calibrator.h"
#include "server/tools/calibration_text.h"
#include "server/tools/commands.h"
#include "server/tools/dataset_flags.h"
#include "server/tools/run_info.h"

namespace treeline {
namespace {

constexpr const char* kFooter = R"(
Methods:
  rgbd  colour and depth, in training and in queries: a backtracking regression
        forest on depth-adaptive colour differences

A server loads DIR/<scene>/<version>/model.treeline, so give such a name to
--output. The file appears when it is complete, or not at all.

Examples:
  treeline train --dataset 7scenes:kitchen --frames train.txt --method rgbd \
      --output models/kitchen/1/model.treeline
  treeline train --dataset tum:rgbd_dataset_freiburg1_desk \
      --output desk.treeline --trees 8 --seed 7)";

struct TrainFlags {
  DatasetOptions dataset;
  std::string method = "rgbd";
  std::string output_path;
  std::string calibration = "auto";
  TrainingOptions training;
  bool quiet = false;
};

// A flag's name, and its value in the text that the model records.
std::vector<std::pair<std::string, std::string>> RecordedOptions(
    const TrainFlags& flags) {
  const TrainingOptions& t = flags.training;
  return {{"frames", flags.dataset.frame_list},
          {"poses", flags.dataset.pose_file},
          {"calibration", flags.calibration},
          {"trees", absl::StrCat(t.trees)},
          {"frames-per-tree", absl::StrCat(t.frames_per_tree)},
          {"samples-per-frame", absl::StrCat(t.samples_per_frame)},
          {"balanced-levels", absl::StrCat(t.balanced_levels)},
          {"max-depth", absl::StrCat(t.max_depth)},
          {"min-leaf-samples", absl::StrCat(t.min_leaf_samples)},
          {"min-spread", absl::StrCat(t.min_spread_m)},
          {"split-candidates", absl::StrCat(t.split_candidates)},
          {"max-offset", absl::StrCat(t.max_offset_px_m)},
          {"split-samples", absl::StrCat(t.max_split_samples)}};
}

absl::StatusOr<RgbdCalibration> ChooseCalibration(const TrainFlags& flags,
                                                  const Dataset& dataset,
                                                  const std::stop_token& stop) {
  if (flags.calibration == "nominal") return dataset.calibration();
  if (flags.calibration == "auto") {
    CalibratorOptions options;
    options.threads = flags.training.threads;
    TL_ASSIGN_OR_RETURN(const CalibrationReport report,
                        CalibrateRgbd(dataset, options, flags.quiet, stop));
    std::fputs(CalibrationText(report).c_str(), stdout);
    std::fflush(stdout);  // growing the forest takes a while
    return report.calibration;
  }
  TL_ASSIGN_OR_RETURN(const std::string json, ReadFile(flags.calibration));
  absl::StatusOr<RgbdCalibration> calibration = CalibrationFromJson(json);
  if (!calibration.ok()) {
    return Annotate(calibration.status(), flags.calibration);
  }
  // The cameras are the file's; whose poses these are, the recording knows.
  calibration->pose_sensor = dataset.calibration().pose_sensor;
  return calibration;
}

absl::Status Train(const TrainFlags& flags, const std::stop_token& stop) {
  if (flags.method != "rgbd") {
    return absl::InvalidArgumentError(absl::StrCat(
        "--method ", flags.method, " is not known; this version has rgbd"));
  }
  TL_RETURN_IF_ERROR(flags.training.Validate());
  TL_RETURN_IF_ERROR(MakeParentFolder(flags.output_path));
  TL_RETURN_IF_ERROR(CheckWritable(flags.output_path));
  const SteadyClock clock;
  const MonotonicTime start = clock.Now();
  TL_ASSIGN_OR_RETURN(const Dataset dataset, Dataset::Open(flags.dataset));
  ModelInfo info;
  TL_ASSIGN_OR_RETURN(info.calibration,
                      ChooseCalibration(flags, dataset, stop));
  TL_ASSIGN_OR_RETURN(const TrainedForest trained,
                      TrainForest(dataset, info.calibration, flags.training,
                                  flags.quiet, stop));
  info.method = flags.method;
  info.software_version = Version();
  info.created_utc = UtcNow();
  info.dataset = flags.dataset.uri;
  info.seed = flags.training.seed;
  info.options = RecordedOptions(flags);
  info.training_frames = trained.frames;
  info.training_samples = trained.samples;
  info.training_s = MillisecondsBetween(start, clock.Now()) / 1e3;
  const ForestView forest = trained.forest.View();
  TL_RETURN_IF_ERROR(WriteModel(flags.output_path, info, {forest}));
  // Read back what was written, as a server will.
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const ModelFile> model,
                      ModelFile::Open(flags.output_path));
  std::printf(
      "%s: %d trees, %d leaves, %.1f MB, from %d frames in %.1f s (peak "
      "memory %.0f MiB)\n",
      flags.output_path.c_str(), model->info().trees,
      static_cast<int>(model->info().leaves),
      static_cast<double>(model->info().file_bytes) / 1e6, trained.frames,
      info.training_s, static_cast<double>(PeakMemoryBytes()) / (1 << 20));
  return absl::OkStatus();
}

void AddForestFlags(CLI::App& command, TrainingOptions& options) {
  constexpr const char* kGroup = "Forest";
  const auto add = [&](const char* name, auto& value, const char* help,
                       const char* type) {
    command.add_option(name, value, help)
        ->type_name(type)
        ->capture_default_str()
        ->group(kGroup);
  };
  add("--seed", options.seed,
      "The same seed gives the same forest, whatever the threads", "N");
  add("--trees", options.trees, "Trees", "N");
  add("--frames-per-tree", options.frames_per_tree,
      "Frames drawn at random for each tree", "N");
  add("--samples-per-frame", options.samples_per_frame,
      "Pixels drawn at random from each of them", "N");
  add("--balanced-levels", options.balanced_levels,
      "Levels split by the sample-balanced objective before spatial variance "
      "takes over (L_max)",
      "N");
  add("--max-depth", options.max_depth, "Depth of the deepest leaf", "N");
  add("--min-leaf-samples", options.min_leaf_samples,
      "Samples a leaf has at least", "N");
  add("--min-spread", options.min_spread_m,
      "Samples that lie this close together make a leaf", "M");
  add("--split-candidates", options.split_candidates,
      "Random features tried at a node", "N");
  add("--max-offset", options.max_offset_px_m,
      "Features look this far, at one metre's distance", "PX");
  add("--split-samples", options.max_split_samples,
      "Samples of a node that objectives are computed on, at most", "N");
}

}  // namespace

Command AddTrainCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("train", "Learn a scene from recorded frames");
  command->footer(kFooter);
  auto flags = std::make_shared<TrainFlags>();
  AddDatasetFlags(*command, flags->dataset);
  command->add_option("--method", flags->method, "Method, see below")
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--output", flags->output_path, "Model file to write")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--calibration", flags->calibration,
                   "How depth and colour fit together: auto estimates it from "
                   "the frames, nominal takes the recording's cameras as they "
                   "are, FILE is from `treeline calibrate`")
      ->type_name("auto|nominal|FILE")
      ->capture_default_str();
  command
      ->add_option("--threads", flags->training.threads,
                   "Threads; 0: one a processor")
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  AddForestFlags(*command, flags->training);
  return {command,
          [flags](const std::stop_token& stop) { return Train(*flags, stop); }};
}

}  // namespace treeline
