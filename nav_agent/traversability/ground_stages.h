// The steps by which FindGround finds the ground's voxels. Each fills what the
// next one needs; ground_links.h goes on from there.
#ifndef NAV_AGENT_TRAVERSABILITY_GROUND_STAGES_H_
#define NAV_AGENT_TRAVERSABILITY_GROUND_STAGES_H_

#include <cstdint>
#include <vector>

#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/ground.h"

namespace treeline::traversability {

// The voxels of a rectangle without occupied ones that have no occupied
// neighbour among the 26: measuring errors, in nearly all maps.
class CleanColumns {
 public:
  CleanColumns(const octree::VoxelMap& voxels, const ColumnRect& rect);

  const ColumnRect& rect() const { return rect_; }
  bool IsOccupied(int x, int y, int z) const;
  bool IsFree(int x, int y, int z) const;
  // Whether one of voxels [begin_z, end_z) is occupied, or free.
  bool AnyOccupied(int x, int y, int begin_z, int end_z) const {
    return NextOccupied(x, y, begin_z) < end_z;
  }
  bool AnyFree(int x, int y, int begin_z, int end_z) const;
  // The lowest occupied voxel from begin_z on; kOpenAbove if there is none.
  int NextOccupied(int x, int y, int begin_z) const;
  // The lowest voxel from begin_z on that is not occupied.
  int NextNotOccupied(int x, int y, int begin_z) const;

 private:
  const uint64_t* Column(int x, int y) const {
    return occupied_.data() + static_cast<size_t>(words_) *
                                  (static_cast<size_t>(y - rect_.begin_y) *
                                       static_cast<size_t>(rect_.width()) +
                                   static_cast<size_t>(x - rect_.begin_x));
  }

  const octree::VoxelMap& voxels_;
  ColumnRect rect_;
  int words_ = 0;
  std::vector<uint64_t> occupied_;
};

// Tops of occupied runs with room above.
GroundColumns FindTops(const CleanColumns& columns, bool needs_sight);
// Closes holes of one or two columns that are surrounded by ground: voxels
// that were missed.
GroundColumns FillHoles(const CleanColumns& columns, GroundColumns ground);
// Takes back single voxels that stick out of, or lack in, the ground around.
void LevelSpikes(GroundColumns& ground);
}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_GROUND_STAGES_H_
