// Where somebody may be who is out of sight.
#ifndef NAV_AGENT_CONTROL_HIDDEN_PLACES_H_
#define NAV_AGENT_CONTROL_HIDDEN_PLACES_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/tracked_scan.h"

namespace treeline::control {

struct HiddenPlacesOptions {
  // A square about the robot, and its cells (m).
  double size_m = kHiddenSize_m;
  double resolution_m = kHiddenCell_m;
  // Nobody who is out of sight walks faster (m/s).
  double spread_mps = kApproachSpeed_mps;
};

// For each of up to 32 people the set of places that he can have reached since
// he was seen, without having been seen on the way:
//
//   R(t + dt) = (R(t) grown by spread_mps * dt) \ solid \ looked through
//
// That needs no guess where he goes: who turns round behind the robot is in the
// set as well as who walks on. A set that is empty says that he has gone.
// (Reachable sets of what is hidden: Orzechowski, Meyer and Lauer, "Tackling
// Occlusions & Limited Sensor Range with Set-based Safety Verification", 2018.)
//
// Deterministic; not thread-safe.
class HiddenPlaces {
 public:
  // Whether nobody can be at a place: walls, the robot.
  using IsSolid = std::function<bool(geometry::Vec2 in_map)>;

  explicit HiddenPlaces(const HiddenPlacesOptions& options);

  // Nobody is anywhere.
  void Clear();
  // One who is in no set yet; nullopt: there are too many.
  std::optional<int> Take();
  // He is seen, or forgotten: his set is empty, and his number free.
  void Give(int who);
  // He may be within radius_m of a place, and nowhere else.
  void Put(int who, geometry::Vec2 in_map, double radius_m);
  // interval_s later, the square about `at`.
  void Spread(geometry::Vec2 at, double interval_s, const IsSolid& is_solid);
  // Nobody is where a laser looks through.
  void LookThrough(std::span<const TrackedScan> looks);

  // Of the places that he may be in; 0: he has gone (m2).
  double Area_m2(int who) const;
  // He may be within radius_m of a place.
  bool MayBeNear(int who, geometry::Vec2 in_map, double radius_m) const;
  // Centres of the cells that any of some may be in; bit i of `who`: number i.
  std::vector<geometry::Vec2> PlacesOf(uint32_t who) const;
  double resolution_m() const { return window_.resolution_m(); }

 private:
  void MoveTo(geometry::Vec2 at);
  void Grow(bool is_diagonal, const IsSolid& is_solid);

  HiddenPlacesOptions options_;
  CostmapWindow window_;
  // One a cell: bit i, whether number i may be there.
  std::vector<uint32_t> may_be_;
  uint32_t taken_ = 0;
  // Walked since the sets grew last (m).
  double to_grow_m_ = 0;
  bool grows_diagonally_ = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_HIDDEN_PLACES_H_
