#include "server/core/keyframes/keyframe_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/keyframes/least_first.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

static_assert(kCoarsePoints % kAlignmentBlock == 0);

bool IsFinite(const std::array<float, 3>& position) {
  return std::ranges::all_of(position,
                             [](float c) { return std::isfinite(c); });
}

features::SiftDescriptorView DescriptorsOf(
    std::span<const KeyframeFeature> features) {
  if (features.empty()) return {};
  return {.data = features[0].descriptor.data(),
          .stride_bytes = sizeof(KeyframeFeature),
          .size = features.size()};
}

// Where each keyframe's features begin, and the end.
std::vector<size_t> FirstFeatures(std::span<const KeyframeFeature> features,
                                  size_t keyframes) {
  std::vector<size_t> first{0};
  first.reserve(keyframes + 1);
  for (size_t i = 0; i < features.size(); ++i) {
    first.resize(features[i].keyframe + size_t{1}, i);
  }
  first.resize(keyframes + 1, features.size());
  return first;
}

// That of the file; models of older versions have none, and it is made anew.
absl::StatusOr<KeyframeIndex> ReadIndex(
    const forest::ModelFile& model, std::span<const KeyframeFeature> features,
    std::span<const size_t> first) {
  const features::SiftDescriptorView descriptors = DescriptorsOf(features);
  TL_ASSIGN_OR_RETURN(const std::span<const features::SiftDescriptor> means,
                      model.Extra<features::SiftDescriptor>(
                          forest::ModelExtra::kKeyframeWords));
  TL_ASSIGN_OR_RETURN(
      const std::span<const uint16_t> word_of,
      model.Extra<uint16_t>(forest::ModelExtra::kKeyframeFeatureWords));
  if (means.empty() && word_of.empty()) {
    return KeyframeIndex::Create(LearnWords(descriptors, first), descriptors,
                                 first);
  }
  return KeyframeIndex::Create({.means = {means.begin(), means.end()},
                                .word_of = {word_of.begin(), word_of.end()}},
                               descriptors, first);
}

}  // namespace

KeyframeWords LearnWords(std::span<const KeyframeFeature> features,
                         size_t keyframes) {
  return LearnWords(DescriptorsOf(features),
                    FirstFeatures(features, keyframes));
}

absl::StatusOr<KeyframeMap> KeyframeMap::Read(const forest::ModelFile& model) {
  KeyframeMap map;
  map.sift_kind_ = model.info().keyframe_sift;
  TL_ASSIGN_OR_RETURN(map.records_, model.Extra<KeyframeRecord>(
                                        forest::ModelExtra::kKeyframes));
  TL_ASSIGN_OR_RETURN(map.points_, model.Extra<KeyframePoint>(
                                       forest::ModelExtra::kKeyframePoints));
  for (const KeyframeRecord& record : map.records_) {
    const auto& [w, x, y, z] = record.rotation;
    const auto& [tx, ty, tz] = record.position_in_world;
    absl::StatusOr<geometry::Rigid3> pose =
        geometry::RigidFromQuaternion(w, x, y, z, {tx, ty, tz});
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
  for (size_t k = 0; k < map.size(); ++k) {
    const std::span<const KeyframePoint> points = map.points(k);
    for (size_t i = 0; i < kCoarsePoints; ++i) {
      if (points.empty()) {
        map.coarse_points_.AppendNothing();
        continue;
      }
      const KeyframePoint& point = points[i * points.size() / kCoarsePoints];
      map.coarse_points_.Append(point.position_in_world, point.normal_in_world,
                                {});
    }
  }
  TL_ASSIGN_OR_RETURN(
      map.features_,
      model.Extra<KeyframeFeature>(forest::ModelExtra::kKeyframeFeatures));
  uint32_t last = 0;
  for (const KeyframeFeature& feature : map.features_) {
    if (!IsFinite(feature.position_in_world) || feature.keyframe < last ||
        feature.keyframe >= map.poses_.size()) {
      return absl::DataLossError("corrupt model: a keyframe feature");
    }
    last = feature.keyframe;
  }
  map.first_feature_ = FirstFeatures(map.features_, map.poses_.size());
  if (map.sift_kind_ == features::SiftKind::kFast) {
    TL_ASSIGN_OR_RETURN(map.index_,
                        ReadIndex(model, map.features_, map.first_feature_));
  }
  return map;
}

std::vector<size_t> KeyframeMap::MostVisible(
    const geometry::Rigid3& world_from_camera, const camera::Camera& camera,
    size_t count) const {
  std::vector<float> seen(size());
  CountVisible(coarse_points_, kCoarsePoints,
               ViewOf(world_from_camera.Inverse(), camera, {}), camera.width(),
               camera.height(), seen);
  const geometry::Vec3 axis =
      world_from_camera.rotation * geometry::Vec3{0, 0, 1};
  std::vector<std::pair<double, size_t>> order;  // the best score is least
  for (size_t k = 0; k < seen.size(); ++k) {
    if (!(seen[k] > 0)) continue;
    const double turn =
        kViewDistance_m *
        geometry::Norm(poses_[k].rotation * geometry::Vec3{0, 0, 1} - axis);
    const double distance2 =
        geometry::SquaredNorm(poses_[k].translation -
                              world_from_camera.translation) +
        turn * turn;
    order.emplace_back(-static_cast<double>(seen[k]) /
                           (1 + distance2 / (kSameView_m * kSameView_m)),
                       k);
  }
  return LeastFirst(std::move(order), count);
}

double MaxKeyframeAngle_rad(const camera::Camera& camera) {
  return std::max(0.35, 0.5 * std::atan(0.5 * camera.width() / camera.fx()));
}

std::vector<size_t> KeyframeMap::Nearest(
    const geometry::Rigid3& world_from_camera, double max_angle_rad,
    size_t count) const {
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i < poses_.size(); ++i) {
    const double angle = geometry::AngleBetween_rad(poses_[i].rotation,
                                                    world_from_camera.rotation);
    if (angle > max_angle_rad) continue;
    const double turn = kViewDistance_m * angle;
    near.emplace_back(geometry::SquaredNorm(poses_[i].translation -
                                            world_from_camera.translation) +
                          turn * turn,
                      i);
  }
  return LeastFirst(std::move(near), count);
}

}  // namespace treeline::keyframes
