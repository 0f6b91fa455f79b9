#include "server/core/training/scene_trainer.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/parameters.h"
#include "server/core/recognition/scene_descriptor.h"
#include "server/core/training/appearance_builder.h"
#include "server/core/training/confidence_fitter.h"
#include "server/core/training/forest_refiller.h"
#include "server/core/training/forest_trainer.h"
#include "server/core/training/frame_samples.h"
#include "server/core/training/keyframe_builder.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/scene_writer.h"
#include "server/core/training/shutter_estimator.h"
#include "server/core/training/sift_scene_trainer.h"
#include "server/core/training/tree_part.h"

namespace treeline::training {
namespace {

constexpr MethodDescription kMethods[] = {
    {"universal",
     "colour and depth in training; queries with depth or without: the forest "
     "of rgbd, and features of keyframes where it does not suffice"},
    {"rgbd",
     "colour and depth, in training and in queries: a backtracking regression "
     "forest on depth-adaptive colour differences"},
    {"rgb",
     "colour and depth in training, colour alone in queries: a backtracking "
     "regression forest on colour differences, and PnP"},
    {"hybrid",
     "the same forest, then SIFT features of the keyframes near its pose, and "
     "PnP"},
    {"sift",
     "colour alone, with a structure from motion (colmap:, nvm:): a "
     "backtracking regression forest on SIFT features, and PnP"},
    {"points-lines",
     "like rgbd, with a second forest for points on line segments, which hold "
     "the pose across their lines"},
};

absl::Status CheckMethod(absl::string_view method) {
  if (std::ranges::any_of(kMethods, [&](const MethodDescription& m) {
        return m.name == method;
      })) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("method \"", method, "\" is not known; see --help"));
}

absl::Status CheckOutput(const std::string& path) {
  TL_RETURN_IF_ERROR(base::MakeParentFolder(path));
  return base::CheckWritable(path);
}

// Methods whose queries have no depth answer with the colour camera's pose.
bool SeesColorAlone(absl::string_view method) {
  return method == "rgb" || method == "hybrid";
}

// Methods that match features of keyframes.
bool MatchesFeatures(absl::string_view method) {
  return method == "universal" || method == "hybrid";
}

// Methods that answer with the colour camera's pose, whatever the recording's
// poses are of.
bool AnswersForColor(absl::string_view method) {
  return method == "universal" || SeesColorAlone(method);
}

// Methods whose forests are of one kind may be each other's base.
bool HaveForestsAlike(absl::string_view a, absl::string_view b) {
  const auto kind = [](absl::string_view method) -> absl::string_view {
    if (method == "universal") return "rgbd";
    if (method == "hybrid") return "rgb";
    return method;
  };
  return kind(a) == kind(b);
}

// points-lines: leaves have modes with this bandwidth (m).
constexpr double kModeBandwidth_m = 0.05;

// Where it was measured (docs/research/model-size.md), leaves with fewer
// samples are left out.
int MinKeptSamples(absl::string_view method, bool splits_only) {
  constexpr int kFew = 5;
  // A base for other scenes keeps the places of leaves that those may fill.
  return !splits_only && (method == "universal" || method == "rgbd") ? kFew : 1;
}

// Options of each forest of a method (ModelFile::forest): one or, for
// points-lines, that of general points and that of points on lines.
std::vector<TrainingOptions> ForestsOf(absl::string_view method,
                                       TrainingOptions options,
                                       bool splits_only) {
  options.depth_adaptive = !SeesColorAlone(method);
  if (options.min_kept_samples == 0) {
    options.min_kept_samples = MinKeptSamples(method, splits_only);
  }
  if (method != "points-lines") return {options};
  options.objective = SplitObjective::kEntropy;
  options.mode_bandwidth_m = kModeBandwidth_m;
  TrainingOptions lines = options;
  lines.line_points = true;
  return {options, lines};
}

// A scene is learnt twice: what is held out of the first round shows what its
// answers are worth.
enum class Round { kWithoutHeldOut, kAll };

class SceneTrainer {
 public:
  // `parts` may be empty; else all trees are theirs.
  SceneTrainer(const dataset::Dataset& dataset,
               const SceneTrainingOptions& options, std::vector<TreePart> parts,
               const std::string& output_path, bool quiet,
               const std::stop_token& stop)
      : recording_(dataset),
        dataset_(dataset),
        options_(options),
        output_path_(output_path),
        quiet_(quiet),
        stop_(stop),
        forests_(
            ForestsOf(options.method, options.forest, options.splits_only)),
        parts_(std::move(parts)) {}

  absl::StatusOr<TrainedScene> Train() {
    TL_RETURN_IF_ERROR(OpenBase());
    TL_RETURN_IF_ERROR(Calibrate());
    TL_RETURN_IF_ERROR(UndoShutter());
    Describe();
    if (options_.splits_only) {
      Learned learned;
      TL_ASSIGN_OR_RETURN(learned.forests, LearnForests(dataset_, Round::kAll));
      for (TrainedForest& f : learned.forests) {
        f.forest = SplitsOf(f.forest.View());
      }
      return Finish(learned);
    }
    const HeldOutSplit split = SplitForConfidence(UsableFrames(dataset_));
    TL_RETURN_IF_ERROR(CheckParts(split));
    if (split.held_out.empty() || is_extending()) {
      TL_ASSIGN_OR_RETURN(const Learned learned, Learn(dataset_, Round::kAll));
      if (is_extending()) info_.confidence = base_->info().confidence;
      return Finish(learned);
    }
    // How is the rest answered after learning a part?
    Learned whole;
    {
      Learned part;
      TL_RETURN_IF_ERROR(LearnRounds(split.train, part, whole));
      TL_RETURN_IF_ERROR(
          FitConfidenceOn(part, recording_.Subset(split.held_out)));
    }
    return Finish(whole);
  }

  absl::StatusOr<TrainedScene> TrainTree(int tree) {
    TL_RETURN_IF_ERROR(Calibrate());
    TL_RETURN_IF_ERROR(UndoShutter());
    Describe();
    TreePart part;
    const std::vector<int> first = FirstFrames();
    TL_ASSIGN_OR_RETURN(info_.training_samples, GrowTree(first, tree, part));
    info_.training_frames = CountDrawnFrames(dataset_, forests_.front(), first);
    info_.training_s = base::MillisecondsBetween(start_, clock_.Now()) / 1e3;
    info_.part = {tree, options_.forest.trees, FramesChecksum(dataset_)};
    part.info = info_;
    TL_RETURN_IF_ERROR(WriteTreePart(output_path_, part));
    TL_ASSIGN_OR_RETURN(part, ReadTreePart(output_path_));
    scene_.info = std::move(part.info);
    return std::move(scene_);
  }

 private:
  struct Learned {
    std::vector<TrainedForest> forests;
    keyframes::Keyframes keyframes;
  };

  absl::Status Calibrate() {
    // Where the scene's cameras are known already.
    if (is_extending() || !parts_.empty()) {
      calibration_ = is_extending() ? base_->info().calibration
                                    : parts_.front().info.calibration;
      calibration_.pose_sensor = dataset_.calibration().pose_sensor;
      return absl::OkStatus();
    }
    if (options_.calibration) {
      calibration_ = *options_.calibration;
      return absl::OkStatus();
    }
    CalibratorOptions calibrator;
    calibrator.threads = options_.forest.threads;
    TL_ASSIGN_OR_RETURN(const CalibrationReport report,
                        CalibrateRgbd(dataset_, calibrator, quiet_, stop_));
    if (options_.on_calibrated) options_.on_calibrated(report);
    calibration_ = report.calibration;
    return absl::OkStatus();
  }

  // Queries are as the camera takes them, and so are frames that are held out.
  absl::Status UndoShutter() {
    if (is_extending() || !parts_.empty()) {
      info_.shutter =
          is_extending() ? base_->info().shutter : parts_.front().info.shutter;
    } else {
      TL_ASSIGN_OR_RETURN(const std::optional<ShutterEstimate> found,
                          FindShutter(recording_, calibration_,
                                      options_.forest.threads, quiet_, stop_));
      if (found) info_.shutter = found->shutter;
    }
    if (info_.shutter) {
      dataset_ = recording_.WithShutter(*info_.shutter, calibration_);
    }
    return absl::OkStatus();
  }

  bool is_extending() const {
    return base_ != nullptr && options_.refill == Refill::kExtend;
  }

  absl::Status OpenBase() {
    if (options_.base_model.empty()) return absl::OkStatus();
    TL_ASSIGN_OR_RETURN(base_, forest::ModelFile::Open(options_.base_model));
    if (!HaveForestsAlike(base_->info().method, options_.method) ||
        base_->forests() != forests_.size() || base_->info().part ||
        base_->forest().descriptors.empty()) {
      return absl::InvalidArgumentError(absl::StrCat(
          options_.base_model, ": a model of method ", base_->info().method,
          " is no base for method ", options_.method));
    }
    return absl::OkStatus();
  }

  void Describe() {
    info_.method = options_.method;
    info_.software_version = options_.software_version;
    info_.created_utc = options_.created_utc;
    info_.dataset = dataset_.uri();
    info_.seed = options_.forest.seed;
    info_.options = options_.recorded_options;
    info_.calibration = calibration_;
    if (MatchesFeatures(options_.method)) {
      // Those of an extended model stay in it.
      info_.keyframe_sift = is_extending() ? base_->info().keyframe_sift
                                           : features::SiftKind::kFast;
    }
    if (AnswersForColor(options_.method)) {
      info_.calibration.pose_sensor = camera::RgbdSensor::kColor;
    }
  }

  absl::StatusOr<keyframes::Keyframes> MakeKeyframes(
      const dataset::Dataset& dataset) const {
    KeyframeOptions keyframes;
    keyframes.threads = options_.forest.threads;
    if (MatchesFeatures(options_.method)) {
      keyframes.features = keyframes::kMaxKeyframeFeatures;
      keyframes.sift = info_.keyframe_sift;
    }
    return BuildKeyframes(dataset, calibration_, keyframes, quiet_, stop_);
  }

  // Those that come first; empty where none is held out.
  std::vector<int> FirstFrames() const {
    HeldOutSplit split = SplitForConfidence(UsableFrames(dataset_));
    return split.held_out.empty() ? std::vector<int>{} : std::move(split.train);
  }

  // The tree of each forest of each round; returns of how many samples.
  absl::StatusOr<int64_t> GrowTree(const std::vector<int>& first, int tree,
                                   TreePart& part) const {
    int64_t samples = 0;
    std::vector<GrownTree> all;
    for (const TrainingOptions& forest : forests_) {
      TL_ASSIGN_OR_RETURN(GrownTrees grown,
                          GrowTrees(dataset_, calibration_, forest, first,
                                    {tree, tree + 1}, quiet_, stop_));
      samples += grown.samples;
      if (!first.empty()) part.trees.push_back(std::move(grown.first.front()));
      all.push_back(std::move(grown.trees.front()));
    }
    part.trees.insert(part.trees.end(), std::move_iterator(all.begin()),
                      std::move_iterator(all.end()));
    return samples;
  }

  // That the parts have a tree for each forest of each round.
  absl::Status CheckParts(const HeldOutSplit& split) const {
    const size_t rounds = split.held_out.empty() ? 1 : 2;
    if (parts_.empty() ||
        parts_.front().trees.size() == rounds * forests_.size()) {
      return absl::OkStatus();
    }
    return absl::DataLossError(
        absl::StrCat("corrupt parts: method ", options_.method, " has ",
                     rounds * forests_.size(), " forests to learn, they have ",
                     parts_.front().trees.size()));
  }

  TrainedForest ForestOfParts(size_t f, Round round) const {
    TrainedForest learned;
    std::vector<GrownTree> trees;
    const size_t rounds = parts_.front().trees.size() / forests_.size();
    const size_t i =
        f + (round == Round::kAll ? rounds - 1 : 0) * forests_.size();
    for (const TreePart& part : parts_) {
      trees.push_back(part.trees[i]);
      // Counted over all forests of a part.
      if (f == 0) learned.samples += part.info.training_samples;
    }
    learned.frames = parts_.front().info.training_frames;
    learned.forest = QuantizeForest(std::move(trees));
    return learned;
  }

  absl::StatusOr<std::vector<TrainedForest>> LearnForests(
      const dataset::Dataset& dataset, Round round) const {
    std::vector<TrainedForest> learned;
    for (size_t f = 0; f < forests_.size(); ++f) {
      if (!parts_.empty()) {
        learned.push_back(ForestOfParts(f, round));
        continue;
      }
      TL_ASSIGN_OR_RETURN(
          TrainedForest forest,
          base_ == nullptr
              ? TrainForest(dataset, calibration_, forests_[f], quiet_, stop_)
              : RefillForest(base_->forest(f), dataset, calibration_,
                             forests_[f], options_.refill, quiet_, stop_));
      learned.push_back(std::move(forest));
    }
    return learned;
  }

  // Both rounds. Trees are grown once: the frames held out join those that
  // were grown without them.
  absl::Status LearnRounds(const std::vector<int>& first, Learned& part,
                           Learned& whole) const {
    const dataset::Dataset subset = dataset_.Subset(first);
    if (base_ != nullptr || !parts_.empty()) {
      TL_ASSIGN_OR_RETURN(part, Learn(subset, Round::kWithoutHeldOut));
      TL_ASSIGN_OR_RETURN(whole, Learn(dataset_, Round::kAll));
      return absl::OkStatus();
    }
    for (const TrainingOptions& forest : forests_) {
      TL_ASSIGN_OR_RETURN(
          TrainedForests trained,
          TrainForests(dataset_, calibration_, forest, first, quiet_, stop_));
      part.forests.push_back({.forest = std::move(trained.first)});
      whole.forests.push_back(std::move(trained.all));
    }
    TL_ASSIGN_OR_RETURN(part.keyframes, MakeKeyframes(subset));
    TL_ASSIGN_OR_RETURN(whole.keyframes, MakeKeyframes(dataset_));
    return absl::OkStatus();
  }

  absl::StatusOr<Learned> Learn(const dataset::Dataset& dataset,
                                Round round) const {
    Learned learned;
    TL_ASSIGN_OR_RETURN(learned.forests, LearnForests(dataset, round));
    TL_ASSIGN_OR_RETURN(learned.keyframes, MakeKeyframes(dataset));
    if (is_extending()) TL_RETURN_IF_ERROR(KeepKeyframes(learned.keyframes));
    return learned;
  }

  // Puts those of the base before the new ones.
  absl::Status KeepKeyframes(keyframes::Keyframes& keyframes) const {
    TL_ASSIGN_OR_RETURN(
        const std::span<const keyframes::KeyframeRecord> records,
        base_->Extra<keyframes::KeyframeRecord>(
            forest::ModelExtra::kKeyframes));
    TL_ASSIGN_OR_RETURN(const std::span<const keyframes::KeyframePoint> points,
                        base_->Extra<keyframes::KeyframePoint>(
                            forest::ModelExtra::kKeyframePoints));
    TL_ASSIGN_OR_RETURN(
        const std::span<const keyframes::KeyframeFeature> features,
        base_->Extra<keyframes::KeyframeFeature>(
            forest::ModelExtra::kKeyframeFeatures));
    for (keyframes::KeyframeFeature& feature : keyframes.features) {
      feature.keyframe += static_cast<uint32_t>(records.size());
    }
    keyframes.features.insert(keyframes.features.begin(), features.begin(),
                              features.end());
    for (keyframes::KeyframeRecord& record : keyframes.records) {
      record.first_point += static_cast<uint32_t>(points.size());
    }
    keyframes.records.insert(keyframes.records.begin(), records.begin(),
                             records.end());
    keyframes.points.insert(keyframes.points.begin(), points.begin(),
                            points.end());
    return absl::OkStatus();
  }

  absl::Status Write(const Learned& learned, const std::string& path) const {
    std::vector<forest::ForestView> forests;
    for (const TrainedForest& f : learned.forests) {
      forests.push_back(f.forest.View());
    }
    return WriteScene(path, info_, forests, learned.keyframes, descriptor_);
  }

  absl::Status FitConfidenceOn(const Learned& learned,
                               const dataset::Dataset& held_out) {
    ConfidenceOptions confidence;
    confidence.seed = options_.forest.seed;
    confidence.threads = options_.forest.threads;
    confidence.on_trials = options_.on_trials;
    TL_ASSIGN_OR_RETURN(
        info_.confidence,
        LearnConfidence(
            [&](const std::string& path) { return Write(learned, path); },
            output_path_, held_out, confidence, quiet_, stop_));
    return absl::OkStatus();
  }

  // Of all frames; those of an extended model stay in it.
  absl::Status DescribeScene() {
    AppearanceOptions appearance;
    appearance.threads = options_.forest.threads;
    TL_ASSIGN_OR_RETURN(
        recognition::SceneDescriptor descriptor,
        BuildSceneDescriptor(dataset_, appearance, quiet_, stop_));
    if (is_extending()) {
      TL_ASSIGN_OR_RETURN(
          const std::span<const char> bytes,
          base_->Extra<char>(forest::ModelExtra::kSceneDescriptor));
      // Models of other versions have none, or one of other words.
      const absl::StatusOr<recognition::SceneDescriptor> old =
          recognition::SceneDescriptor::Parse({bytes.data(), bytes.size()});
      if (old.ok()) descriptor.Merge(*old);
    }
    descriptor_ = descriptor.Serialize();
    return absl::OkStatus();
  }

  absl::StatusOr<TrainedScene> Finish(const Learned& learned) {
    if (!options_.splits_only) TL_RETURN_IF_ERROR(DescribeScene());
    for (const TrainedForest& f : learned.forests) {
      info_.training_frames = std::max(info_.training_frames, f.frames);
      info_.training_samples += f.samples;
    }
    info_.training_s = base::MillisecondsBetween(start_, clock_.Now()) / 1e3;
    double longest_part_s = 0;
    for (const TreePart& part : parts_) {
      longest_part_s = std::max(longest_part_s, part.info.training_s);
    }
    info_.training_s += longest_part_s;
    TL_RETURN_IF_ERROR(Write(learned, output_path_));
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                        forest::ModelFile::Open(output_path_));
    scene_.info = model->info();
    return std::move(scene_);
  }

  const dataset::Dataset& recording_;
  // What is learnt from: the recording's frames, with a rolling shutter undone.
  dataset::Dataset dataset_;
  const SceneTrainingOptions& options_;
  const std::string& output_path_;
  const bool quiet_;
  const std::stop_token& stop_;
  const base::SteadyClock clock_;
  const base::MonotonicTime start_ = clock_.Now();
  const std::vector<TrainingOptions> forests_;
  const std::vector<TreePart> parts_;  // by tree
  camera::RgbdCalibration calibration_;
  std::unique_ptr<const forest::ModelFile> base_;
  forest::ModelInfo info_;
  std::string descriptor_;  // as the file has it; empty: none
  TrainedScene scene_;
};

}  // namespace

std::span<const MethodDescription> TrainableMethods() { return kMethods; }

absl::StatusOr<TrainedScene> TrainScene(const dataset::Dataset& dataset,
                                        const SceneTrainingOptions& options,
                                        const std::string& output_path,
                                        bool quiet,
                                        const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(CheckMethod(options.method));
  if (options.method == "sift") {
    return TrainSiftScene(dataset, options, output_path, quiet, stop);
  }
  TL_RETURN_IF_ERROR(options.forest.Validate());
  TL_RETURN_IF_ERROR(CheckOutput(output_path));
  return SceneTrainer(dataset, options, {}, output_path, quiet, stop).Train();
}

absl::StatusOr<TrainedScene> TrainTree(const dataset::Dataset& dataset,
                                       const SceneTrainingOptions& options,
                                       int tree, const std::string& output_path,
                                       bool quiet,
                                       const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(CheckMethod(options.method));
  if (options.method == "sift" || !options.base_model.empty() ||
      options.splits_only) {
    return absl::InvalidArgumentError(
        "a tree is grown alone by a method with depth in training, without "
        "another model to begin with; method sift grows all its trees "
        "together");
  }
  TL_RETURN_IF_ERROR(options.forest.Validate());
  if (tree < 0 || tree >= options.forest.trees) {
    return absl::InvalidArgumentError(
        absl::StrCat("there is no tree ", tree, " among ", options.forest.trees,
                     "; they count from 0"));
  }
  TL_RETURN_IF_ERROR(CheckOutput(output_path));
  return SceneTrainer(dataset, options, {}, output_path, quiet, stop)
      .TrainTree(tree);
}

absl::StatusOr<TrainedScene> MergeScene(const dataset::Dataset& dataset,
                                        const std::vector<std::string>& parts,
                                        SceneTrainingOptions options,
                                        const std::string& output_path,
                                        bool quiet,
                                        const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(CheckOutput(output_path));
  TL_ASSIGN_OR_RETURN(std::vector<TreePart> trees, ReadTreeParts(parts));
  const forest::ModelInfo& info = trees.front().info;
  TL_RETURN_IF_ERROR(CheckMethod(info.method));
  if (info.method == "sift") {
    return absl::DataLossError("corrupt parts: method sift has none");
  }
  if (info.software_version != options.software_version) {
    return absl::InvalidArgumentError(
        absl::StrCat("the parts were grown by version ", info.software_version,
                     ", and this is ", options.software_version));
  }
  if (info.part->frames_checksum != FramesChecksum(dataset)) {
    return absl::InvalidArgumentError(
        absl::StrCat(dataset.uri(),
                     ": not the frames and poses that the parts were grown "
                     "from (",
                     info.dataset, ")"));
  }
  options.method = info.method;
  options.forest.seed = info.seed;
  options.forest.trees = info.part->trees;
  options.recorded_options = info.options;
  options.base_model.clear();
  options.splits_only = false;
  return SceneTrainer(dataset, options, std::move(trees), output_path, quiet,
                      stop)
      .Train();
}

}  // namespace treeline::training
