#include "server/core/keyframes/keyframe_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline {
namespace {

bool IsFinite(const std::array<float, 3>& position) {
  return std::ranges::all_of(position,
                             [](float c) { return std::isfinite(c); });
}

}  // namespace

absl::StatusOr<KeyframeMap> KeyframeMap::Read(const ModelFile& model) {
  KeyframeMap map;
  TL_ASSIGN_OR_RETURN(map.records_,
                      model.Extra<KeyframeRecord>(ModelExtra::kKeyframes));
  TL_ASSIGN_OR_RETURN(map.points_,
                      model.Extra<KeyframePoint>(ModelExtra::kKeyframePoints));
  for (const KeyframeRecord& record : map.records_) {
    const auto& [w, x, y, z] = record.rotation;
    const auto& [tx, ty, tz] = record.position_in_world;
    absl::StatusOr<Rigid3> pose = RigidFromQuaternion(w, x, y, z, {tx, ty, tz});
    if (!pose.ok() || record.first_point > map.points_.size() ||
        record.points > map.points_.size() - record.first_point) {
      return absl::DataLossError(
          absl::StrCat("corrupt model: keyframe ", map.poses_.size()));
    }
    map.poses_.push_back(*pose);
  }
  for (const KeyframePoint& point : map.points_) {
    if (!IsFinite(point.position_in_world)) {
      return absl::DataLossError("corrupt model: a keyframe point");
    }
  }
  TL_ASSIGN_OR_RETURN(map.features_, model.Extra<KeyframeFeature>(
                                         ModelExtra::kKeyframeFeatures));
  uint32_t last = 0;
  for (size_t i = 0; i < map.features_.size(); ++i) {
    const KeyframeFeature& feature = map.features_[i];
    if (!IsFinite(feature.position_in_world) || feature.keyframe < last ||
        feature.keyframe >= map.poses_.size()) {
      return absl::DataLossError("corrupt model: a keyframe feature");
    }
    last = feature.keyframe;
    map.first_feature_.resize(last + size_t{1}, i);
  }
  map.first_feature_.resize(map.poses_.size() + 1, map.features_.size());
  return map;
}

double MaxKeyframeAngle_rad(const Camera& camera) {
  return std::max(0.35, 0.5 * std::atan(0.5 * camera.width() / camera.fx()));
}

std::vector<size_t> KeyframeMap::Nearest(const Rigid3& world_from_camera,
                                         double max_angle_rad,
                                         size_t count) const {
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i < poses_.size(); ++i) {
    const double angle =
        AngleBetween_rad(poses_[i].rotation, world_from_camera.rotation);
    if (angle > max_angle_rad) continue;
    const double turn = kViewDistance_m * angle;
    near.emplace_back(
        SquaredNorm(poses_[i].translation - world_from_camera.translation) +
            turn * turn,
        i);
  }
  const size_t kept = std::min(count, near.size());
  std::partial_sort(near.begin(),
                    near.begin() + static_cast<std::ptrdiff_t>(kept),
                    near.end());
  std::vector<size_t> result;
  for (size_t k = 0; k < kept; ++k) result.push_back(near[k].second);
  return result;
}

}  // namespace treeline
