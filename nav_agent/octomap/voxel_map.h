// What is known of space, voxel by voxel: the plain form of an OctoMap.
#ifndef NAV_AGENT_OCTOMAP_VOXEL_MAP_H_
#define NAV_AGENT_OCTOMAP_VOXEL_MAP_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/vector3.h"

namespace treeline::octree {

enum class Voxel : uint8_t { kUnknown, kFree, kOccupied };

struct VoxelIndex {
  int x = 0;
  int y = 0;
  int z = 0;

  constexpr bool operator==(const VoxelIndex&) const = default;
};

// A box of voxels. Voxel (x, y, z), each from 0, is the cube of resolution_m
// from (lowest() + (x, y, z)) * resolution_m on, in the map's frame; so the
// planes between voxels pass through the map's origin, as OctoMap has it.
//
// Columns are stored as bits: bit z % 64 of word z / 64 is voxel z. Two bits a
// voxel: a room of 13 x 10 x 3 m at 0.05 m is 0.8 MB.
class VoxelMap {
 public:
  static constexpr int64_t kDefaultMaxBytes = int64_t{1} << 29;

  // All unknown. INVALID_ARGUMENT for a resolution outside of [0.001, 10] m or
  // a negative size, RESOURCE_EXHAUSTED if it took more than max_bytes.
  static absl::StatusOr<VoxelMap> Make(double resolution_m, VoxelIndex lowest,
                                       VoxelIndex size,
                                       int64_t max_bytes = kDefaultMaxBytes);
  VoxelMap() = default;

  bool operator==(const VoxelMap&) const = default;

  double resolution_m() const { return resolution_m_; }
  VoxelIndex lowest() const { return lowest_; }
  VoxelIndex size() const { return size_; }
  int words() const { return words_; }

  bool Contains(VoxelIndex v) const {
    return v.x >= 0 && v.x < size_.x && v.y >= 0 && v.y < size_.y && v.z >= 0 &&
           v.z < size_.z;
  }
  // What lies outside is unknown.
  Voxel At(VoxelIndex v) const;
  void Set(VoxelIndex v, Voxel value) { SetRun(v.x, v.y, v.z, v.z + 1, value); }
  // Voxels [begin_z, end_z) of a column; all must be inside.
  void SetRun(int x, int y, int begin_z, int end_z, Voxel value);

  // The bits of a column: words() words each. Occupied voxels are known.
  std::span<const uint64_t> Occupied(int x, int y) const {
    return {occupied_.data() + Offset(x, y), static_cast<size_t>(words_)};
  }
  std::span<const uint64_t> Known(int x, int y) const {
    return {known_.data() + Offset(x, y), static_cast<size_t>(words_)};
  }

  int64_t CountOccupied() const;
  int64_t CountFree() const;

  // The voxel a point lies in; it may be outside.
  VoxelIndex IndexOf(geometry::Vec3 point_in_map) const;
  geometry::Vec3 CenterOf(VoxelIndex v) const;

 private:
  size_t Offset(int x, int y) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(size_.x) +
            static_cast<size_t>(x)) *
           static_cast<size_t>(words_);
  }

  double resolution_m_ = 0.05;
  VoxelIndex lowest_;
  VoxelIndex size_;
  int words_ = 0;
  std::vector<uint64_t> occupied_;
  std::vector<uint64_t> known_;
};

}  // namespace treeline::octree

#endif  // NAV_AGENT_OCTOMAP_VOXEL_MAP_H_
