#include "nav_agent/traversability/traversability.h"

#include "common/base/status_macros.h"
#include "nav_agent/traversability/levels.h"

namespace treeline::traversability {

absl::StatusOr<TraversabilityMapper> TraversabilityMapper::Make(
    const TraversabilityOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  return TraversabilityMapper(options);
}

absl::Status TraversabilityMapper::Rebuild(const octree::VoxelMap& voxels) {
  if (voxels.CountOccupied() == 0) {
    return absl::InvalidArgumentError(
        "the OctoMap has no occupied voxel: there is no ground in it");
  }
  resolution_m_ = voxels.resolution_m();
  lowest_ = voxels.lowest();
  size_ = voxels.size();
  needs_sight_ = voxels.CountFree() > 0;
  ground_ =
      FindGround(voxels, VoxelLimits(options_, resolution_m_), needs_sight_);
  map_ = MakeLevels(voxels, ground_, options_);
  return absl::OkStatus();
}

absl::Status TraversabilityMapper::Update(const octree::VoxelMap& voxels,
                                          const ColumnRect& changed) {
  if (voxels.resolution_m() != resolution_m_ || voxels.lowest() != lowest_ ||
      voxels.size() != size_ || needs_sight_ != (voxels.CountFree() > 0)) {
    return Rebuild(voxels);
  }
  const ColumnRect inside = changed.Grown(0, {0, 0, size_.x, size_.y});
  if (inside.width() <= 0 || inside.height() <= 0) return absl::OkStatus();
  UpdateGround(voxels, VoxelLimits(options_, resolution_m_), needs_sight_,
               inside, ground_);
  map_ = MakeLevels(voxels, ground_, options_);
  return absl::OkStatus();
}

absl::StatusOr<TraversableMap> ExtractTraversableMap(
    const octree::VoxelMap& voxels, const TraversabilityOptions& options) {
  TL_ASSIGN_OR_RETURN(TraversabilityMapper mapper,
                      TraversabilityMapper::Make(options));
  TL_RETURN_IF_ERROR(mapper.Rebuild(voxels));
  return mapper.map();
}

}  // namespace treeline::traversability
