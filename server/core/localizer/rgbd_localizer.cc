#include "server/core/localizer/rgbd_localizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "server/core/forest/backtracking.h"
#include "server/core/pose/preemptive_ransac.h"
#include "server/core/pose/rigid_refinement.h"

namespace treeline {
namespace {

// Random streams of a query.
constexpr uint64_t kSampleStream = 1;
constexpr uint64_t kRansacStream = 2;

// Below this many samples nothing can be said.
constexpr int kMinSamples = 30;
// An answer needs this many inliers, and this share of the samples.
constexpr int kMinInliers = 25;
constexpr double kMinInlierRatio = 0.10;
// ... and a position that its inliers determine this well (m).
constexpr double kMaxPositionSigma_m = 0.05;

// Leaves of few samples say little about their own spread: their covariance is
// averaged with this standard deviation (m) as if it came from this many
// samples.
constexpr double kPriorSigma_m = 0.02;
constexpr double kPriorSamples = 4;

double PositionSigma_m(const PoseCovariance& covariance) {
  return std::sqrt(std::max({covariance[0], covariance[7], covariance[14]}));
}

}  // namespace

struct RgbdLocalizer::Scratch {
  PlanarImage image;
  RgbdSamples samples;
  std::vector<WhtDescriptor> descriptors;
  std::vector<uint32_t> leaves;
  std::vector<LeafMatch> matches;
};

class RgbdLocalizer::ScratchLease {
 public:
  explicit ScratchLease(const RgbdLocalizer& owner) : owner_(owner) {
    {
      absl::MutexLock lock(&owner_.mutex_);
      if (!owner_.idle_.empty()) {
        scratch_ = std::move(owner_.idle_.back());
        owner_.idle_.pop_back();
      }
    }
    if (scratch_ == nullptr) scratch_ = std::make_unique<Scratch>();
  }
  ~ScratchLease() {
    absl::MutexLock lock(&owner_.mutex_);
    owner_.idle_.push_back(std::move(scratch_));
  }
  ScratchLease(const ScratchLease&) = delete;
  ScratchLease& operator=(const ScratchLease&) = delete;
  Scratch& operator*() { return *scratch_; }

 private:
  const RgbdLocalizer& owner_;
  std::unique_ptr<Scratch> scratch_;
};

RgbdLocalizer::RgbdLocalizer(std::unique_ptr<const ModelFile> model,
                             const QueryOptions& options)
    : model_(std::move(model)), options_(options) {}

RgbdLocalizer::~RgbdLocalizer() = default;

absl::Status RgbdLocalizer::CheckFrame(
    const Frame& frame, const RgbdCalibration& calibration) const {
  if (!frame.depth) {
    return absl::InvalidArgumentError(
        "this scene's method (rgbd) needs a depth image, and the frame has "
        "none");
  }
  const auto check = [](absl::string_view what, int width, int height,
                        const Camera& camera) {
    if (width == camera.width() && height == camera.height()) {
      return absl::OkStatus();
    }
    return absl::InvalidArgumentError(
        absl::StrCat("the ", what, " image has ", width, " x ", height,
                     " pixels, but its camera is calibrated for ",
                     camera.width(), " x ", camera.height()));
  };
  TL_RETURN_IF_ERROR(check("colour", frame.color.width, frame.color.height,
                           calibration.color));
  return check("depth", frame.depth->width, frame.depth->height,
               calibration.depth);
}

void RgbdLocalizer::Predict(const Scratch& scratch,
                            ScenePredictions& scene) const {
  const ForestView& forest = model_->forest();
  const size_t n = scratch.samples.size();
  const size_t trees = static_cast<size_t>(forest.trees());
  scene.per_point = static_cast<int>(trees);
  scene.point_in_camera = scratch.samples.point;
  scene.depth_sigma_m.assign(scratch.samples.depth_sigma_m.begin(),
                             scratch.samples.depth_sigma_m.end());
  scene.predictions.resize(n * trees);
  for (size_t i = 0; i < n * trees; ++i) {
    const LeafMatch& match = scratch.matches[i];
    const LeafPayload& leaf = forest.payloads[match.leaf];
    ScenePrediction& prediction = scene.predictions[i];
    prediction.mean_in_world = forest.LeafMean(match.leaf);
    const double total = leaf.count + kPriorSamples;
    for (size_t k = 0; k < 6; ++k) {
      prediction.covariance[k] =
          leaf.count / total *
          static_cast<double>(FromBfloat16(leaf.covariance[k]));
    }
    const double prior = kPriorSamples / total * kPriorSigma_m * kPriorSigma_m;
    for (const size_t k : {0u, 3u, 5u}) prediction.covariance[k] += prior;
  }
}

absl::StatusOr<PoseEstimate> RgbdLocalizer::Localize(
    const Frame& frame, const LocalizeOptions& options) const {
  const SteadyClock clock;
  const MonotonicTime start = clock.Now();
  RgbdCalibration calibration = frame.calibration.value_or(info().calibration);
  calibration.pose_sensor = info().calibration.pose_sensor;
  TL_RETURN_IF_ERROR(CheckFrame(frame, calibration));

  ScratchLease lease(*this);
  Scratch& scratch = *lease;
  scratch.image.Assign(frame.color);
  DrawSamples(DepthGeometry(calibration), *frame.depth, options_.samples,
              Random(options.seed, kSampleStream), scratch.samples);
  PoseEstimate estimate;
  estimate.samples = static_cast<int>(scratch.samples.size());
  scratch.descriptors.resize(scratch.samples.size());
  ComputeWht(scratch.image, scratch.samples.x, scratch.samples.y,
             scratch.descriptors);
  const MonotonicTime sampled = clock.Now();
  estimate.timings.sample_ms = MillisecondsBetween(start, sampled);
  estimate.timings.total_ms = estimate.timings.sample_ms;
  if (estimate.samples < kMinSamples) return estimate;

  const ForestView& forest = model_->forest();
  scratch.matches.resize(scratch.samples.size() *
                         static_cast<size_t>(forest.trees()));
  PredictLeaves(
      forest, scratch.image,
      {scratch.samples.x, scratch.samples.y, scratch.samples.inverse_depth_q12},
      scratch.descriptors, options_.backtracking_leaves, options.stop,
      scratch.leaves, scratch.matches);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  ScenePredictions scene;
  Predict(scratch, scene);
  const MonotonicTime predicted = clock.Now();
  estimate.timings.forest_ms = MillisecondsBetween(sampled, predicted);

  RansacOptions ransac_options;
  ransac_options.seed = MixBits(options.seed + kRansacStream);
  ransac_options.hypotheses = options_.hypotheses;
  const std::optional<RansacResult> ransac =
      PreemptiveRansac(scene, ransac_options, options.stop);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  std::optional<RefinedPose> refined;
  if (ransac) {
    refined = RefineRigid(scene, ransac->world_from_camera, {});
  }
  estimate.reason = NotLocalizedReason::kTooFewInliers;
  if (refined) {
    estimate.inliers = refined->inliers;
    estimate.inlier_ratio =
        static_cast<double>(refined->inliers) / estimate.samples;
    estimate.world_from_camera = refined->world_from_camera;
    estimate.covariance = refined->covariance;
    if (estimate.inliers >= kMinInliers &&
        estimate.inlier_ratio >= kMinInlierRatio) {
      const bool determined =
          PositionSigma_m(refined->covariance) <= kMaxPositionSigma_m;
      estimate.reason = determined ? NotLocalizedReason::kNone
                                   : NotLocalizedReason::kPoorlyConstrained;
      estimate.outcome =
          determined ? Outcome::kLocalized : Outcome::kNotLocalized;
    }
  }
  if (options.keep_correspondences) {
    for (size_t i = 0; i < scene.size(); ++i) {
      const int8_t k = refined ? refined->supported[i] : int8_t{-1};
      estimate.correspondences.push_back(
          {{static_cast<double>(scratch.samples.x[i]),
            static_cast<double>(scratch.samples.y[i])},
           scene.point_in_camera[i],
           scene.at(i, std::max<int>(k, 0)).mean_in_world,
           k >= 0});
    }
  }
  const MonotonicTime end = clock.Now();
  estimate.timings.pose_ms = MillisecondsBetween(predicted, end);
  estimate.timings.total_ms = MillisecondsBetween(start, end);
  return estimate;
}

}  // namespace treeline
