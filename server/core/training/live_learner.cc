#include "server/core/training/live_learner.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"
#include "server/core/keyframes/parameters.h"
#include "server/core/localizer/localizer.h"
#include "server/core/training/frame_samples.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/scene_writer.h"

namespace treeline::training {
namespace {

// Apart from the random streams of frames and trials.
constexpr uint64_t kLiveStream = 0x6c69766500000000;
// Modes that a leaf gathers at most. It keeps 16 of them.
constexpr size_t kGatheredModes = 24;
// Modes of fewer samples are not written: see TrainingOptions.
constexpr uint32_t kMinKeptSamples = 5;
// Of the frames that are held back, one in so many is asked about.
constexpr int kTrialEvery = 5;
// Frames whose trials are remembered.
constexpr size_t kTriedFrames = 120;
// Pictures whose words are remembered, as of BuildSceneDescriptor.
constexpr size_t kMaxPictures = 500;
// With too many keyframes, they are kept so much further apart.
constexpr double kSpacingGrowth = 1.25;

}  // namespace

absl::Status LiveModel::Write(const std::string& path) const {
  return WriteScene(path, info, {forest.View()}, JoinKeyframes(keyframes),
                    appearance.Serialize());
}

absl::StatusOr<std::vector<std::vector<ConfidenceTrial>>> LiveTrials::Run(
    const std::string& path, uint64_t seed, const std::stop_token& stop) const {
  const std::string trial_path = absl::StrCat(path, ".trial-", getpid());
  const absl::Status written = model.Write(trial_path);
  absl::StatusOr<std::unique_ptr<localizer::Localizer>> localizer =
      written.ok() ? localizer::OpenLocalizer(trial_path, TrialOptions())
                   : written;
  std::error_code ignored;
  std::filesystem::remove(trial_path, ignored);
  TL_RETURN_IF_ERROR(localizer.status());
  ConfidenceOptions options;
  options.seed = seed;
  std::vector<std::vector<ConfidenceTrial>> trials;
  for (const HeldBack& held_back : frames) {
    if (stop.stop_requested()) break;
    TL_ASSIGN_OR_RETURN(std::vector<ConfidenceTrial> of_frame,
                        RunTrialsOfFrame(**localizer, held_back.frame, cover,
                                         held_back.world_from_sensor, options,
                                         held_back.number));
    trials.push_back(std::move(of_frame));
  }
  return trials;
}

absl::StatusOr<std::unique_ptr<LiveLearner>> LiveLearner::Create(
    const std::string& base_model, const camera::RgbdCalibration& calibration,
    const LiveOptions& options) {
  TL_ASSIGN_OR_RETURN(std::unique_ptr<const forest::ModelFile> base,
                      forest::ModelFile::Open(base_model));
  const std::string& method = base->info().method;
  if ((method != "rgbd" && method != "universal") || base->info().part ||
      base->forest().descriptors.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        base_model, ": a model of method ", method,
        base->info().part ? ", one tree of it," : "",
        " is no base to learn on; it must be of method rgbd or universal"));
  }
  std::unique_ptr<LiveLearner> learner(
      new LiveLearner(std::move(base), calibration, options));
  if (!options.memory_folder.empty()) {
    TL_ASSIGN_OR_RETURN(learner->memory_,
                        SampleMemory::Open(options.memory_folder));
  } else {
    learner->memory_status_ = absl::FailedPreconditionError(
        "no samples are kept, so that poses cannot be corrected");
  }
  return learner;
}

LiveLearner::LiveLearner(std::unique_ptr<const forest::ModelFile> base,
                         const camera::RgbdCalibration& calibration,
                         const LiveOptions& options)
    : base_(std::move(base)),
      options_(options),
      geometry_(calibration),
      registration_(calibration),
      leaves_(base_->forest(), Refill::kAdapt, kGatheredModes),
      random_(options.seed, kLiveStream) {
  sampling_.seed = options.seed;
  keyframe_options_.features = keyframes::kMaxKeyframeFeatures;
  info_.method = "universal";
  info_.software_version = options.software_version;
  info_.created_utc = options.created_utc;
  info_.dataset = options.dataset;
  info_.seed = options.seed;
  info_.options = options.recorded_options;
  info_.calibration = calibration;
  info_.calibration.pose_sensor = camera::RgbdSensor::kColor;
  info_.keyframe_sift = keyframe_options_.sift;
}

absl::StatusOr<std::optional<LiveTrials>> LiveLearner::Add(
    const std::string& name, const image::Frame& frame,
    const geometry::Rigid3& world_from_sensor) {
  if (!frame.depth) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": without depth"));
  }
  TL_RETURN_IF_ERROR(CheckSizes(name, frame, geometry_.calibration()));
  TL_ASSIGN_OR_RETURN(Prepared prepared, Prepare(frame, world_from_sensor));
  const int number = prepared.number;
  if (memory_ != nullptr) world_from_sensor_.push_back(world_from_sensor);
  if (number % words_every_ == 0) LearnWords(frame);
  for (const RoutedSamples& routed : prepared.routed) {
    info_.training_samples += static_cast<int64_t>(routed.size());
  }
  const FrameRole role = RoleOf(static_cast<size_t>(number));
  if (role == FrameRole::kLearnt) {
    Learn(std::move(prepared));
  } else {
    waiting_.push_back(std::move(prepared));
  }
  if (role == FrameRole::kHeldOut && number % kTrialEvery == 0) {
    held_back_.push_back({.number = static_cast<uint64_t>(number),
                          .frame = frame,
                          .world_from_sensor = ModelPose(world_from_sensor)});
  }
  ++info_.training_frames;
  if (!TrialsAreDue()) return std::nullopt;
  absl::StatusOr<LiveTrials> trials = BeginTrials();
  LearnWaiting();
  // Without depth so far there is nothing to be asked.
  if (absl::IsFailedPrecondition(trials.status())) return std::nullopt;
  return trials;
}

absl::StatusOr<LiveLearner::Prepared> LiveLearner::Prepare(
    const image::Frame& frame, const geometry::Rigid3& world_from_sensor) {
  Prepared prepared;
  prepared.number = info_.training_frames;
  prepared.world_from_sensor = world_from_sensor;
  const features::PlanarImage image(frame.color);
  const geometry::Rigid3 own_world;
  const FrameSampler sampler(geometry_, frame, image, own_world, sampling_,
                             prepared.number);
  prepared.routed.resize(static_cast<size_t>(leaves_.trees()));
  base::ParallelFor(leaves_.trees(), options_.threads, [&](int64_t t) {
    const int tree = static_cast<int>(t);
    prepared.routed[static_cast<size_t>(t)] =
        leaves_.Route(tree, image, sampler.Draw(tree));
  });
  const geometry::Rigid3 sensor_from_color =
      camera::PoseOfSensor(own_world, geometry_.calibration().pose_sensor,
                           camera::RgbdSensor::kColor, geometry_.calibration());
  if (IsNewView(world_from_sensor * sensor_from_color)) {
    prepared.keyframe = std::make_shared<const KeyframeParts>(MakeKeyframe(
        frame, sensor_from_color, registration_, keyframe_options_));
  }
  return prepared;
}

bool LiveLearner::IsNewView(const geometry::Rigid3& world_from_color) const {
  const auto is_apart = [&](const PlacedKeyframe& known) {
    return AreApart(known.world_from_color(), world_from_color,
                    keyframe_options_.spacing_m);
  };
  return std::ranges::all_of(keyframes_, is_apart, &KeptKeyframe::placed) &&
         std::ranges::all_of(waiting_, [&](const Prepared& waiting) {
           return waiting.keyframe == nullptr ||
                  is_apart({waiting.keyframe, waiting.world_from_sensor});
         });
}

void LiveLearner::Learn(Prepared prepared) {
  base::ParallelFor(leaves_.trees(), options_.threads, [&](int64_t t) {
    leaves_.Add(static_cast<int>(t), prepared.routed[static_cast<size_t>(t)],
                prepared.world_from_sensor);
  });
  Keep(prepared);
  if (prepared.keyframe == nullptr) return;
  keyframes_.push_back(
      {.frame = prepared.number,
       .placed = {.parts = std::move(prepared.keyframe),
                  .world_from_parts = prepared.world_from_sensor}});
  if (keyframes_.size() >
      static_cast<size_t>(keyframe_options_.max_keyframes)) {
    KeepFewerKeyframes();
  }
}

// Without room poses stay as they are; what is known is not lost.
void LiveLearner::Keep(const Prepared& prepared) {
  if (memory_ == nullptr) return;
  if (const absl::Status added = memory_->Add(prepared.routed); !added.ok()) {
    memory_status_ = absl::FailedPreconditionError(
        absl::StrCat("poses cannot be corrected any more: ", added.message()));
    memory_.reset();
    is_moved_ = false;
    return;
  }
  kept_frames_.push_back(prepared.number);
}

absl::Status LiveLearner::Correct(int frame,
                                  const geometry::Rigid3& world_from_sensor) {
  TL_RETURN_IF_ERROR(memory_status_);
  if (frame < 0 || frame >= frames()) {
    return absl::OutOfRangeError(
        absl::StrCat("there is no frame number ", frame));
  }
  world_from_sensor_[static_cast<size_t>(frame)] = world_from_sensor;
  is_moved_ = true;
  for (Prepared& waiting : waiting_) {
    if (waiting.number == frame) waiting.world_from_sensor = world_from_sensor;
  }
  for (LiveTrials::HeldBack& held_back : held_back_) {
    if (held_back.number == static_cast<uint64_t>(frame)) {
      held_back.world_from_sensor = ModelPose(world_from_sensor);
    }
  }
  return absl::OkStatus();
}

// Fills the leaves again, as poses are now.
absl::Status LiveLearner::Settle() {
  if (!is_moved_) return absl::OkStatus();
  std::vector<absl::Status> statuses(static_cast<size_t>(leaves_.trees()));
  base::ParallelFor(leaves_.trees(), options_.threads, [&](int64_t t) {
    const int tree = static_cast<int>(t);
    leaves_.Empty(tree);
    for (size_t i = 0; i < kept_frames_.size(); ++i) {
      const absl::StatusOr<RoutedSamples> samples = memory_->Read(i, tree);
      if (!samples.ok()) {
        statuses[static_cast<size_t>(t)] = samples.status();
        return;
      }
      leaves_.Add(tree, *samples,
                  world_from_sensor_[static_cast<size_t>(kept_frames_[i])]);
    }
  });
  for (const absl::Status& status : statuses) TL_RETURN_IF_ERROR(status);
  for (KeptKeyframe& keyframe : keyframes_) {
    keyframe.placed.world_from_parts =
        world_from_sensor_[static_cast<size_t>(keyframe.frame)];
  }
  is_moved_ = false;
  return absl::OkStatus();
}

geometry::Rigid3 LiveLearner::ModelPose(
    const geometry::Rigid3& world_from_sensor) const {
  return camera::PoseOfSensor(world_from_sensor,
                              geometry_.calibration().pose_sensor,
                              info_.calibration.pose_sensor, info_.calibration);
}

void LiveLearner::KeepFewerKeyframes() {
  while (keyframes_.size() >
         static_cast<size_t>(keyframe_options_.max_keyframes)) {
    keyframe_options_.spacing_m *= kSpacingGrowth;
    std::vector<KeptKeyframe> kept;
    for (const KeptKeyframe& keyframe : keyframes_) {
      if (std::ranges::all_of(kept, [&](const KeptKeyframe& other) {
            return AreApart(other.placed.world_from_color(),
                            keyframe.placed.world_from_color(),
                            keyframe_options_.spacing_m);
          })) {
        kept.push_back(keyframe);
      }
    }
    keyframes_ = std::move(kept);
  }
}

void LiveLearner::LearnWords(const image::Frame& frame) {
  words_.push_back(appearance_.Extract(frame.color));
  if (words_.size() <= kMaxPictures) return;
  std::vector<std::vector<uint32_t>> kept;
  for (size_t i = 0; i < words_.size(); i += 2) {
    kept.push_back(std::move(words_[i]));
  }
  words_ = std::move(kept);
  words_every_ *= 2;
}

// At the end of a block of frames that are learnt.
bool LiveLearner::TrialsAreDue() const {
  const size_t next = static_cast<size_t>(info_.training_frames);
  return !waiting_.empty() && RoleOf(next - 1) == FrameRole::kLearnt &&
         RoleOf(next) != FrameRole::kLearnt;
}

absl::StatusOr<LiveTrials> LiveLearner::BeginTrials() {
  LiveTrials trials;
  trials.frames = std::exchange(held_back_, {});
  TL_ASSIGN_OR_RETURN(trials.model, Model());
  const image::Frame& first = trials.frames.front().frame;
  trials.cover = cover_.depth ? cover_ : trials.frames.back().frame;
  cover_ = first;
  return trials;
}

void LiveLearner::LearnWaiting() {
  for (Prepared& prepared : waiting_) Learn(std::move(prepared));
  waiting_.clear();
}

void LiveLearner::AddTrials(std::vector<ConfidenceTrial> trials) {
  ++tried_frames_;
  if (trials_.size() < kTriedFrames) {
    trials_.push_back(std::move(trials));
    return;
  }
  const uint32_t place = random_.NextBelow(tried_frames_);
  if (place < kTriedFrames) trials_[place] = std::move(trials);
}

void LiveLearner::SetConfidence(LiveModel& model) const {
  std::vector<ConfidenceTrial> all;
  for (const std::vector<ConfidenceTrial>& of_frame : trials_) {
    all.insert(all.end(), of_frame.begin(), of_frame.end());
  }
  const forest::ConfidenceModel confidence =
      FitConfidence(all, forest::ConfidenceModel::Typical());
  for (const ConfidenceTrial& trial : all) {
    if (absl::string_view(trial.view) != "whole") continue;
    ++model.asked;
    if (confidence.Probability(trial.evidence) < confidence.threshold) continue;
    ++(trial.is_right ? model.right : model.wrong);
  }
  model.info.confidence = confidence;
}

absl::StatusOr<LiveModel> LiveLearner::Model() {
  TL_RETURN_IF_ERROR(Settle());
  LiveModel model;
  model.info = info_;
  std::vector<GrownTree> trees(static_cast<size_t>(leaves_.trees()));
  base::ParallelFor(leaves_.trees(), options_.threads, [&](int64_t t) {
    trees[static_cast<size_t>(t)] =
        leaves_.Assemble(static_cast<int>(t), kMinKeptSamples);
  });
  if (std::ranges::any_of(
          trees, [](const GrownTree& tree) { return tree.leaves.empty(); })) {
    return absl::FailedPreconditionError(
        "no pixel of the frames so far has usable depth; check the depth unit "
        "and the depth camera");
  }
  model.forest = QuantizeForest(std::move(trees));
  for (const KeptKeyframe& keyframe : keyframes_) {
    model.keyframes.push_back(keyframe.placed);
  }
  for (const std::vector<uint32_t>& words : words_) {
    model.appearance.Add(words);
  }
  SetConfidence(model);
  return model;
}

absl::StatusOr<LiveModel> LiveLearner::Finish() {
  LearnWaiting();
  return Model();
}

}  // namespace treeline::training
