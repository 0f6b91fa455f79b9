// Where a robot's footprint may be, and how it may get from there to there.
#ifndef NAV_AGENT_PLANNING_CONFIGURATION_SPACE_H_
#define NAV_AGENT_PLANNING_CONFIGURATION_SPACE_H_

#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/core/robot_model.h"
#include "nav_agent/planning/ground_index.h"
#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {

// The footprint with room on all sides, about the middle of the axle.
struct Footprint {
  double front_m = 0;
  double rear_m = 0;
  double half_width_m = 0;
  double circumradius_m = 0;
  // Of the largest disc about the origin within.
  double inscribed_m = 0;

  static Footprint Of(const core::RobotModel& robot, double margin_m);
};

// What a metre costs beside its length.
struct WayPrices {
  // At contact with things, so much more.
  double near = kNearCost;
  // On ground inclined by a sine of 1, so much more.
  double slope = kSlopeCost;
};

// A disc that nothing may touch, in the grids' frame.
struct Disc {
  geometry::Vec2 center;
  double radius_m = 0;
  int level = 0;
};

// The frame of the grids throughout. Immutable and thread-safe; cheap to make
// and to copy. The robot drives along its own x or turns where it stands, so a
// way is a polyline whose corners it turns at.
class ConfigurationSpace {
 public:
  ConfigurationSpace(std::shared_ptr<const GroundIndex> ground,
                     const Footprint& footprint, std::vector<Disc> discs);
  // The same with other prices.
  ConfigurationSpace WithPrices(const WayPrices& prices) const;

  const GroundIndex& ground() const { return *ground_; }
  const Footprint& footprint() const { return footprint_; }
  const std::vector<Disc>& discs() const { return discs_; }

  // A bound of the distance from `spot` to the nearest thing, from below,
  // within 0.071 cells of map resolution per unit (m); at least 0.
  double RoomAtLeast_m(const Spot& spot) const;
  // Whether there is free ground below, and the footprint is clear.
  bool Fits(const Spot& spot, double yaw_rad) const;
  // Whether it fits with any heading: whether the disc does that the corners
  // sweep in a turn right round.
  bool FitsTurning(const Spot& spot) const;
  // False only where nothing as wide as the inscribed disc can be in the
  // spot's cell.
  bool MayHoldDisc(const Spot& spot) const;
  // How much room the footprint that looks along `yaw_rad` has to its left,
  // beyond the axle's middle (m, up to reach_m): 0 if there is none. The right:
  // `side` -1.
  double RoomBeside_m(const Spot& spot, double yaw_rad, int side,
                      double reach_m) const;
  // A turn where it stands, the shorter way round.
  bool CanTurn(const Spot& spot, double from_yaw_rad, double to_yaw_rad) const;
  // The straight line from `from`; the robot looks along it, or
  // (`looks_back`) the other way. The end with its level; nullopt if something
  // is in the way, the ground ends, or a one-way zone forbids to look so there.
  // A line of no length: `from`, whatever is there.
  std::optional<Spot> Drive(const Spot& from, geometry::Vec2 to,
                            bool looks_back = false) const;
  // The same of a point without a footprint: which level the line ends on.
  std::optional<Spot> Follow(const Spot& from, geometry::Vec2 to) const;
  // The cost of a line that can be driven (m): its length, and more where it is
  // near to things or on slopes.
  double LineCost_m(const Spot& from, const Spot& to) const;
  // What each metre costs at `spot`, at least 1.
  double CostPerMetre(const Spot& spot) const;

 private:
  bool BoxIsFree(int level, const OrientedBox& box) const;
  bool MayHead(const Spot& from, geometry::Vec2 to,
               geometry::Vec2 heading) const;
  OrientedBox BoxAt(geometry::Vec2 at, double yaw_rad) const;

  std::shared_ptr<const GroundIndex> ground_;
  Footprint footprint_;
  std::vector<Disc> discs_;
  WayPrices prices_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_CONFIGURATION_SPACE_H_
