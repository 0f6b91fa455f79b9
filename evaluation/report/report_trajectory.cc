#include "evaluation/report/report_trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/report/report_svg.h"

namespace treeline::report {
namespace {

constexpr double kWidth = 1100;
constexpr double kMaxHeight = 520;
constexpr double kMargin = 26;
constexpr double kGap = 48;
constexpr int kFrusta = 14;

// `v`, or `fallback` where v has no direction to speak of.
geometry::Vec3 DirectionOr(geometry::Vec3 v, geometry::Vec3 fallback) {
  return geometry::Norm(v) > 1e-6 ? geometry::Normalized(v) : fallback;
}

geometry::Vec3 WithoutComponent(geometry::Vec3 v, geometry::Vec3 unit) {
  return v - geometry::Dot(v, unit) * unit;
}

// Coordinates of a point along the three view axes (m).
std::array<double, 3> Along(const ViewAxes& axes,
                            geometry::Vec3 point_in_world) {
  return {geometry::Dot(point_in_world, axes.right_in_world),
          geometry::Dot(point_in_world, axes.forward_in_world),
          geometry::Dot(point_in_world, axes.up_in_world)};
}

// Ranges of positions along the three view axes (m).
struct Box {
  std::array<double, 3> low{1e300, 1e300, 1e300};
  std::array<double, 3> high{-1e300, -1e300, -1e300};

  void Add(const std::array<double, 3>& at) {
    for (size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  void Grow(double by) {
    for (size_t k = 0; k < 3; ++k) {
      low[k] -= by;
      high[k] += by;
    }
  }
  double Extent(size_t k) const { return high[k] - low[k]; }
  bool Contains(const std::array<double, 3>& at) const {
    for (size_t k = 0; k < 3; ++k) {
      if (at[k] < low[k] || at[k] > high[k]) return false;
    }
    return true;
  }
};

// Both views at one scale: axis k of ViewAxes to pixels.
class Drawing {
 public:
  Drawing(const ViewAxes& axes, const Box& box) : axes_(axes), box_(box) {
    const double across = box.Extent(0) + box.Extent(1);
    const double tall = std::max(box.Extent(1), box.Extent(2));
    scale_ = std::min((kWidth - 2 * kMargin - kGap) / across,
                      (kMaxHeight - 2 * kMargin - 30) / tall);
    // Centred in the width.
    left_ = (kWidth - kGap - scale_ * across) / 2;
    height_ = scale_ * tall + 2 * kMargin + 30;
  }

  // "x y" of a point seen from above (right, forward) or, to its right, from
  // the side (forward, up).
  std::string At(geometry::Vec3 point_in_world, bool from_above) const {
    const std::array<double, 3> at = Along(axes_, point_in_world);
    const double x = from_above ? left_ + scale_ * (at[0] - box_.low[0])
                                : side_left() + scale_ * (at[1] - box_.low[1]);
    const double y = from_above ? scale_ * (box_.high[1] - at[1])
                                : scale_ * (box_.high[2] - at[2]);
    return absl::StrFormat("%.1f %.1f", x, y + kMargin + 24);
  }

  double side_left() const { return left_ + scale_ * box_.Extent(0) + kGap; }
  double left() const { return left_; }
  double scale() const { return scale_; }
  double height() const { return height_; }
  bool Shows(const geometry::Rigid3& pose) const {
    return box_.Contains(Along(axes_, pose.translation));
  }

 private:
  const ViewAxes axes_;
  const Box box_;
  double scale_ = 1;
  double left_ = 0;
  double height_ = 0;
};

// Lines from the centre to the corners of an image `depth_m` away, and round.
std::string FrustumPath(const Drawing& drawing,
                        const geometry::Rigid3& world_from_camera,
                        double depth_m, bool from_above) {
  const std::array<geometry::Vec3, 4> corners{
      geometry::Vec3{-0.55, -0.41, 1}, geometry::Vec3{0.55, -0.41, 1},
      geometry::Vec3{0.55, 0.41, 1}, geometry::Vec3{-0.55, 0.41, 1}};
  const std::string apex =
      drawing.At(world_from_camera.translation, from_above);
  std::string path;
  std::string rim;
  for (const geometry::Vec3& corner : corners) {
    const std::string at =
        drawing.At(world_from_camera * (depth_m * corner), from_above);
    absl::StrAppend(&path, "M", apex, "L", at);
    absl::StrAppend(&rim, rim.empty() ? "M" : "L", at);
  }
  return absl::StrCat(path, rim, "Z");
}

std::string TruePath(const Drawing& drawing,
                     const std::vector<const accuracy::FrameResult*>& truths,
                     bool from_above) {
  const double long_step = LongStep_m(truths);
  std::string path;
  geometry::Vec3 previous;
  for (const accuracy::FrameResult* result : truths) {
    const geometry::Vec3 at = result->true_world_from_camera->translation;
    const bool move = path.empty() || geometry::Norm(at - previous) > long_step;
    absl::StrAppend(&path, move ? "M" : "L", drawing.At(at, from_above));
    previous = at;
  }
  return path;
}

// Dots where the training cameras were.
std::string TrainingDots(const Drawing& drawing,
                         const std::vector<geometry::Rigid3>& training,
                         bool from_above) {
  std::string path;
  for (const geometry::Rigid3& pose : training) {
    if (!drawing.Shows(pose)) continue;
    absl::StrAppend(&path, "M", drawing.At(pose.translation, from_above), "h0");
  }
  return absl::StrFormat("<path d=\"%s\" class=\"training\"/>\n", path);
}

// Where every few cameras looked, in truth and as estimated.
std::string Frusta(const Drawing& drawing,
                   const std::vector<const accuracy::FrameResult*>& truths,
                   double frustum_m, bool from_above) {
  const size_t stride = std::max<size_t>(1, truths.size() / kFrusta);
  std::string true_path;
  std::string estimated_path;
  for (size_t i = 0; i < truths.size(); i += stride) {
    absl::StrAppend(&true_path,
                    FrustumPath(drawing, *truths[i]->true_world_from_camera,
                                frustum_m, from_above));
    const geometry::Rigid3& estimate = truths[i]->estimate.world_from_camera;
    if (!truths[i]->localized() || !drawing.Shows(estimate)) continue;
    absl::StrAppend(&estimated_path,
                    FrustumPath(drawing, estimate, frustum_m, from_above));
  }
  return absl::StrFormat(
      "<path d=\"%s\" class=\"truefrustum\"/>\n"
      "<path d=\"%s\" class=\"frustum\"/>\n",
      true_path, estimated_path);
}

// A frame's estimate, joined with its truth; a cross at the truth if there is
// none.
std::string EstimateMark(const Drawing& drawing,
                         const accuracy::FrameResult& result, bool from_above) {
  const geometry::Rigid3& estimate = result.estimate.world_from_camera;
  const std::string from =
      drawing.At(result.true_world_from_camera->translation, from_above);
  if (!result.localized()) {
    return absl::StrFormat(
        "<path d=\"M%sm-3.5 -3.5l7 7m0 -7l-7 7\" class=\"lost\"><title>%s: "
        "not localized</title></path>\n",
        from, EscapeHtml(result.stem));
  }
  if (!drawing.Shows(estimate)) return "";
  const char* far = accuracy::IsWithin(result, 0.05, 5) ? "" : " far";
  const std::string to = drawing.At(estimate.translation, from_above);
  return absl::StrFormat(
      "<path d=\"M%sL%s\" class=\"whisker%s\"/>"
      "<path d=\"M%sh0\" class=\"place%s\"><title>%s: %.1f cm, "
      "%.2f°</title></path>\n",
      from, to, far, to, far, EscapeHtml(result.stem),
      100 * result.error->translation_m,
      result.error->rotation_rad * 57.29577951308232);
}

// Everything drawn in one view.
std::string View(const Drawing& drawing,
                 const std::vector<const accuracy::FrameResult*>& truths,
                 const std::vector<geometry::Rigid3>& training,
                 double frustum_m, bool from_above) {
  std::string svg =
      absl::StrCat(TrainingDots(drawing, training, from_above),
                   Frusta(drawing, truths, frustum_m, from_above));
  for (const accuracy::FrameResult* result : truths) {
    absl::StrAppend(&svg, EstimateMark(drawing, *result, from_above));
  }
  absl::StrAppendFormat(&svg, "<path d=\"%s\" class=\"truth\"/>\n",
                        TruePath(drawing, truths, from_above));
  return svg;
}

std::string ScaleBar(const Drawing& drawing) {
  const double metres = RoundTicks(130 / drawing.scale(), 3).back();
  const double length = metres * drawing.scale();
  const double y = drawing.height() - 8;
  const std::string label = metres < 0.995
                                ? absl::StrFormat("%g cm", 100 * metres)
                                : absl::StrFormat("%g m", metres);
  return absl::StrFormat(
      "<path d=\"M%.1f %.1fv-5v5h%.1fv-5\" class=\"axisline\"/>"
      "<text x=\"%.1f\" y=\"%.1f\" class=\"tick\">%s</text>\n",
      drawing.left(), y, length, drawing.left() + length + 8, y + 1, label);
}

}  // namespace

double LongStep_m(const std::vector<const accuracy::FrameResult*>& truths) {
  std::vector<double> steps;
  for (size_t i = 1; i < truths.size(); ++i) {
    steps.push_back(
        geometry::Norm(truths[i]->true_world_from_camera->translation -
                       truths[i - 1]->true_world_from_camera->translation));
  }
  return 8 * accuracy::Percentile(steps, 75).value_or(0) + 0.02;
}

ViewAxes AxesOfCameras(const std::vector<geometry::Rigid3>& world_from_camera) {
  geometry::Vec3 up;
  geometry::Vec3 forward;
  for (const geometry::Rigid3& pose : world_from_camera) {
    up = up - pose.rotation * geometry::Vec3{0, 1, 0};
    forward = forward + pose.rotation * geometry::Vec3{0, 0, 1};
  }
  ViewAxes axes;
  axes.up_in_world = DirectionOr(up, {0, 0, 1});
  const geometry::Vec3 other = std::abs(axes.up_in_world.x) < 0.7
                                   ? geometry::Vec3{1, 0, 0}
                                   : geometry::Vec3{0, 1, 0};
  axes.forward_in_world = DirectionOr(
      WithoutComponent(forward, axes.up_in_world),
      geometry::Normalized(WithoutComponent(other, axes.up_in_world)));
  axes.right_in_world =
      geometry::Cross(axes.forward_in_world, axes.up_in_world);
  return axes;
}

std::string TrajectoryChart(
    const std::vector<accuracy::FrameResult>& results,
    const std::vector<geometry::Rigid3>& training_poses) {
  std::vector<const accuracy::FrameResult*> truths;
  std::vector<geometry::Rigid3> poses;
  for (const accuracy::FrameResult& result : results) {
    if (!result.true_world_from_camera) continue;
    truths.push_back(&result);
    poses.push_back(*result.true_world_from_camera);
  }
  if (truths.empty()) return "";
  const ViewAxes axes = AxesOfCameras(poses);
  poses.insert(poses.end(), training_poses.begin(), training_poses.end());
  Box box;
  for (const geometry::Rigid3& pose : poses) {
    box.Add(Along(axes, pose.translation));
  }
  const double size =
      std::max({box.Extent(0), box.Extent(1), box.Extent(2), 0.05});
  // Estimates somewhat off belong into the picture; wild ones would shrink it.
  for (const accuracy::FrameResult* result : truths) {
    if (!result->error || result->error->translation_m > 0.5 * size) continue;
    box.Add(Along(axes, result->estimate.world_from_camera.translation));
  }
  const double frustum_m = 0.06 * size;
  box.Grow(1.3 * frustum_m);
  const Drawing drawing(axes, box);
  std::string svg = absl::StrFormat(
      "<svg class=\"chart wide\" viewBox=\"0 0 %g %.0f\" role=\"img\" "
      "aria-label=\"Trajectory\">\n"
      "<text x=\"%.1f\" y=\"16\" class=\"label\">from above</text>\n"
      "<text x=\"%.1f\" y=\"16\" class=\"label\">from the side</text>\n",
      kWidth, drawing.height() + 6, drawing.left(), drawing.side_left());
  absl::StrAppend(&svg, View(drawing, truths, training_poses, frustum_m, true),
                  View(drawing, truths, training_poses, frustum_m, false),
                  ScaleBar(drawing), "</svg>\n");
  int outside = 0;
  for (const accuracy::FrameResult* result : truths) {
    outside += result->localized() &&
               !drawing.Shows(result->estimate.world_from_camera);
  }
  if (outside > 0) {
    absl::StrAppendFormat(&svg,
                          "<p class=\"note\">%d estimate%s lie%s outside this "
                          "picture.</p>\n",
                          outside, outside == 1 ? "" : "s",
                          outside == 1 ? "s" : "");
  }
  return svg;
}

}  // namespace treeline::report
