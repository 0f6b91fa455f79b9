// Where a forest on SIFT descriptors has its modes: what a pose that is known
// already says about a frame's other features.
#ifndef SERVER_CORE_FOREST_SIFT_PLACES_H_
#define SERVER_CORE_FOREST_SIFT_PLACES_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/core/features/sift_descriptor.h"
#include "server/core/forest/forest.h"
#include "server/core/forest/sift_backtracking.h"

namespace treeline::forest {

struct SiftWindow {
  // Places are considered that are seen this near to a feature (units of the
  // ray).
  double radius = 4.0 / 1000;
  // ... and modes whose squared descriptor distance is at most this.
  int32_t max_squared_distance = 0;
};

// The modes of all trees by place: a point of the scene has some in each tree.
// Immutable; the forest must outlive it.
class SiftPlaces {
 public:
  explicit SiftPlaces(const ForestView& forest);

  // Different places.
  size_t size() const { return position_in_world_.size(); }

  // matches[i], of each i in `which`, for the feature with rays[i] ((x/z, y/z)
  // in the camera) and descriptors[i]: of the modes of the places that are seen
  // within the window around the ray, the one of the nearest mean descriptor
  // (ties go to the smaller index); kNoLeaf: none within the window.
  // distance_elsewhere is not looked for: kNothingElsewhere. Of places out of
  // view, one in 64 is looked at.
  void Match(const geometry::Rigid3& camera_from_world,
             std::span<const camera::Pixel> rays,
             std::span<const features::SiftDescriptor> descriptors,
             std::span<const uint32_t> which, const SiftWindow& window,
             std::span<SiftMatch> matches) const;

 private:
  // Places that follow each other lie near each other.
  static constexpr size_t kBlock = 64;
  struct Block {
    geometry::Vec3 center_in_world;
    double radius = 0;
  };
  class Query;

  std::span<const uint32_t> modes(size_t place) const {
    return std::span(modes_).subspan(
        first_mode_[place], first_mode_[place + 1] - first_mode_[place]);
  }

  void Prefetch(size_t place) const;

  const ForestView& forest_;
  std::vector<geometry::Vec3> position_in_world_;
  // Those of place p are modes_[first_mode_[p]] to
  // modes_[first_mode_[p + 1] - 1].
  std::vector<uint32_t> first_mode_;
  std::vector<uint32_t> modes_;
  std::vector<Block> blocks_;
};

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_SIFT_PLACES_H_
