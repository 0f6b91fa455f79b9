#include "server/core/localizer/hybrid_localizer.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/keyframes/keyframe_features.h"
#include "server/core/localizer/forest_pnp.h"
#include "server/core/pose/pnp.h"

namespace treeline {
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

// Matches as Perspective-n-Point reads them, and where they are.
struct Matches {
  std::vector<Pixel> pixel;
  PixelPredictions scene;
};

Matches AsPredictions(const std::vector<KeyframeMatch>& matches,
                      const Camera& camera) {
  Matches result;
  constexpr double kVariance = kPointSigma_m * kPointSigma_m;
  for (const KeyframeMatch& match : matches) {
    const std::optional<Pixel> ray = camera.Unproject(match.pixel);
    if (!ray) continue;
    result.pixel.push_back(match.pixel);
    result.scene.ray.push_back(*ray);
    result.scene.predictions.push_back(
        {match.point_in_world, {kVariance, 0, 0, kVariance, 0, kVariance}});
  }
  result.scene.ray_sigma.assign(result.scene.size(),
                                kKeypointSigma_px / MeanFocal_px(camera));
  return result;
}

// The pose that the matches support (thesis Eq. 3.12), if enough of them do.
std::optional<PnpResult> SolveMatches(const Matches& matches,
                                      const Camera& camera, int hypotheses,
                                      const LocalizeOptions& options) {
  if (matches.scene.size() < kMinMatches) return std::nullopt;
  const double pixel = 1 / MeanFocal_px(camera);
  PnpOptions ransac;
  ransac.seed = MixBits(options.seed + kRansacStream);
  ransac.hypotheses = hypotheses;
  ransac.inlier_distance = kRansacInlier_px * pixel;
  const std::optional<Rigid3> pose =
      PreemptivePnp(matches.scene, ransac, options.stop);
  if (!pose) return std::nullopt;
  std::optional<PnpResult> refined =
      RefinePnp(matches.scene, *pose,
                {.robust_scale = kRobustScale_px * pixel,
                 .inlier_distance = kInlier_px * pixel});
  if (!refined || refined->inliers < kMinInliers) return std::nullopt;
  return refined;
}

std::vector<Correspondence> CorrespondencesOf(const Matches& matches,
                                              const PnpResult& pose) {
  std::vector<Correspondence> correspondences;
  const Rigid3 camera_from_world = pose.world_from_camera.Inverse();
  for (size_t i = 0; i < matches.pixel.size(); ++i) {
    const Vec3 in_world = matches.scene.at(i, 0).mean_in_world;
    correspondences.push_back({matches.pixel[i], camera_from_world * in_world,
                               in_world, pose.supported[i] >= 0});
  }
  return correspondences;
}

}  // namespace

HybridLocalizer::HybridLocalizer(std::unique_ptr<const ModelFile> model,
                                 PoseVerifier verifier,
                                 const QueryOptions& options)
    : model_(std::move(model)),
      verifier_(std::move(verifier)),
      options_(options) {}

absl::StatusOr<PoseEstimate> HybridLocalizer::Localize(
    const Frame& frame, const LocalizeOptions& options) const {
  const SteadyClock clock;
  const MonotonicTime start = clock.Now();
  const Camera camera = frame.calibration.value_or(info().calibration).color;
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
  if (found.pose) {
    const KeyframeMap& map = verifier_.keyframes();
    const std::vector<size_t> keyframes =
        map.Nearest(found.pose->world_from_camera, MaxKeyframeAngle_rad(camera),
                    kKeyframes);
    Matches matches;
    if (!keyframes.empty()) {
      TL_ASSIGN_OR_RETURN(const SiftFeatures features,
                          ExtractKeyframeSift(frame.color, kFeatures));
      matches = AsPredictions(
          MatchKeyframes(features, map, keyframes, kMaxRatio), camera);
    }
    const std::optional<PnpResult> exact =
        SolveMatches(matches, camera, options_.hypotheses, options);
    if (options.stop.stop_requested()) {
      return absl::CancelledError("the query was cancelled");
    }
    if (exact) estimate.samples = static_cast<int>(matches.scene.size());
    TakePose(exact ? *exact : *found.pose, estimate);
    RgbdCalibration calibration = info().calibration;
    calibration.color = camera;
    scratch.pyramid.Assign(scratch.image);
    verifier_.Judge(scratch.pyramid, nullptr, calibration, estimate);
    if (options.keep_correspondences) {
      estimate.correspondences =
          exact ? CorrespondencesOf(matches, *exact)
                : treeline::CorrespondencesOf(found, scratch);
    }
  }
  SetTotal(MillisecondsBetween(start, clock.Now()), estimate.timings);
  return estimate;
}

}  // namespace treeline
