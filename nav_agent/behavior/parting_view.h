// Where a lost robot drives to while several places of the map explain what it
// has seen: to a view in which these places differ.
#ifndef NAV_AGENT_BEHAVIOR_PARTING_VIEW_H_
#define NAV_AGENT_BEHAVIOR_PARTING_VIEW_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/localization/place_hypotheses.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// Straight on, in the frame of the odometry.
struct PartingLeg {
  double yaw_rad = 0;
  double way_m = 0;
  // Of the view that it leads to, in (0, 1].
  double gain = 0;
};

// Active localization by the laser (Fox, Burgard and Thrun 1998, "Active Markov
// localization for mobile robots", with ways on the map instead of actions):
// views lie on ways that the map has free for each of the places, slopes and
// other levels included, and that no obstacle was seen on. What a laser would
// see there of each place is cast on the map. A view's gain is the expected
// part of the doubt that it takes away: over all pairs of places, by their
// shares, 1 - exp(-s / kPartingShare), where s is the share of beams in which
// the two differ there more than here.
//
// Works through the views a few a step. Not thread-safe.
class PartingView {
 public:
  // places: as they are at odom_from_base; the likeliest kPartingPlaces count.
  // obstacles_in_odom: where nothing leads past nearer than radius_m, the room
  // that the robot needs to either side. seen_from_in_odom: where it looked
  // around before; views near to these gain kKnownWorth of what they would.
  PartingView(const traversability::NavigationMap& map,
              std::vector<localization::PossiblePlace> places,
              const geometry::Rigid2& odom_from_base,
              const std::vector<geometry::Vec2>& obstacles_in_odom,
              std::vector<geometry::Vec2> seen_from_in_odom, double radius_m);

  // True when no view is left.
  bool Step(const localization::RobotTracker& tracker);
  // Then: the first straight leg of the way to the best view, nullopt if none
  // in reach parts the places.
  std::optional<PartingLeg> leg() const;
  // Views that are to be looked at in all.
  size_t views() const { return views_.size(); }

 private:
  // A square of the ground about the robot, if every place has it free.
  struct Square {
    double way_m = 0;
    int from = -1;
    // Of the places' ground there.
    std::vector<core::LevelPlace> ground;
    bool is_reached = false;
  };

  geometry::Vec2 InOdom(int square) const;
  core::LevelPose PoseAt(size_t place, int square) const;
  void MarkObstacles(const std::vector<geometry::Vec2>& obstacles_in_odom,
                     double radius_m);
  bool StepOnto(const traversability::NavigationMap& map, double radius_m,
                int from, int to);
  void Spread(const traversability::NavigationMap& map, double radius_m);
  // For each pair of places, the share of beams in which they differ.
  std::vector<double> Differences(const localization::RobotTracker& tracker,
                                  int square) const;
  double Gain(const std::vector<double>& differences) const;
  bool WasSeenFrom(int square) const;
  bool IsStraightFree(int from, int to) const;

  std::vector<localization::PossiblePlace> places_;
  geometry::Rigid2 odom_from_base_;
  std::vector<geometry::Vec2> seen_from_in_odom_;
  std::vector<Square> squares_;
  std::vector<uint8_t> is_blocked_;
  std::vector<int> views_;
  size_t next_ = 0;
  // Of where it stands; empty: not looked at yet.
  std::vector<double> here_;
  int best_ = -1;
  double best_worth_ = 0;
  double best_gain_ = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PARTING_VIEW_H_
