#include "evaluation/report/report_turntable.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/report/report_trajectory.h"

namespace treeline::report {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr int kViews = 12;
// How far above the horizon the picture is taken from.
constexpr double kElevation_rad = 0.5;
constexpr double kWidth = 1100;
constexpr double kHeight = 460;
constexpr double kMargin = 24;
constexpr size_t kFrusta = 24;
constexpr size_t kTrainingDots = 300;
constexpr int kDiscSteps = 72;

// Parallel projection of the scene, turned about the vertical by an angle.
class Projection {
 public:
  Projection(const ViewAxes& axes, geometry::Vec3 middle_in_world, double scale,
             double angle_rad)
      : axes_(axes),
        middle_(middle_in_world),
        scale_(scale),
        cos_(std::cos(angle_rad)),
        sin_(std::sin(angle_rad)) {}

  // "x y" in the picture (px).
  std::string At(geometry::Vec3 point_in_world) const {
    const geometry::Vec3 from_middle = point_in_world - middle_;
    const double right = geometry::Dot(from_middle, axes_.right_in_world);
    const double forward = geometry::Dot(from_middle, axes_.forward_in_world);
    const double up = geometry::Dot(from_middle, axes_.up_in_world);
    const double across = cos_ * right + sin_ * forward;
    const double away = cos_ * forward - sin_ * right;
    const double y =
        std::cos(kElevation_rad) * up + std::sin(kElevation_rad) * away;
    return absl::StrFormat("%.1f %.1f", kWidth / 2 + scale_ * across,
                           kHeight / 2 - scale_ * y);
  }

 private:
  const ViewAxes& axes_;
  const geometry::Vec3 middle_;
  const double scale_;
  const double cos_;
  const double sin_;
};

std::string Frustum(const Projection& projection,
                    const geometry::Rigid3& world_from_camera, double depth_m) {
  const std::array<geometry::Vec3, 4> corners{
      geometry::Vec3{-0.55, -0.41, 1}, geometry::Vec3{0.55, -0.41, 1},
      geometry::Vec3{0.55, 0.41, 1}, geometry::Vec3{-0.55, 0.41, 1}};
  const std::string apex = projection.At(world_from_camera.translation);
  std::string path;
  std::string rim;
  for (const geometry::Vec3& corner : corners) {
    const std::string at =
        projection.At(world_from_camera * (depth_m * corner));
    absl::StrAppend(&path, "M", apex, "L", at);
    absl::StrAppend(&rim, rim.empty() ? "M" : "L", at);
  }
  return absl::StrCat(path, rim, "Z");
}

struct Scene {
  std::vector<const accuracy::FrameResult*> truths;
  const std::vector<geometry::Rigid3>& training;
  ViewAxes axes{};
  geometry::Vec3 middle_in_world{};
  // Of a cylinder about the vertical through the middle that holds all cameras.
  double radius_m = 0.05;
  double half_height_m = 0.02;
};

Scene MakeScene(const std::vector<accuracy::FrameResult>& results,
                const std::vector<geometry::Rigid3>& training) {
  Scene scene{.truths = {}, .training = training};
  std::vector<geometry::Rigid3> poses;
  for (const accuracy::FrameResult& result : results) {
    if (!result.true_world_from_camera) continue;
    scene.truths.push_back(&result);
    poses.push_back(*result.true_world_from_camera);
  }
  scene.axes = AxesOfCameras(poses);
  poses.insert(poses.end(), training.begin(), training.end());
  for (const geometry::Rigid3& pose : poses) {
    scene.middle_in_world =
        scene.middle_in_world +
        pose.translation / static_cast<double>(poses.size());
  }
  for (const geometry::Rigid3& pose : poses) {
    const geometry::Vec3 from_middle = pose.translation - scene.middle_in_world;
    const double up = geometry::Dot(from_middle, scene.axes.up_in_world);
    scene.half_height_m = std::max(scene.half_height_m, std::abs(up));
    scene.radius_m =
        std::max(scene.radius_m,
                 geometry::Norm(from_middle - up * scene.axes.up_in_world));
  }
  return scene;
}

// The turntable itself, below the cameras: a disc with four spokes, of which
// one points where the cameras look on average.
std::string Disc(const Scene& scene, const Projection& projection) {
  const geometry::Vec3 centre =
      scene.middle_in_world -
      1.1 * scene.half_height_m * scene.axes.up_in_world;
  const auto rim = [&](double angle_rad) {
    return projection.At(
        centre +
        scene.radius_m * (std::cos(angle_rad) * scene.axes.forward_in_world +
                          std::sin(angle_rad) * scene.axes.right_in_world));
  };
  std::string path;
  for (int k = 0; k <= kDiscSteps; ++k) {
    absl::StrAppend(&path, k == 0 ? "M" : "L", rim(kTurn * k / kDiscSteps));
  }
  for (int k = 0; k < 2; ++k) {
    absl::StrAppend(&path, "M", rim(kTurn * k / 4), "L",
                    rim(kTurn * k / 4 + kTurn / 2));
  }
  const std::string tip = rim(0);
  const size_t space = tip.find(' ');
  return absl::StrCat("<path d=\"", path, "\" class=\"disc\"/><text x=\"",
                      tip.substr(0, space), "\" y=\"", tip.substr(space + 1),
                      "\" dy=\"-4\" text-anchor=\"middle\" "
                      "class=\"tick\">forward</text>");
}

std::string TruePath(const Scene& scene, const Projection& projection) {
  const double long_step_m = LongStep_m(scene.truths);
  std::string path;
  geometry::Vec3 previous;
  for (const accuracy::FrameResult* result : scene.truths) {
    const geometry::Vec3 at = result->true_world_from_camera->translation;
    const bool move =
        path.empty() || geometry::Norm(at - previous) > long_step_m;
    absl::StrAppend(&path, move ? "M" : "L", projection.At(at));
    previous = at;
  }
  return path;
}

// Where every camera was estimated to be, and where those that were not
// localized were.
std::string Places(const Scene& scene, const Projection& projection) {
  std::string places;
  std::string far_places;
  std::string lost;
  for (const accuracy::FrameResult* result : scene.truths) {
    if (!result->error) {
      absl::StrAppend(
          &lost, "M",
          projection.At(result->true_world_from_camera->translation),
          "m-3 -3l6 6m0 -6l-6 6");
    } else if (result->error->translation_m <= scene.radius_m) {
      absl::StrAppend(
          accuracy::IsWithin(*result, 0.05, 5) ? &places : &far_places, "M",
          projection.At(result->estimate.world_from_camera.translation), "h0");
    }
  }
  return absl::StrFormat(
      "<path d=\"%s\" class=\"place\"/><path d=\"%s\" class=\"place far\"/>"
      "<path d=\"%s\" class=\"lost\"/>",
      places, far_places, lost);
}

std::string View(const Scene& scene, double angle_rad) {
  const double frustum_m = 0.14 * scene.radius_m;
  // The disc's ellipse and the cameras above it fit in.
  const double half_tall_m =
      std::sin(kElevation_rad) * scene.radius_m +
      1.1 * std::cos(kElevation_rad) * scene.half_height_m + 0.5 * frustum_m;
  const double scale =
      std::min((kHeight / 2 - kMargin) / half_tall_m,
               (kWidth / 2 - kMargin) / (scene.radius_m + frustum_m));
  const Projection projection(scene.axes, scene.middle_in_world, scale,
                              angle_rad);
  std::string training;
  const size_t training_stride =
      std::max<size_t>(1, scene.training.size() / kTrainingDots);
  for (size_t i = 0; i < scene.training.size(); i += training_stride) {
    absl::StrAppend(&training, "M",
                    projection.At(scene.training[i].translation), "h0");
  }
  std::string truth;
  std::string near;
  std::string far;
  const size_t stride = std::max<size_t>(1, scene.truths.size() / kFrusta);
  for (size_t i = 0; i < scene.truths.size(); i += stride) {
    const accuracy::FrameResult& result = *scene.truths[i];
    absl::StrAppend(
        &truth, Frustum(projection, *result.true_world_from_camera, frustum_m));
    // Wild ones would cover the picture.
    if (!result.error || result.error->translation_m > scene.radius_m) continue;
    std::string& estimated = accuracy::IsWithin(result, 0.05, 5) ? near : far;
    absl::StrAppend(
        &estimated,
        Frustum(projection, result.estimate.world_from_camera, frustum_m));
  }
  return absl::StrFormat(
      "%s<path d=\"%s\" class=\"training\"/><path d=\"%s\" "
      "class=\"truefrustum\"/><path d=\"%s\" class=\"frustum\"/>"
      "<path d=\"%s\" class=\"frustum far\"/><path d=\"%s\" "
      "class=\"truth\"/>%s",
      Disc(scene, projection), training, truth, near, far,
      TruePath(scene, projection), Places(scene, projection));
}

}  // namespace

std::string TurntableChart(const std::vector<accuracy::FrameResult>& results,
                           const std::vector<geometry::Rigid3>& training_poses,
                           absl::string_view id) {
  const Scene scene = MakeScene(results, training_poses);
  if (scene.truths.empty()) return "";
  std::string inputs;
  std::string views;
  for (int k = 0; k < kViews; ++k) {
    absl::StrAppendFormat(
        &inputs,
        "<input type=\"radio\" name=\"turn-%s\" aria-label=\"turned by %d "
        "degrees\"%s>",
        id, k * 360 / kViews, k == 0 ? " checked" : "");
    absl::StrAppendFormat(
        &views,
        "<svg class=\"chart wide view\" viewBox=\"0 0 %g %g\" role=\"img\" "
        "aria-label=\"Cameras in space\">%s</svg>\n",
        kWidth, kHeight, View(scene, kTurn * k / kViews));
  }
  return absl::StrCat(
      "<div class=\"turntable\"><span class=\"turnlabel\">turn</span>", inputs,
      views, "</div>\n");
}

}  // namespace treeline::report
