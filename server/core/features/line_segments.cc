#include "server/core/features/line_segments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "server/core/features/parameters.h"
#include "server/core/features/pixel_difference.h"
#include "server/core/features/walsh_hadamard.h"

namespace treeline::features {
namespace {

constexpr uint64_t kLineStream = 0x6c696e6500000000;

// A step along a segment: position, and depth seen from the colour camera.
struct Step {
  double along_px = 0;
  camera::Pixel pixel;
  geometry::Vec3 ray;        // through the pixel, z = 1
  double inverse_depth = 0;  // of the colour camera (1/m, scaled)
  double sigma = 0;          // its standard deviation
  double depth_sigma_m = 0;
};

// Inverse depth along a segment.
struct InverseDepthLine {
  double at_start = 0;
  double per_px = 0;

  double At(double along_px) const { return at_start + per_px * along_px; }
};

// Depth of the surface seen at a depth pixel (m, not scaled): where several
// are, of the nearest. 0: none is measured.
double SurfaceDepth_m(const image::DepthImage& depth, int u, int v) {
  uint16_t window[(2 * kDepthRadius_px + 1) * (2 * kDepthRadius_px + 1)];
  size_t count = 0;
  for (int y = std::max(0, v - kDepthRadius_px);
       y <= std::min(depth.height - 1, v + kDepthRadius_px); ++y) {
    const uint16_t* row = depth.values.data() + y * depth.width;
    for (int x = std::max(0, u - kDepthRadius_px);
         x <= std::min(depth.width - 1, u + kDepthRadius_px); ++x) {
      if (image::IsMeasured(row[x])) window[count++] = row[x];
    }
  }
  if (count == 0) return 0;
  const double limit =
      (1 + kMaxSurfaceGap) * *std::min_element(window, window + count);
  const auto end = std::remove_if(window, window + count,
                                  [&](uint16_t d) { return d > limit; });
  const auto middle = window + (end - window) / 2;
  std::nth_element(window, middle, end);
  return *middle * depth.unit_m;
}

// Finds what a colour pixel sees in a depth image taken from beside it.
class DepthLookup {
 public:
  DepthLookup(const DepthGeometry& geometry, const image::DepthImage& depth)
      : geometry_(geometry),
        depth_(depth),
        depth_from_color_(geometry.calibration().color_from_depth.Inverse()),
        rotation_(depth_from_color_.rotation.Matrix()) {}

  // Sets ray, inverse_depth and the sigmas. guess_m is a depth to start from,
  // and becomes the one found. The right depth is a fixed point of: project the
  // colour pixel at this depth into the depth image, and read it there.
  bool Find(Step& step, double& guess_m) const {
    const camera::RgbdCalibration& calibration = geometry_.calibration();
    const std::optional<camera::Pixel> ray =
        calibration.color.Unproject(step.pixel);
    if (!ray) return false;
    step.ray = {ray->x, ray->y, 1};
    double z = guess_m;
    int u = -1;
    int v = -1;
    double depth_m = 0;
    for (int i = 0; i < kDepthLookups; ++i) {
      const geometry::Vec3 in_depth =
          rotation_ * (z * step.ray) + depth_from_color_.translation;
      if (!(in_depth.z > 0)) return false;
      const camera::Pixel p = calibration.depth.Project(in_depth);
      if (!(p.x > -0.5 && p.y > -0.5 && p.x < depth_.width - 0.5 &&
            p.y < depth_.height - 0.5)) {
        return false;
      }
      const int next_u = static_cast<int>(std::lround(p.x));
      const int next_v = static_cast<int>(std::lround(p.y));
      if (next_u == u && next_v == v) break;
      u = next_u;
      v = next_v;
      depth_m = SurfaceDepth_m(depth_, u, v);
      if (depth_m < kMinDepth_m || depth_m > kMaxDepth_m) return false;
      DepthGeometry::Lifted lifted;
      if (!geometry_.Lift(u, v, depth_m, lifted)) return false;
      z = lifted.point_in_color.z;
      const double miss = std::hypot(lifted.color_pixel.x - step.pixel.x,
                                     lifted.color_pixel.y - step.pixel.y);
      if (i + 1 == kDepthLookups && !(miss <= kMaxDepthMiss_px)) return false;
    }
    guess_m = z;
    step.inverse_depth = 1 / z;
    step.depth_sigma_m = DepthSigma_m(depth_m);
    step.sigma = step.depth_sigma_m / (z * z);
    return true;
  }

 private:
  const DepthGeometry& geometry_;
  const image::DepthImage& depth_;
  const geometry::Rigid3 depth_from_color_;
  const geometry::Mat3 rotation_;
};

bool IsOn(const InverseDepthLine& line, const Step& step) {
  return std::abs(line.At(step.along_px) - step.inverse_depth) <=
         kMaxLineDeviation * step.sigma;
}

// Weighted least squares on the steps that lie on `line`.
InverseDepthLine Refit(const std::vector<Step>& steps,
                       const InverseDepthLine& line) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const Step& step : steps) {
    if (!IsOn(line, step)) continue;
    const double w = 1 / (step.sigma * step.sigma);
    n += w;
    x += w * step.along_px;
    y += w * step.inverse_depth;
    xx += w * step.along_px * step.along_px;
    xy += w * step.along_px * step.inverse_depth;
  }
  const double determinant = n * xx - x * x;
  if (!(determinant > 1e-9 * n * xx)) return line;
  const double per_px = (n * xy - x * y) / determinant;
  return {(y - per_px * x) / n, per_px};
}

// The line that most steps lie on.
InverseDepthLine FitInverseDepth(const std::vector<Step>& steps,
                                 base::Random random) {
  const uint32_t count = static_cast<uint32_t>(steps.size());
  InverseDepthLine best;
  std::ptrdiff_t most = -1;
  for (int h = 0; h < kLineHypotheses; ++h) {
    const Step& a = steps[random.NextBelow(count)];
    const Step& b = steps[random.NextBelow(count)];
    if (a.along_px == b.along_px) continue;
    const double per_px =
        (b.inverse_depth - a.inverse_depth) / (b.along_px - a.along_px);
    const InverseDepthLine line{a.inverse_depth - per_px * a.along_px, per_px};
    const std::ptrdiff_t on = std::ranges::count_if(
        steps, [&](const Step& step) { return IsOn(line, step); });
    if (on > most) {
      most = on;
      best = line;
    }
  }
  for (int i = 0; i < kLineFitRounds; ++i) best = Refit(steps, best);
  return best;
}

// Steps of a segment whose patch lies inside the image, with those that have
// depth in `steps`; returns how many there are in all.
int Walk(const LineSegment& segment, const DepthLookup& lookup,
         const camera::Camera& color, double step_px,
         std::vector<Step>& steps) {
  steps.clear();
  const double length =
      std::hypot(segment.b.x - segment.a.x, segment.b.y - segment.a.y);
  const int intervals = std::max(1, static_cast<int>(length / step_px));
  double guess_m = kFirstDepth_m;
  int inside = 0;
  for (int i = 0; i <= intervals; ++i) {
    const double t = static_cast<double>(i) / intervals;
    Step step;
    step.along_px = t * length;
    step.pixel = {segment.a.x + t * (segment.b.x - segment.a.x),
                  segment.a.y + t * (segment.b.y - segment.a.y)};
    if (!PatchInside(static_cast<int>(std::lround(step.pixel.x)),
                     static_cast<int>(std::lround(step.pixel.y)), color.width(),
                     color.height())) {
      continue;
    }
    ++inside;
    if (lookup.Find(step, guess_m)) {
      steps.push_back(step);
    } else {
      guess_m = kFirstDepth_m;
    }
  }
  return inside;
}

void Append(const DepthGeometry& geometry, const std::vector<Step>& steps,
            const InverseDepthLine& line, LinePoints& points) {
  const camera::RgbdCalibration& calibration = geometry.calibration();
  const geometry::Rigid3 sensor_from_color = camera::PoseOfSensor(
      {}, calibration.pose_sensor, camera::RgbdSensor::kColor, calibration);
  const double focal_px = camera::MeanFocal_px(calibration.color);
  RgbdSamples& samples = points.samples;
  const size_t first = samples.size();
  for (const Step& step : steps) {
    const double z = 1 / line.At(step.along_px);
    samples.x.push_back(static_cast<int32_t>(std::lround(step.pixel.x)));
    samples.y.push_back(static_cast<int32_t>(std::lround(step.pixel.y)));
    samples.inverse_depth_q12.push_back(InverseDepthQ12(focal_px, z));
    samples.point.push_back(sensor_from_color * (z * step.ray));
    samples.depth_sigma_m.push_back(static_cast<float>(step.depth_sigma_m));
    points.line.push_back(static_cast<int32_t>(points.lines.size()));
  }
  const geometry::Vec3 start = samples.point[first];
  points.lines.push_back(
      {start, geometry::Normalized(samples.point.back() - start)});
}

}  // namespace

void LinePoints::clear() {
  samples.clear();
  line.clear();
  lines.clear();
}

std::vector<LineSegment> DetectLineSegments(const GrayPyramid& pyramid,
                                            const LineOptions& options) {
  const double factor = 1 << options.level;
  const auto at_level_0 = [&](camera::Pixel p) -> camera::Pixel {
    return {(p.x + 0.5) * factor - 0.5, (p.y + 0.5) * factor - 0.5};
  };
  struct Candidate {
    double length_px;
    LineSegment segment;
  };
  std::vector<Candidate> candidates;
  for (const LineSegment& found :
       FindLineSegments(pyramid.level(options.level))) {
    const LineSegment s{at_level_0(found.a), at_level_0(found.b)};
    const double length_px = std::hypot(s.b.x - s.a.x, s.b.y - s.a.y);
    if (length_px >= options.min_length_px)
      candidates.push_back({length_px, s});
  }
  std::ranges::stable_sort(candidates,
                           [](const Candidate& a, const Candidate& b) {
                             return a.length_px > b.length_px;
                           });
  std::vector<LineSegment> segments;
  const size_t kept =
      std::min(candidates.size(), static_cast<size_t>(options.max_segments));
  for (size_t i = 0; i < kept; ++i) segments.push_back(candidates[i].segment);
  return segments;
}

void LiftSegments(const DepthGeometry& geometry, const image::DepthImage& depth,
                  const std::vector<LineSegment>& segments,
                  const LineOptions& options, LinePoints& points) {
  points.clear();
  const DepthLookup lookup(geometry, depth);
  std::vector<Step> steps;
  for (size_t s = 0; s < segments.size(); ++s) {
    const int inside = Walk(segments[s], lookup, geometry.calibration().color,
                            options.step_px, steps);
    const double needed =
        std::max<double>(options.min_points, options.min_support * inside);
    if (static_cast<double>(steps.size()) < needed) continue;
    const InverseDepthLine line = FitInverseDepth(
        steps, base::Random(0, kLineStream + static_cast<uint64_t>(s)));
    std::erase_if(steps, [&](const Step& step) {
      return !IsOn(line, step) || line.At(step.along_px) < 1 / kMaxDepth_m;
    });
    if (static_cast<double>(steps.size()) < needed) continue;
    Append(geometry, steps, line, points);
  }
}

void DrawLinePoints(const LinePoints& points, int count, base::Random random,
                    LinePoints& drawn) {
  drawn.clear();
  drawn.lines = points.lines;
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const size_t wanted = std::min(order.size(), static_cast<size_t>(count));
  for (size_t i = 0; i < wanted; ++i) {
    const size_t j =
        i + random.NextBelow(static_cast<uint32_t>(order.size() - i));
    std::swap(order[i], order[j]);
    const size_t from = order[i];
    drawn.samples.x.push_back(points.samples.x[from]);
    drawn.samples.y.push_back(points.samples.y[from]);
    drawn.samples.inverse_depth_q12.push_back(
        points.samples.inverse_depth_q12[from]);
    drawn.samples.point.push_back(points.samples.point[from]);
    drawn.samples.depth_sigma_m.push_back(points.samples.depth_sigma_m[from]);
    drawn.line.push_back(points.line[from]);
  }
}

}  // namespace treeline::features
