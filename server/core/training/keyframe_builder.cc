#include "server/core/training/keyframe_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/planar_image.h"
#include "server/core/keyframes/keyframe_features.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::training {
namespace {

// Points keep this far from the border (px).
constexpr int kBorder_px = 8;
// Edges weaker than this (grey levels a pixel) say nothing.
constexpr int kMinGradient = 6;
// Normals come from points this far apart (px).
constexpr int kNormalRadius_px = 5;
constexpr double kMaxJump = 0.03;

struct SelectedFrame {
  int frame = 0;
  geometry::Rigid3 world_from_color;
};

std::vector<SelectedFrame> SelectFrames(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const KeyframeOptions& options) {
  std::vector<SelectedFrame> selected;
  for (int i = 0; i < dataset.size(); ++i) {
    const dataset::DatasetFrame& frame = dataset.frame(i);
    if (!frame.world_from_camera || frame.depth_path.empty()) continue;
    const geometry::Rigid3 pose = camera::PoseOfSensor(
        *frame.world_from_camera, dataset.calibration().pose_sensor,
        camera::RgbdSensor::kColor, calibration);
    const bool is_far =
        std::ranges::all_of(selected, [&](const SelectedFrame& other) {
          return AreApart(other.world_from_color, pose, options.spacing_m);
        });
    if (is_far) selected.push_back({i, pose});
  }
  const size_t most = static_cast<size_t>(options.max_keyframes);
  if (selected.size() <= most) return selected;
  std::vector<SelectedFrame> thinned;
  for (size_t k = 0; k < most; ++k) {
    thinned.push_back(selected[k * selected.size() / most]);
  }
  return thinned;
}

std::array<float, 3> Moved(const geometry::Rigid3& b_from_a,
                           const std::array<float, 3>& in_a) {
  const geometry::Vec3 in_b =
      b_from_a * geometry::Vec3{in_a[0], in_a[1], in_a[2]};
  return {static_cast<float>(in_b.x), static_cast<float>(in_b.y),
          static_cast<float>(in_b.z)};
}

std::array<int8_t, 3> Turned(const geometry::Rotation3& b_from_a,
                             const std::array<int8_t, 3>& in_a) {
  const geometry::Vec3 in_b =
      b_from_a * geometry::Vec3{static_cast<double>(in_a[0]),
                                static_cast<double>(in_a[1]),
                                static_cast<double>(in_a[2])};
  return {static_cast<int8_t>(std::lround(in_b.x)),
          static_cast<int8_t>(std::lround(in_b.y)),
          static_cast<int8_t>(std::lround(in_b.z))};
}

// The normal of the surface at (x, y), towards the camera; nullopt where depth
// is missing or jumps.
std::optional<geometry::Vec3> NormalAt(
    const image::DepthRegistrar& registration,
    const std::vector<geometry::Vec3>& points, int x, int y) {
  const auto at = [&](int dx, int dy) {
    return registration.PointAt(
        points, {static_cast<double>(x + dx), static_cast<double>(y + dy)});
  };
  const auto left = at(-kNormalRadius_px, 0);
  const auto right = at(kNormalRadius_px, 0);
  const auto up = at(0, -kNormalRadius_px);
  const auto down = at(0, kNormalRadius_px);
  if (!left || !right || !up || !down) return std::nullopt;
  const double depth = left->z;
  for (const auto& p : {right, up, down}) {
    if (std::abs(p->z - depth) > kMaxJump * depth) return std::nullopt;
  }
  const geometry::Vec3 normal = geometry::Cross(*down - *up, *right - *left);
  const double norm = geometry::Norm(normal);
  if (!(norm > 0)) return std::nullopt;
  const geometry::Vec3 unit = normal / norm;
  return geometry::Dot(unit, *left) < 0 ? unit : -unit;
}

std::vector<keyframes::KeyframePoint> SelectPoints(
    const image::Frame& frame, const geometry::Rigid3& world_from_color,
    const image::DepthRegistrar& registration,
    const std::vector<geometry::Vec3>& in_color, int count) {
  features::GrayPyramid pyramid;
  pyramid.Assign(features::PlanarImage(frame.color));
  const features::GrayPyramid::Level& gray = pyramid.level(1);
  const int cell = std::max(
      2, static_cast<int>(std::sqrt(1.0 * gray.width * gray.height / count)));
  std::vector<keyframes::KeyframePoint> points;
  for (int top = kBorder_px / 2; top + cell <= gray.height - kBorder_px / 2;
       top += cell) {
    for (int left = kBorder_px / 2; left + cell <= gray.width - kBorder_px / 2;
         left += cell) {
      int best = kMinGradient;
      int best_x = -1;
      int best_y = -1;
      for (int y = top; y < top + cell; ++y) {
        for (int x = left; x < left + cell; ++x) {
          const uint8_t* p = gray.gray.data() + y * gray.width + x;
          const int strength =
              std::abs(p[1] - p[-1]) + std::abs(p[gray.width] - p[-gray.width]);
          if (strength <= best) continue;
          best = strength;
          best_x = x;
          best_y = y;
        }
      }
      if (best_x < 0) continue;
      const double x = 2 * best_x + 0.5;
      const double y = 2 * best_y + 0.5;
      const std::optional<geometry::Vec3> point =
          registration.PointAt(in_color, {x, y});
      if (!point) continue;
      keyframes::KeyframePoint kept;
      const geometry::Vec3 world = world_from_color * *point;
      kept.position_in_world = {static_cast<float>(world.x),
                                static_cast<float>(world.y),
                                static_cast<float>(world.z)};
      if (const auto normal =
              NormalAt(registration, in_color, 2 * best_x, 2 * best_y)) {
        const geometry::Vec3 n = 127 * (world_from_color.rotation * *normal);
        kept.normal_in_world = {static_cast<int8_t>(std::lround(n.x)),
                                static_cast<int8_t>(std::lround(n.y)),
                                static_cast<int8_t>(std::lround(n.z))};
      }
      bool inside = true;
      for (int l = 0; l < features::GrayPyramid::kLevels; ++l) {
        const features::GrayPyramid::Level& level = pyramid.level(l);
        const float u = features::AtLevel(static_cast<float>(x), l);
        const float v = features::AtLevel(static_cast<float>(y), l);
        inside = inside && u >= 0 && v >= 0 &&
                 u < static_cast<float>(level.width - 1) &&
                 v < static_cast<float>(level.height - 1);
        if (inside) {
          kept.gray[static_cast<size_t>(l)] =
              static_cast<uint8_t>(std::lround(level.At(u, v)));
        }
      }
      if (inside) points.push_back(kept);
    }
  }
  return points;
}

// The SIFT features that stand where depth was measured.
std::vector<keyframes::KeyframeFeature> SelectFeatures(
    const image::Frame& frame, const geometry::Rigid3& world_from_color,
    const image::DepthRegistrar& registration,
    const std::vector<geometry::Vec3>& in_color, features::SiftKind kind,
    int count) {
  std::vector<keyframes::KeyframeFeature> features;
  if (count == 0) return features;
  features::FastSift fast_sift;
  // Some stand where no depth is.
  const features::SiftFeatures found = keyframes::ExtractKeyframeSift(
      frame.color, kind, {.max_features = 2 * count}, fast_sift);
  for (size_t i = 0; i < found.size(); ++i) {
    if (features.size() == static_cast<size_t>(count)) break;
    const std::optional<geometry::Vec3> point =
        registration.PointAt(in_color, found.keypoints[i].pixel);
    if (!point) continue;
    const geometry::Vec3 world = world_from_color * *point;
    keyframes::KeyframeFeature feature;
    feature.position_in_world = {static_cast<float>(world.x),
                                 static_cast<float>(world.y),
                                 static_cast<float>(world.z)};
    feature.descriptor = found.descriptors[i].values;
    features.push_back(feature);
  }
  return features;
}

}  // namespace

bool AreApart(const geometry::Rigid3& world_from_a,
              const geometry::Rigid3& world_from_b, double spacing_m) {
  const double turn =
      keyframes::kViewDistance_m *
      geometry::AngleBetween_rad(world_from_a.rotation, world_from_b.rotation);
  return geometry::SquaredNorm(world_from_a.translation -
                               world_from_b.translation) +
             turn * turn >
         spacing_m * spacing_m;
}

KeyframeParts MakeKeyframe(const image::Frame& frame,
                           const geometry::Rigid3& world_from_color,
                           const image::DepthRegistrar& registration,
                           const KeyframeOptions& options) {
  const std::vector<geometry::Vec3> in_color =
      registration.PointsInColor(*frame.depth);
  KeyframeParts parts;
  parts.world_from_color = world_from_color;
  parts.points = SelectPoints(frame, world_from_color, registration, in_color,
                              options.points);
  parts.features = SelectFeatures(frame, world_from_color, registration,
                                  in_color, options.sift, options.features);
  return parts;
}

keyframes::Keyframes JoinKeyframes(std::span<const PlacedKeyframe> placed) {
  keyframes::Keyframes keyframes;
  for (const PlacedKeyframe& one : placed) {
    keyframes::KeyframeRecord record;
    const geometry::Rigid3& move = one.world_from_parts;
    const geometry::Rigid3 pose = one.world_from_color();
    record.rotation = {pose.rotation.w, pose.rotation.x, pose.rotation.y,
                       pose.rotation.z};
    record.position_in_world = {pose.translation.x, pose.translation.y,
                                pose.translation.z};
    record.first_point = static_cast<uint32_t>(keyframes.points.size());
    record.points = static_cast<uint32_t>(one.parts->points.size());
    for (keyframes::KeyframeFeature feature : one.parts->features) {
      feature.keyframe = static_cast<uint32_t>(keyframes.records.size());
      feature.position_in_world = Moved(move, feature.position_in_world);
      keyframes.features.push_back(feature);
    }
    keyframes.records.push_back(record);
    for (keyframes::KeyframePoint point : one.parts->points) {
      point.position_in_world = Moved(move, point.position_in_world);
      point.normal_in_world = Turned(move.rotation, point.normal_in_world);
      keyframes.points.push_back(point);
    }
  }
  return keyframes;
}

absl::StatusOr<keyframes::Keyframes> BuildKeyframes(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const KeyframeOptions& options, bool quiet, const std::stop_token& stop) {
  const std::vector<SelectedFrame> selected =
      SelectFrames(dataset, calibration, options);
  const image::DepthRegistrar registration(calibration);
  std::vector<absl::Status> statuses(selected.size());
  std::vector<PlacedKeyframe> placed(selected.size());
  const auto make = [&](size_t i) -> absl::Status {
    TL_ASSIGN_OR_RETURN(const image::Frame frame,
                        dataset.Load(selected[i].frame));
    placed[i].parts = std::make_shared<const KeyframeParts>(MakeKeyframe(
        frame, selected[i].world_from_color, registration, options));
    return absl::OkStatus();
  };
  {
    base::Progress progress("keyframes", static_cast<int64_t>(selected.size()),
                            quiet);
    base::ParallelFor(static_cast<int64_t>(selected.size()), options.threads,
                      [&](int64_t i) {
                        if (stop.stop_requested()) return;
                        const size_t slot = static_cast<size_t>(i);
                        statuses[slot] = make(slot);
                        progress.Add(1);
                      });
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("training was interrupted");
  }
  for (const absl::Status& status : statuses) TL_RETURN_IF_ERROR(status);
  return JoinKeyframes(placed);
}

}  // namespace treeline::training
