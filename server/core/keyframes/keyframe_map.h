// Some training frames, kept in the model: where they were taken, and the
// points that they saw. What poses are verified with and refined against.
#ifndef SERVER_CORE_KEYFRAMES_KEYFRAME_MAP_H_
#define SERVER_CORE_KEYFRAMES_KEYFRAME_MAP_H_

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/core/features/sift_features.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/alignment_kernels.h"
#include "server/core/keyframes/keyframe_index.h"

namespace treeline::keyframes {

// As the file has it.
struct KeyframeRecord {
  std::array<double, 4> rotation{1, 0, 0, 0};  // world from camera: w, x, y, z
  std::array<double, 3> position_in_world{};
  uint32_t first_point = 0;
  uint32_t points = 0;
};
static_assert(sizeof(KeyframeRecord) == 64);

// A point on a strong edge of a keyframe, as the file has it.
struct KeyframePoint {
  std::array<float, 3> position_in_world{};
  // Of the surface, towards the camera, times 127; all zero: not known.
  std::array<int8_t, 3> normal_in_world{};
  // Brightness at the levels of GrayPyramid.
  std::array<uint8_t, 4> gray{};
  uint8_t reserved = 0;
};
static_assert(sizeof(KeyframePoint) == 20);

// A SIFT feature of a keyframe where depth was measured, as the file has it:
// those of a keyframe stand together, keyframes in their order.
struct KeyframeFeature {
  std::array<float, 3> position_in_world{};
  uint32_t keyframe = 0;
  // See SiftDescriptor.
  std::array<uint8_t, features::SiftDescriptor::kDimensions> descriptor{};
};
static_assert(sizeof(KeyframeFeature) == 144);

// The keyframes of a model. Points into its mapping.
class KeyframeMap {
 public:
  KeyframeMap() = default;

  // Empty if the model has none. DATA_LOSS for poses that are not rigid, points
  // that are not there, points and features that are not finite, and features
  // that are out of order or of no keyframe.
  static absl::StatusOr<KeyframeMap> Read(const forest::ModelFile& model);

  size_t size() const { return poses_.size(); }
  bool empty() const { return poses_.empty(); }
  // Of the colour camera.
  const geometry::Rigid3& world_from_camera(size_t i) const {
    return poses_[i];
  }
  std::span<const KeyframePoint> points(size_t i) const {
    return points_.subspan(records_[i].first_point, records_[i].points);
  }

  // How the features were found.
  features::SiftKind sift_kind() const { return sift_kind_; }
  // Empty but for methods universal and hybrid.
  std::span<const KeyframeFeature> features(size_t i) const {
    return features_.subspan(first_feature_[i],
                             first_feature_[i + 1] - first_feature_[i]);
  }

  // Of all keyframes.
  std::span<const KeyframeFeature> features() const { return features_; }

  // Over FastSift's features; empty where they are Lowe's.
  const KeyframeIndex& index() const { return index_; }

  // Up to `count` keyframes near a pose, nearest first: by
  // |position|^2 + (kViewDistance_m * angle)^2, none turned further than
  // max_angle_rad (thesis 3.2.3: a quarter of the field of view).
  std::vector<size_t> Nearest(const geometry::Rigid3& world_from_camera,
                              double max_angle_rad, size_t count) const;

  // Up to `count` keyframes of which much should be seen from about the same
  // place, best first. A few points of each are looked at, as if by a lens
  // without distortion.
  std::vector<size_t> MostVisible(const geometry::Rigid3& world_from_camera,
                                  const camera::Camera& camera,
                                  size_t count) const;

 private:
  std::span<const KeyframeRecord> records_;
  std::span<const KeyframePoint> points_;
  features::SiftKind sift_kind_ = features::SiftKind::kOpenCv;
  std::span<const KeyframeFeature> features_;
  std::vector<size_t> first_feature_{0};  // of each keyframe, and the end
  std::vector<geometry::Rigid3> poses_;
  KeyframeIndex index_;
  // Some points of each keyframe, as many of each.
  AlignmentPoints coarse_points_;
};

// A quarter of the field of view (thesis 3.2.3), and no less than 20 degrees.
double MaxKeyframeAngle_rad(const camera::Camera& camera);

// The words of their features, for the index of `keyframes` keyframes. Features
// stand in the order of their keyframes.
KeyframeWords LearnWords(std::span<const KeyframeFeature> features,
                         size_t keyframes);

// What training gathers.
struct Keyframes {
  std::vector<KeyframeRecord> records;
  std::vector<KeyframePoint> points;
  std::vector<KeyframeFeature> features;
};

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_KEYFRAME_MAP_H_
