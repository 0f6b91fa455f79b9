#include "server/core/localizer/hybrid_localizer.h"

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/forest_pnp.h"
#include "server/core/pose/pnp.h"

namespace treeline::localizer {

// Matches as Perspective-n-Point reads them, where they are, and the pose that
// they support (thesis Eq. 3.12), if enough of them do.
struct HybridLocalizer::MatchedPose {
  std::vector<camera::Pixel> pixel;
  pose::PixelPredictions scene;
  std::optional<pose::PnpResult> pose;
};

namespace {

// The random stream of a query; SolveForestPnp has 1 and 2.
constexpr uint64_t kRansacStream = 3;

// Keyframes matched with.
constexpr size_t kKeyframes = 3;
// Features of a query.
constexpr int kFeatures = 1000;
// Lowe's ratio, for matches that are each other's nearest.
constexpr double kMaxRatio = 0.85;
constexpr size_t kMinMatches = 8;
// A pose that so many matches support is preferred to the forest's.
constexpr int kMinInliers = 15;

constexpr double kKeypointSigma_px = 1;
// A keyframe's point (m): its pose and its depth.
constexpr double kPointSigma_m = 0.01;
constexpr double kRansacInlier_px = 8;
constexpr double kRobustScale_px = 3;
constexpr double kInlier_px = 6;

std::vector<Correspondence> CorrespondencesOf(const auto& matched) {
  std::vector<Correspondence> correspondences;
  const geometry::Rigid3 camera_from_world =
      matched.pose->world_from_camera.Inverse();
  for (size_t i = 0; i < matched.pixel.size(); ++i) {
    const geometry::Vec3 in_world = matched.scene.at(i, 0).mean_in_world;
    correspondences.push_back({matched.pixel[i], camera_from_world * in_world,
                               in_world, matched.pose->supported[i] >= 0});
  }
  return correspondences;
}

}  // namespace

HybridLocalizer::HybridLocalizer(std::unique_ptr<const forest::ModelFile> model,
                                 PoseVerifier verifier,
                                 const QueryOptions& options)
    : model_(std::move(model)),
      verifier_(std::move(verifier)),
      options_(options) {}

HybridLocalizer::MatchedPose HybridLocalizer::SolveKeyframes(
    const features::SiftFeatures& features, std::span<const size_t> keyframes,
    const camera::Camera& camera, const LocalizeOptions& options) const {
  constexpr double kVariance = kPointSigma_m * kPointSigma_m;
  MatchedPose result;
  pose::PixelPredictions& scene = result.scene;
  for (const keyframes::KeyframeMatch& match : keyframes::MatchKeyframes(
           features, verifier_.keyframes(), keyframes, kMaxRatio)) {
    const std::optional<camera::Pixel> ray = camera.Unproject(match.pixel);
    if (!ray) continue;
    result.pixel.push_back(match.pixel);
    scene.ray.push_back(*ray);
    scene.predictions.push_back(
        {match.point_in_world, {kVariance, 0, 0, kVariance, 0, kVariance}});
  }
  if (scene.size() < kMinMatches) return result;
  const double pixel = 1 / camera::MeanFocal_px(camera);
  scene.ray_sigma.assign(scene.size(), kKeypointSigma_px * pixel);
  pose::PnpOptions ransac;
  ransac.seed = base::MixBits(options.seed + kRansacStream);
  ransac.hypotheses = options_.hypotheses;
  ransac.inlier_distance = kRansacInlier_px * pixel;
  const std::optional<geometry::Rigid3> pose =
      pose::PreemptivePnp(scene, ransac, options.stop);
  if (!pose) return result;
  result.pose = pose::RefinePnp(scene, *pose,
                                {.robust_scale = kRobustScale_px * pixel,
                                 .inlier_distance = kInlier_px * pixel});
  if (result.pose && result.pose->inliers < kMinInliers) result.pose.reset();
  return result;
}

absl::StatusOr<PoseEstimate> HybridLocalizer::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  const camera::Camera camera =
      frame.calibration.value_or(info().calibration).color;
  TL_RETURN_IF_ERROR(CheckColor(frame, camera));

  Pool<ForestScratch>::Lease lease(scratch_);
  ForestScratch& scratch = *lease;
  scratch.image.Assign(frame.color);
  PoseEstimate estimate;
  TL_ASSIGN_OR_RETURN(const ForestPnpResult found,
                      SolveForestPnp(model_->forest(), camera, options_,
                                     options, scratch, estimate));
  if (found.scene.size() > 0) {
    estimate.reason = NotLocalizedReason::kTooFewInliers;
  }
  const keyframes::KeyframeMap& map = verifier_.keyframes();
  TL_ASSIGN_OR_RETURN(const features::SiftFeatures features,
                      keyframes::ExtractKeyframeSift(frame.color, kFeatures));
  std::vector<size_t> keyframes;
  if (found.pose) {
    keyframes =
        map.Nearest(found.pose->world_from_camera,
                    keyframes::MaxKeyframeAngle_rad(camera), kKeyframes);
  }
  MatchedPose matched = SolveKeyframes(features, keyframes, camera, options);
  if (!matched.pose) {
    // The forest was wrong, or saw nothing.
    keyframes = keyframes::MostAlike(features, map, kKeyframes, kMaxRatio);
    matched = SolveKeyframes(features, keyframes, camera, options);
  }
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  if (matched.pose || found.pose) {
    if (matched.pose) estimate.samples = static_cast<int>(matched.pixel.size());
    TakePose(matched.pose ? *matched.pose : *found.pose, estimate);
    camera::RgbdCalibration calibration = info().calibration;
    calibration.color = camera;
    scratch.pyramid.Assign(scratch.image);
    verifier_.Judge(scratch.pyramid, nullptr, calibration, options, estimate);
  }
  if (options.keep_correspondences) {
    estimate.correspondences = matched.pose ? CorrespondencesOf(matched)
                                            : CorrespondencesOf(found, scratch);
  }
  SetTotal(base::MillisecondsBetween(start, clock.Now()), estimate.timings);
  return estimate;
}

}  // namespace treeline::localizer
