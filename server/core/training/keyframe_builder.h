// Which training frames a model keeps, and what of them.
#ifndef SERVER_CORE_TRAINING_KEYFRAME_BUILDER_H_
#define SERVER_CORE_TRAINING_KEYFRAME_BUILDER_H_

#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "common/image/depth_registration.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::training {

struct KeyframeOptions {
  // A frame is kept if every kept one is further away than this, in the
  // distance of KeyframeMap::Nearest (m).
  double spacing_m = 0.25;
  // At most so many, evenly thinned.
  int max_keyframes = 1600;
  // At most so many points of each.
  int points = 1200;
  // At most so many SIFT features of each, where depth is measured; 0: none,
  // and none are looked for.
  int features = 0;
  features::SiftKind sift = features::SiftKind::kFast;
  // 0: one a processor.
  int threads = 0;
};

// What is kept of one frame.
struct KeyframeParts {
  geometry::Rigid3 world_from_color;
  std::vector<keyframes::KeyframePoint> points;
  // Which keyframe they are of is filled in by JoinKeyframes.
  std::vector<keyframes::KeyframeFeature> features;
};

// Of a frame with depth.
KeyframeParts MakeKeyframe(const image::Frame& frame,
                           const geometry::Rigid3& world_from_color,
                           const image::DepthRegistrar& registration,
                           const KeyframeOptions& options);

// Whether the views are further apart than KeyframeOptions::spacing_m.
bool AreApart(const geometry::Rigid3& world_from_a,
              const geometry::Rigid3& world_from_b, double spacing_m);

// Parts that were made with poses of another world, and where that lies.
struct PlacedKeyframe {
  std::shared_ptr<const KeyframeParts> parts;
  geometry::Rigid3 world_from_parts{};

  geometry::Rigid3 world_from_color() const {
    return world_from_parts * parts->world_from_color;
  }
};

// In the order given.
keyframes::Keyframes JoinKeyframes(std::span<const PlacedKeyframe> placed);

// Keyframes of the frames that have depth and a pose. Points stand on the
// strongest edges of each cell of a grid, where depth is measured and smooth.
// The result does not depend on threads. CANCELLED after `stop`, and whatever
// reading a frame gives.
absl::StatusOr<keyframes::Keyframes> BuildKeyframes(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const KeyframeOptions& options, bool quiet, const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_KEYFRAME_BUILDER_H_
