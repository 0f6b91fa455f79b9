#include "server/tools/app/train_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "server/core/training/rgbd_calibrator.h"
#include "server/core/training/scene_trainer.h"
#include "server/tools/calibration_file.h"
#include "server/tools/calibration_text.h"
#include "server/tools/dataset_flags.h"
#include "server/tools/learning/learn_source.h"
#include "server/tools/run_info.h"
#include "server/tools/training_place.h"
#include "server/tools/training_record.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
A server loads DIR/<scene>/<version>/model.treeline, so give such a name to
--output. The file appears when it is complete, or not at all.

Examples:
  treeline train --dataset 7scenes:kitchen --frames train.txt \
      --output models/kitchen/1/model.treeline
  treeline train --dataset tum:rgbd_dataset_freiburg1_desk \
      --output desk.treeline --trees 8 --seed 7
  treeline train --map cafe-map --repository models

Many machines learn a scene together: each grows a tree, as many as --trees
says, and one makes the scene of them (treeline merge --help). It is the scene
that a single machine would have learnt:
  treeline train --dataset 7scenes:kitchen --tree 0 --output part-0.treeline)";

constexpr const char* kMergeFooter = R"(
The scene is the same, to the bit, that `treeline train` makes on one machine.
What does not belong to a tree is made here: keyframes, confidence, the scene's
descriptor. So the recording is needed, with the frames that the parts saw.

Example:
  for k in 0 1 2 3 4; do  # each on a machine of its own
    treeline train --dataset 7scenes:kitchen --tree $k \
        --output part-$k.treeline
  done
  treeline merge part-*.treeline --dataset 7scenes:kitchen \
      --repository models --scene kitchen)";

struct TrainFlags {
  dataset::DatasetOptions dataset;
  std::string map;
  std::string repository;
  std::string scene;
  std::string method = "universal";
  std::string output_path;
  std::string calibration;
  std::string adapt_path;
  std::string extend_path;
  std::string trials_path;
  bool splits_only = false;
  std::optional<int> tree;         // the only one to grow
  std::vector<std::string> parts;  // of `merge`
  training::TrainingOptions training;
  training::SiftTrainingOptions sift;
  bool quiet = false;
};

// Wrong usage, as CLI11 has it.
void CheckUsage(const TrainFlags& flags) {
  if (flags.map.empty() == flags.dataset.uri.empty()) {
    throw CLI::ValidationError(
        "of what is the scene learned? Give --dataset URI or --map BUNDLE");
  }
  if (flags.repository.empty() == flags.output_path.empty()) {
    throw CLI::ValidationError(
        "where shall the model go? Give --output FILE or --repository DIR");
  }
}

// Fills in what the other flags imply.
absl::Status Complete(TrainFlags& flags) {
  if (!flags.map.empty()) {
    TL_ASSIGN_OR_RETURN(const std::string scene,
                        tools::SceneOfMapBundle(flags.map));
    if (flags.scene.empty()) flags.scene = scene;
    const std::string keyframes = flags.map + "/keyframes";
    flags.dataset.uri = "7scenes:" + keyframes;
    const std::string calibration_path = keyframes + "/calibration.json";
    TL_ASSIGN_OR_RETURN(const camera::RgbdCalibration calibration,
                        tools::ReadCalibrationFile(calibration_path));
    flags.dataset.color_camera = calibration.color.ToString();
    flags.dataset.depth_camera = calibration.depth.ToString();
    if (flags.calibration.empty()) flags.calibration = calibration_path;
  }
  if (flags.calibration.empty()) flags.calibration = "auto";
  if (flags.repository.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(flags.output_path,
                      tools::NextModelPath(flags.repository, flags.scene));
  return absl::OkStatus();
}

// nullopt: to be estimated.
absl::StatusOr<std::optional<camera::RgbdCalibration>> GivenCalibration(
    const TrainFlags& flags, const dataset::Dataset& dataset,
    const std::stop_token& stop) {
  if (flags.calibration == "auto") return std::nullopt;
  if (flags.calibration == "nominal") {
    TL_RETURN_IF_ERROR(training::CheckPoses(
        dataset, {.threads = flags.training.threads}, flags.quiet, stop));
    return dataset.calibration();
  }
  TL_ASSIGN_OR_RETURN(camera::RgbdCalibration calibration,
                      tools::ReadCalibrationFile(flags.calibration));
  // The cameras are the file's; whose poses these are, the recording knows.
  calibration.pose_sensor = dataset.calibration().pose_sensor;
  return calibration;
}

// A line a trial, with a header.
std::string TrialsCsv(std::span<const training::ConfidenceTrial> trials) {
  std::string csv =
      "view,is_right,translation_error_m,rotation_error_rad,inlier_ratio,"
      "correlation,agreement,visible,overlap,measured,depth_agreement,moved_m,"
      "matches,sigma_m,contradicted,distinct\n";
  for (const training::ConfidenceTrial& trial : trials) {
    const forest::PoseEvidence& e = trial.evidence;
    absl::StrAppendFormat(&csv,
                          "%s,%d,%.5f,%.5f,%.5f,%.5f,%.5f,%d,%.5f,%d,%.5f,"
                          "%.5f,%d,%.6f,%.5f,%.5f\n",
                          trial.view, trial.is_right ? 1 : 0,
                          trial.error.translation_m, trial.error.rotation_rad,
                          e.inlier_ratio, e.correlation, e.agreement, e.visible,
                          e.overlap, e.measured, e.depth_agreement, e.moved_m,
                          e.matches, e.sigma_m, e.contradicted, e.distinct);
  }
  return csv;
}

// What is told of a trained scene, and of each way to train one.
training::SceneTrainingOptions CommonOptions(const TrainFlags& flags,
                                             absl::Status& trials_written) {
  training::SceneTrainingOptions options;
  options.forest = flags.training;
  options.software_version = base::Version();
  options.created_utc = tools::UtcNow();
  if (flags.trials_path.empty()) return options;
  options.on_trials = [&flags, &trials_written](
                          std::span<const training::ConfidenceTrial> trials) {
    trials_written =
        base::WriteFileAtomically(flags.trials_path, TrialsCsv(trials));
  };
  return options;
}

void PrintTrained(const std::string& path, const forest::ModelInfo& info) {
  std::printf(
      "%s: %d trees, %d leaves, %.1f MB, from %d frames in %.1f s (peak "
      "memory %.0f MiB)\n",
      path.c_str(), info.trees, static_cast<int>(info.leaves),
      static_cast<double>(info.file_bytes) / 1e6, info.training_frames,
      info.training_s,
      static_cast<double>(tools::PeakMemoryBytes()) / (1 << 20));
}

absl::Status Train(TrainFlags& flags, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(Complete(flags));
  TL_ASSIGN_OR_RETURN(const dataset::Dataset dataset,
                      dataset::Dataset::Open(flags.dataset));
  TL_RETURN_IF_ERROR(
      learning::CheckLearnable(dataset, flags.method, flags.dataset.uri));
  if (const std::string left_out = learning::LeftOutText(dataset, flags.method);
      !left_out.empty()) {
    std::printf("left out          %s\n", left_out.c_str());
  }
  absl::Status trials_written;
  training::SceneTrainingOptions options = CommonOptions(flags, trials_written);
  options.method = flags.method;
  TL_ASSIGN_OR_RETURN(options.calibration,
                      GivenCalibration(flags, dataset, stop));
  options.on_calibrated = [](const training::CalibrationReport& report) {
    std::fputs(tools::CalibrationText(report).c_str(), stdout);
    std::fflush(stdout);  // growing the forest takes a while
  };
  options.base_model =
      flags.adapt_path.empty() ? flags.extend_path : flags.adapt_path;
  options.refill = flags.adapt_path.empty() ? training::Refill::kExtend
                                            : training::Refill::kAdapt;
  options.splits_only = flags.splits_only;
  options.sift = flags.sift;
  options.recorded_options =
      flags.method == "sift"
          ? tools::RecordedSiftOptions(flags.dataset, flags.training,
                                       flags.sift)
          : tools::RecordedOptions(flags.dataset, flags.calibration,
                                   flags.training, flags.adapt_path,
                                   flags.extend_path);
  TL_ASSIGN_OR_RETURN(
      const training::TrainedScene scene,
      flags.tree ? training::TrainTree(dataset, options, *flags.tree,
                                       flags.output_path, flags.quiet, stop)
                 : training::TrainScene(dataset, options, flags.output_path,
                                        flags.quiet, stop));
  TL_RETURN_IF_ERROR(trials_written);
  PrintTrained(flags.output_path, scene.info);
  return absl::OkStatus();
}

absl::Status Merge(TrainFlags& flags, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(Complete(flags));
  TL_ASSIGN_OR_RETURN(const dataset::Dataset dataset,
                      dataset::Dataset::Open(flags.dataset));
  absl::Status trials_written;
  TL_ASSIGN_OR_RETURN(
      const training::TrainedScene scene,
      training::MergeScene(dataset, flags.parts,
                           CommonOptions(flags, trials_written),
                           flags.output_path, flags.quiet, stop));
  TL_RETURN_IF_ERROR(trials_written);
  PrintTrained(flags.output_path, scene.info);
  return absl::OkStatus();
}

// Removes the version that was made for a model that did not come.
absl::Status Tidied(const TrainFlags& flags, absl::Status status) {
  if (!status.ok() && !flags.repository.empty() && !flags.output_path.empty()) {
    tools::RemoveEmptyVersion(flags.output_path);
  }
  return status;
}

std::string MethodsHelp() {
  std::string help = "\nMethods:\n";
  for (const training::MethodDescription& method :
       training::TrainableMethods()) {
    absl::StrAppendFormat(&help, "  %-13s%s\n", method.name, method.summary);
  }
  return help;
}

void AddForestFlags(CLI::App& command, training::TrainingOptions& options) {
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
  add("--min-kept-samples", options.min_kept_samples,
      "Leaves with fewer samples are left out: chance, and most of the bytes; "
      "0: 5 with universal and rgbd, else 1",
      "N");
  add("--min-spread", options.min_spread_m,
      "Samples that lie this close together make a leaf", "M");
  add("--split-candidates", options.split_candidates,
      "Random features tried at a node", "N");
  add("--max-offset", options.max_offset_px_m,
      "Features look this far, at one metre's distance", "PX");
  add("--split-samples", options.max_split_samples,
      "Samples of a node that objectives are computed on, at most", "N");
}

void AddSiftFlags(CLI::App& command, training::SiftTrainingOptions& options) {
  constexpr const char* kGroup = "Method sift";
  const auto add = [&](const char* name, auto& value, const char* help,
                       const char* type) {
    command.add_option(name, value, help)
        ->type_name(type)
        ->capture_default_str()
        ->group(kGroup);
  };
  add("--sift-features", options.features.max_features,
      "Features taken from an image, the largest ones", "N");
  add("--sift-label-radius", options.label_radius_px,
      "A feature this near to a keypoint of the model shows its point", "PX");
  add("--sift-balanced-levels", options.balanced_levels,
      "Levels split by the sample-balanced objective", "N");
  add("--sift-leaf-samples", options.leaf_samples, "Samples a leaf has at most",
      "N");
  add("--sift-candidates", options.split_candidates,
      "Random dimensions tried at a node", "N");
}

// What is learnt, and where the model goes.
void AddPlaceFlags(CLI::App& command, TrainFlags& flags) {
  tools::AddDatasetFlags(command, flags.dataset)->required(false);
  command
      .add_option("--map", flags.map,
                  "Learn from the keyframes of this map bundle, of "
                  "`treeline-agent map`, instead of a recording")
      ->type_name("BUNDLE");
  command.add_option("--output", flags.output_path, "Model file to write")
      ->type_name("FILE");
  command
      .add_option("--repository", flags.repository,
                  "Or: the server's folder of models. It becomes the scene's "
                  "next version, which running servers then take")
      ->type_name("DIR");
  command
      .add_option("--scene", flags.scene,
                  "The scene's name in the repository (default: the map's)")
      ->type_name("NAME");
}

// How it runs, and what it tells.
void AddRunFlags(CLI::App& command, TrainFlags& flags) {
  command
      .add_option("--trials", flags.trials_path,
                  "Write what the confidence was learnt from: evidence and "
                  "error of each trial, as CSV")
      ->type_name("FILE");
  command
      .add_option("--threads", flags.training.threads,
                  "Threads; 0: one a processor")
      ->type_name("N")
      ->capture_default_str();
  command.add_flag("--quiet", flags.quiet, "Show no progress");
}

}  // namespace

cli::Command AddTrainCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("train", "Learn a scene from recorded frames");
  command->footer(absl::StrCat(MethodsHelp(), kFooter));
  auto flags = std::make_shared<TrainFlags>();
  AddPlaceFlags(*command, *flags);
  command->add_option("--method", flags->method, "Method, see below")
      ->type_name("NAME")
      ->capture_default_str();
  command
      ->add_option(
          "--calibration", flags->calibration,
          "How depth and colour fit together: auto estimates it from "
          "the frames, nominal takes the recording's cameras as they "
          "are, FILE is from `treeline calibrate` (default: auto; with "
          "--map, the map's own)")
      ->type_name("auto|nominal|FILE");
  CLI::Option* adapt =
      command
          ->add_option("--adapt", flags->adapt_path,
                       "Keep the trees of this model, of any scene, and refill "
                       "their leaves: seconds instead of minutes")
          ->type_name("MODEL");
  command
      ->add_option("--extend", flags->extend_path,
                   "Add the frames to this model of the same scene, in the "
                   "same world frame, without growing it anew")
      ->type_name("MODEL")
      ->excludes(adapt);
  command
      ->add_option("--tree", flags->tree,
                   "Grow this tree alone, of --trees, counted from 0, for "
                   "`treeline merge`")
      ->type_name("K")
      ->excludes("--repository");
  command->add_flag("--splits-only", flags->splits_only,
                    "Write a base for --adapt: the trees' splits, without what "
                    "their leaves learnt");
  AddRunFlags(*command, *flags);
  AddForestFlags(*command, flags->training);
  AddSiftFlags(*command, flags->sift);
  command->final_callback([flags] { CheckUsage(*flags); });
  return {command, [flags](const std::stop_token& stop) {
            return Tidied(*flags, Train(*flags, stop));
          }};
}

cli::Command AddMergeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "merge", "Make a scene of trees that many machines have grown");
  command->footer(kMergeFooter);
  auto flags = std::make_shared<TrainFlags>();
  command
      ->add_option("parts", flags->parts,
                   "What `treeline train --tree` wrote: all trees of a scene, "
                   "in any order")
      ->type_name("PART")
      ->required();
  AddPlaceFlags(*command, *flags);
  AddRunFlags(*command, *flags);
  command->final_callback([flags] { CheckUsage(*flags); });
  return {command, [flags](const std::stop_token& stop) {
            return Tidied(*flags, Merge(*flags, stop));
          }};
}

}  // namespace treeline::tools_app
