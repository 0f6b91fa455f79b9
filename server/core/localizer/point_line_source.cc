#include "server/core/localizer/point_line_source.h"

#include <numeric>
#include <utility>

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/forest_prediction.h"
#include "server/core/pose/point_refinement.h"

namespace treeline::localizer {

static_assert(PoseSource<PointLineSource>);

namespace {

pose::PointRefinementOptions PointsAndLines() {
  pose::PointRefinementOptions options;
  options.likeliest_prediction = true;
  options.levenberg_marquardt = true;
  options.model_sigma_m = kPointLineModelSigma_m;
  return options;
}

pose::PointRefinementOptions ForHypotheses() {
  pose::PointRefinementOptions options = PointsAndLines();
  options.iterations = kPointLineHypothesisIterations;
  return options;
}

// 0 to count - 1, shuffled.
std::vector<size_t> RandomOrder(size_t count, base::Random random) {
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  for (size_t i = count; i > 1; --i) {
    std::swap(order[i - 1], order[random.NextBelow(static_cast<uint32_t>(i))]);
  }
  return order;
}

// Sample i with its predictions.
void Append(const features::RgbdSamples& samples,
            const std::vector<pose::ScenePrediction>& predictions, size_t i,
            geometry::Vec3 line_direction, PointObservations& seen) {
  seen.pixel.push_back(
      {static_cast<double>(samples.x[i]), static_cast<double>(samples.y[i])});
  pose::PointPredictions& scene = seen.scene;
  scene.point_in_camera.push_back(samples.point[i]);
  scene.depth_sigma_m.push_back(static_cast<double>(samples.depth_sigma_m[i]));
  scene.line_direction_in_camera.push_back(line_direction);
  const auto first =
      predictions.begin() + static_cast<std::ptrdiff_t>(i) * scene.per_sample;
  scene.predictions.insert(scene.predictions.end(), first,
                           first + scene.per_sample);
}

}  // namespace

void PointLineSource::Sample(Query& query) const {
  const StageTimer timer(query.timings().sample_ms);
  QueryScratch& scratch = query.scratch();
  const features::DepthGeometry geometry(query.calibration());
  features::LiftSegments(geometry, *query.depth(),
                         features::DetectLineSegments(query.pyramid(), {}), {},
                         scratch.segments);
  features::DrawLinePoints(scratch.segments, options_.samples / 2,
                           base::Random(query.seed(), kLineStream),
                           scratch.line_points);
  features::DrawSamples(
      geometry, *query.depth(),
      options_.samples - static_cast<int>(scratch.line_points.size()),
      base::Random(query.seed(), kSampleStream), scratch.samples);
}

absl::StatusOr<size_t> PointLineSource::Observe(
    Query& query, std::span<const Candidate> /*earlier*/,
    PointObservations& seen) const {
  Sample(query);
  const features::RgbdSamples& points = query.scratch().samples;
  const features::LinePoints& lines = query.scratch().line_points;
  const size_t count = points.size() + lines.size();
  if (count < static_cast<size_t>(kMinSamples)) return count;

  const StageTimer timer(query.timings().forest_ms);
  std::vector<pose::ScenePrediction> of_points;
  TL_RETURN_IF_ERROR(PredictScene(*point_forest_, options_, points,
                                  {0, points.size()}, query, of_points));
  std::vector<pose::ScenePrediction> of_lines;
  TL_RETURN_IF_ERROR(PredictScene(*line_forest_, options_, lines.samples,
                                  {0, lines.size()}, query, of_lines));
  seen.scene.per_sample = point_forest_->trees();
  // Pruning looks at the points in their order: both kinds from the start.
  for (const size_t i :
       RandomOrder(count, base::Random(query.seed(), kOrderStream))) {
    if (i < points.size()) {
      Append(points, of_points, i, {}, seen);
      continue;
    }
    const size_t on_line = i - points.size();
    const size_t line = static_cast<size_t>(lines.line[on_line]);
    Append(lines.samples, of_lines, on_line, lines.lines[line].direction, seen);
  }
  return count;
}

pose::PointLineSolver PointLineSource::Solver(
    Query& /*query*/, const PointObservations& seen) const {
  return {seen.scene, {.points = {}, .refinement = ForHypotheses()}};
}

std::optional<pose::RefinedPose> PointLineSource::Refine(
    Query& /*query*/, const PointObservations& seen,
    const geometry::Rigid3& world_from_camera) const {
  return pose::RefinePoints(seen.scene, world_from_camera, PointsAndLines());
}

}  // namespace treeline::localizer
