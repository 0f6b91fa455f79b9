#include "server/core/localizer/points_lines_localizer.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "server/core/pose/preemptive_ransac.h"
#include "server/core/pose/rigid_refinement.h"

namespace treeline::localizer {
namespace {

// Random streams of a query.
constexpr uint64_t kSampleStream = 1;
constexpr uint64_t kRansacStream = 2;
constexpr uint64_t kLineStream = 3;
constexpr uint64_t kOrderStream = 4;

// Below this many samples nothing can be said.
constexpr int kMinSamples = 30;

// Floor of predictions' standard deviation (m): points on lines stand on edges,
// and are nearer to what the leaves say of them than others.
constexpr double kModelSigma_m = 0.005;

// Steps of Levenberg-Marquardt for a hypothesis of RANSAC.
constexpr int kHypothesisIterations = 2;

pose::RefinementOptions PointsAndLines() {
  pose::RefinementOptions options;
  options.likeliest_prediction = true;
  options.levenberg_marquardt = true;
  options.model_sigma_m = kModelSigma_m;
  return options;
}

pose::RefinementOptions ForHypotheses() {
  pose::RefinementOptions options = PointsAndLines();
  options.iterations = kHypothesisIterations;
  return options;
}

void AppendSample(const features::RgbdSamples& from, size_t i,
                  features::RgbdSamples& to) {
  to.x.push_back(from.x[i]);
  to.y.push_back(from.y[i]);
  to.inverse_depth_q12.push_back(from.inverse_depth_q12[i]);
  to.point.push_back(from.point[i]);
  to.depth_sigma_m.push_back(from.depth_sigma_m[i]);
}

}  // namespace

absl::StatusOr<std::unique_ptr<PointsLinesLocalizer>>
PointsLinesLocalizer::Create(std::unique_ptr<const forest::ModelFile> model,
                             PoseVerifier verifier,
                             const QueryOptions& options) {
  if (model->forests() != 2 ||
      model->forest(0).trees() != model->forest(1).trees()) {
    return absl::DataLossError(
        absl::StrCat("corrupt model: method points-lines needs two forests of "
                     "as many trees each, the model has ",
                     model->forests(), " forests"));
  }
  return std::unique_ptr<PointsLinesLocalizer>(
      new PointsLinesLocalizer(std::move(model), std::move(verifier), options));
}

PointsLinesLocalizer::PointsLinesLocalizer(
    std::unique_ptr<const forest::ModelFile> model, PoseVerifier verifier,
    const QueryOptions& options)
    : model_(std::move(model)),
      verifier_(std::move(verifier)),
      options_(options) {}

void PointsLinesLocalizer::Sample(const image::Frame& frame,
                                  const camera::RgbdCalibration& calibration,
                                  uint64_t seed, Scratch& scratch) const {
  const features::DepthGeometry geometry(calibration);
  const image::DepthImage& depth = *frame.depth;
  features::LiftSegments(
      geometry, depth, features::DetectLineSegments(scratch.forest.pyramid, {}),
      {}, scratch.segments);
  features::DrawLinePoints(scratch.segments, options_.samples / 2,
                           base::Random(seed, kLineStream), scratch.lines);
  features::DrawSamples(
      geometry, depth,
      options_.samples - static_cast<int>(scratch.lines.size()),
      base::Random(seed, kSampleStream), scratch.forest.samples);
}

absl::StatusOr<pose::ScenePredictions> PointsLinesLocalizer::Predict(
    const LocalizeOptions& options, Scratch& scratch) const {
  const size_t trees = static_cast<size_t>(model_->forest().trees());
  ForestScratch& forest = scratch.forest;
  std::vector<pose::ScenePrediction> general;
  TL_RETURN_IF_ERROR(PredictScene(model_->forest(0), options_,
                                  {0, forest.samples.size()}, options.stop,
                                  forest, general));
  features::RgbdSamples points = std::move(forest.samples);
  forest.samples = scratch.lines.samples;
  std::vector<pose::ScenePrediction> on_lines;
  TL_RETURN_IF_ERROR(PredictScene(model_->forest(1), options_,
                                  {0, forest.samples.size()}, options.stop,
                                  forest, on_lines));
  // Pruning looks at the points in their order: both kinds from the start.
  const size_t first_line = points.size();
  std::vector<size_t> order(first_line + scratch.lines.size());
  std::iota(order.begin(), order.end(), size_t{0});
  base::Random random(options.seed, kOrderStream);
  for (size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.NextBelow(static_cast<uint32_t>(i))]);
  }
  pose::ScenePredictions scene;
  scene.per_point = static_cast<int>(trees);
  forest.samples.clear();
  for (const size_t from : order) {
    const bool is_line = from >= first_line;
    const size_t i = is_line ? from - first_line : from;
    AppendSample(is_line ? scratch.lines.samples : points, i, forest.samples);
    scene.line_direction_in_camera.push_back(
        is_line
            ? scratch.lines.lines[static_cast<size_t>(scratch.lines.line[i])]
                  .direction
            : geometry::Vec3{});
    const auto first = (is_line ? on_lines : general).begin() +
                       static_cast<std::ptrdiff_t>(i * trees);
    scene.predictions.insert(scene.predictions.end(), first,
                             first + static_cast<std::ptrdiff_t>(trees));
  }
  scene.point_in_camera = forest.samples.point;
  scene.depth_sigma_m.assign(forest.samples.depth_sigma_m.begin(),
                             forest.samples.depth_sigma_m.end());
  return scene;
}

absl::StatusOr<PoseEstimate> PointsLinesLocalizer::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  camera::RgbdCalibration calibration =
      frame.calibration.value_or(info().calibration);
  calibration.pose_sensor = info().calibration.pose_sensor;
  TL_RETURN_IF_ERROR(CheckColor(frame, calibration.color));
  TL_RETURN_IF_ERROR(CheckDepth(frame, calibration.depth, info().method));

  Pool<Scratch>::Lease lease(scratch_);
  ForestScratch& scratch = lease->forest;
  scratch.image.Assign(frame.color);
  scratch.pyramid.Assign(scratch.image);
  Sample(frame, calibration, options.seed, *lease);
  PoseEstimate estimate;
  estimate.samples =
      static_cast<int>(scratch.samples.size() + lease->lines.size());
  const base::MonotonicTime sampled = clock.Now();
  estimate.timings.sample_ms = base::MillisecondsBetween(start, sampled);
  estimate.timings.total_ms = estimate.timings.sample_ms;
  if (estimate.samples < kMinSamples) return estimate;

  TL_ASSIGN_OR_RETURN(const pose::ScenePredictions scene,
                      Predict(options, *lease));
  const base::MonotonicTime predicted = clock.Now();
  estimate.timings.forest_ms = base::MillisecondsBetween(sampled, predicted);

  pose::RansacOptions ransac_options;
  ransac_options.seed = base::MixBits(options.seed + kRansacStream);
  ransac_options.hypotheses = options_.hypotheses;
  ransac_options.refinement = ForHypotheses();
  const std::optional<pose::RansacResult> ransac =
      pose::PreemptiveRansac(scene, ransac_options, options.stop);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  std::optional<pose::RefinedPose> refined;
  if (ransac) {
    refined =
        pose::RefineRigid(scene, ransac->world_from_camera, PointsAndLines());
  }
  estimate.reason = NotLocalizedReason::kTooFewInliers;
  if (refined) {
    estimate.inliers = refined->inliers;
    estimate.inlier_ratio =
        static_cast<double>(refined->inliers) / estimate.samples;
    estimate.world_from_camera = refined->world_from_camera;
    estimate.covariance = refined->covariance;
    verifier_.Judge(scratch.pyramid, &*frame.depth, calibration, options,
                    estimate);
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
  const base::MonotonicTime end = clock.Now();
  estimate.timings.pose_ms = base::MillisecondsBetween(predicted, end);
  estimate.timings.total_ms = base::MillisecondsBetween(start, end);
  return estimate;
}

}  // namespace treeline::localizer
