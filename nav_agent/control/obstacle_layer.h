// The sensors' part of a local costmap: which cells something was seen in.
#ifndef NAV_AGENT_CONTROL_OBSTACLE_LAYER_H_
#define NAV_AGENT_CONTROL_OBSTACLE_LAYER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/rigid3.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/ground_layer.h"

namespace treeline::control {

// What sensors have said of each cell of a window, and since when. Lasers and
// the depth camera mark and clear counts of their own, so that a laser does not
// clear what is lower than its plane. A cell counts when either has hit it
// kHitsToMark times. Times are in ms, of the caller's epoch.
//
// A look is a scan or a frame: BeginLook; Hit for each cell that it ends in;
// ClearAlong or ClearByDepth for what it passed; then MarkLaserHits or
// MarkDepthHits. In one look a cell is hit or passed once.
//
// Deterministic; not thread-safe.
class ObstacleLayer {
 public:
  // With two lasers, one sees past the edges of what the other has just hit:
  // it clears nothing there.
  ObstacleLayer(size_t cells, bool has_two_lasers);

  // Forgets everything.
  void Clear();
  // What was kept for a window is now of the window `to`.
  void Roll(const CostmapWindow& from, const CostmapWindow& to);
  // Forgets what has not been seen for too long: what stood is remembered for
  // longer than what moved.
  void Forget(int64_t now_ms);

  // ---- a look ----
  void BeginLook();
  void Hit(size_t i);
  // The ray from a laser to its end, on the height of things that stand.
  void ClearAlong(const CostmapWindow& window, const GroundLayer& ground,
                  geometry::Vec3 from, geometry::Vec3 to, int64_t now_ms);
  // The camera shows the ground there.
  void ClearByDepth(size_t i, int64_t now_ms);
  void MarkLaserHits(int64_t now_ms);
  void MarkDepthHits(int64_t now_ms);
  // Cells that this look has hit.
  std::span<const size_t> hits() const { return hits_; }
  // Somebody moves beside what was hit: it is his, a cart's deck beside its
  // legs, until it is hit again.
  void MarkAsOfMover(size_t i) { seen_[i].is_of_mover = true; }

  // ---- what is known ----
  bool Counts(size_t i) const;
  // It is well away from all that the map has: nearer, it may be the map's own,
  // seen from an estimate that is off. Nothing is for a robot without a map.
  bool IsNew(size_t i, const GroundLayer& ground) const;
  // It came a moment ago to where nothing was.
  bool IsMoving(const CostmapWindow& window, const GroundLayer& ground,
                core::CellIndex cell, int64_t now_ms) const;
  // A sensor shows it at this moment.
  bool IsSeenNow(size_t i, int64_t now_ms) const;
  // For how long it has been there.
  int64_t Age_ms(size_t i, int64_t now_ms) const {
    return now_ms - seen_[i].since_ms;
  }
  // Counts, and what of it is new, widened: people and carts are wider than
  // they are at a laser's height. Marked in is_obstacle, one a cell.
  void Widen(const CostmapWindow& window, const GroundLayer& ground,
             std::span<uint8_t> is_obstacle) const;

 private:
  // What is known of a cell.
  struct Seen {
    uint8_t laser_hits = 0;
    uint8_t depth_hits = 0;
    // Nothing was there just before.
    bool was_free = false;
    bool is_of_mover = false;
    int64_t since_ms = 0;
    int64_t last_ms = 0;
    int64_t last_free_ms = 0;
  };

  void Begin(Seen& seen, int64_t now_ms) const;

  std::vector<Seen> seen_;
  // The number of the look that last hit, and that last passed a cell.
  std::vector<uint32_t> hit_in_;
  std::vector<uint32_t> passed_in_;
  uint32_t look_ = 1;
  // What was hit in so many looks before is not passed.
  uint32_t held_looks_;
  std::vector<size_t> hits_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_OBSTACLE_LAYER_H_
