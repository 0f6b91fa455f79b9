#include "server/core/training/scene_trainer.h"

#include <algorithm>
#include <memory>
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
#include "server/core/training/sift_scene_trainer.h"

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

bool IsKnown(absl::string_view method) {
  return std::ranges::any_of(
      kMethods, [&](const MethodDescription& m) { return m.name == method; });
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

// Options of each forest of a method (ModelFile::forest): one or, for
// points-lines, that of general points and that of points on lines.
std::vector<TrainingOptions> ForestsOf(absl::string_view method,
                                       TrainingOptions options) {
  options.depth_adaptive = !SeesColorAlone(method);
  if (method != "points-lines") return {options};
  options.objective = SplitObjective::kEntropy;
  options.mode_bandwidth_m = kModeBandwidth_m;
  TrainingOptions lines = options;
  lines.line_points = true;
  return {options, lines};
}

template <typename T>
absl::string_view BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(T)};
}

class SceneTrainer {
 public:
  SceneTrainer(const dataset::Dataset& dataset,
               const SceneTrainingOptions& options,
               const std::string& output_path, bool quiet,
               const std::stop_token& stop)
      : dataset_(dataset),
        options_(options),
        output_path_(output_path),
        quiet_(quiet),
        stop_(stop),
        forests_(ForestsOf(options.method, options.forest)) {}

  absl::StatusOr<TrainedScene> Train() {
    TL_RETURN_IF_ERROR(OpenBase());
    TL_RETURN_IF_ERROR(Calibrate());
    Describe();
    if (options_.splits_only) {
      Learned learned;
      TL_ASSIGN_OR_RETURN(learned.forests, LearnForests(dataset_));
      for (TrainedForest& f : learned.forests) {
        f.forest = SplitsOf(f.forest.View());
      }
      return Finish(learned);
    }
    const HeldOutSplit split = SplitForConfidence(UsableFrames(dataset_));
    if (split.held_out.empty() || is_extending()) {
      TL_ASSIGN_OR_RETURN(const Learned learned, Learn(dataset_));
      if (is_extending()) info_.confidence = base_->info().confidence;
      return Finish(learned);
    }
    // Learn from a part and see how the rest is answered; then learn it all.
    {
      TL_ASSIGN_OR_RETURN(const Learned part,
                          Learn(dataset_.Subset(split.train)));
      TL_RETURN_IF_ERROR(
          FitConfidenceOn(part, dataset_.Subset(split.held_out)));
    }
    TL_ASSIGN_OR_RETURN(const Learned whole, Learn(dataset_));
    return Finish(whole);
  }

 private:
  struct Learned {
    std::vector<TrainedForest> forests;
    keyframes::Keyframes keyframes;
  };

  absl::Status Calibrate() {
    if (is_extending()) {  // the scene's cameras are known already
      calibration_ = base_->info().calibration;
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

  bool is_extending() const {
    return base_ != nullptr && options_.refill == Refill::kExtend;
  }

  absl::Status OpenBase() {
    if (options_.base_model.empty()) return absl::OkStatus();
    TL_ASSIGN_OR_RETURN(base_, forest::ModelFile::Open(options_.base_model));
    if (!HaveForestsAlike(base_->info().method, options_.method) ||
        base_->forests() != forests_.size() ||
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

  absl::StatusOr<std::vector<TrainedForest>> LearnForests(
      const dataset::Dataset& dataset) const {
    std::vector<TrainedForest> learned;
    for (size_t f = 0; f < forests_.size(); ++f) {
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

  absl::StatusOr<Learned> Learn(const dataset::Dataset& dataset) const {
    Learned learned;
    TL_ASSIGN_OR_RETURN(learned.forests, LearnForests(dataset));
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
    std::vector<forest::ModelExtraBytes> extras = {
        {forest::ModelExtra::kKeyframes, BytesOf(learned.keyframes.records)},
        {forest::ModelExtra::kKeyframePoints,
         BytesOf(learned.keyframes.points)}};
    if (!learned.keyframes.features.empty()) {
      extras.push_back({forest::ModelExtra::kKeyframeFeatures,
                        BytesOf(learned.keyframes.features)});
    }
    keyframes::KeyframeWords words;
    if (!learned.keyframes.features.empty() &&
        info_.keyframe_sift == features::SiftKind::kFast) {
      words = keyframes::LearnWords(learned.keyframes.features,
                                    learned.keyframes.records.size());
      extras.push_back(
          {forest::ModelExtra::kKeyframeWords, BytesOf(words.means)});
      extras.push_back(
          {forest::ModelExtra::kKeyframeFeatureWords, BytesOf(words.word_of)});
    }
    if (!descriptor_.empty()) {
      extras.push_back({forest::ModelExtra::kSceneDescriptor, descriptor_});
    }
    std::vector<forest::ForestView> forests;
    for (const TrainedForest& f : learned.forests) {
      forests.push_back(f.forest.View());
    }
    return forest::WriteModel(path, info_, forests, extras);
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
    TL_RETURN_IF_ERROR(Write(learned, output_path_));
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                        forest::ModelFile::Open(output_path_));
    scene_.info = model->info();
    return std::move(scene_);
  }

  const dataset::Dataset& dataset_;
  const SceneTrainingOptions& options_;
  const std::string& output_path_;
  const bool quiet_;
  const std::stop_token& stop_;
  const base::SteadyClock clock_;
  const base::MonotonicTime start_ = clock_.Now();
  const std::vector<TrainingOptions> forests_;
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
  if (!IsKnown(options.method)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "method \"", options.method, "\" is not known; see --help"));
  }
  if (options.method == "sift") {
    return TrainSiftScene(dataset, options, output_path, quiet, stop);
  }
  TL_RETURN_IF_ERROR(options.forest.Validate());
  TL_RETURN_IF_ERROR(base::MakeParentFolder(output_path));
  TL_RETURN_IF_ERROR(base::CheckWritable(output_path));
  return SceneTrainer(dataset, options, output_path, quiet, stop).Train();
}

}  // namespace treeline::training
