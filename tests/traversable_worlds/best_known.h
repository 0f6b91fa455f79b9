// How short a way can be: what others are compared with.
#ifndef TESTS_TRAVERSABLE_WORLDS_BEST_KNOWN_H_
#define TESTS_TRAVERSABLE_WORLDS_BEST_KNOWN_H_

#include <memory>
#include <vector>

#include "nav_agent/planning/global_planner.h"
#include "nav_agent/planning/plan_frame.h"
#include "nav_agent/planning/variable_rrt.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline {

// The shortest way of a point, at any angle, over the cells that the footprint
// fits in somehow: no way of the footprint is shorter. A* over the corners of
// what is blocked, of which each shortest way consists, seen over exact lines.
// Of one level.
class PointWay {
 public:
  explicit PointWay(const planning::PlanGround& ground);

  // Empty if there is none, or none of at most max_m.
  planning::Polyline Find(geometry::Vec2 start, geometry::Vec2 goal,
                          double max_m) const;

 private:
  bool Sees(geometry::Vec2 from, geometry::Vec2 to) const;

  double resolution_m_ = 0;
  // Blocked: where it does not fit.
  std::unique_ptr<planning::GroundIndex> index_;
  std::vector<geometry::Vec2> corners_;
};

// Why a way is longer than the best one known (in percent of that): the three
// add up to the excess.
struct ExcessOf {
  double total = 0;
  // A way as short as can be on the same sides of all things is so much longer
  // than the best one.
  double other_side = 0;
  // Comfort: the cheapest one on the same sides is so much longer than that.
  double comfort = 0;
  // And the way itself so much longer than the cheapest.
  double slack = 0;
  // Whether there is something between it and the best one.
  bool is_other_side = false;
};

// Of one request, whose ends have room.
class BestKnown {
 public:
  // Plans `rounds` times in plan_s of processor time each, once along the
  // point's way, and if that is much shorter over the whole lattice; makes all
  // of them as short as can be. `planner`: the ordinary
  // one on the same map.
  BestKnown(const planning::PlanGround& ground, const PointWay& point,
            const planning::GlobalPlanner& planner,
            const planning::PlanRequest& request, int rounds, double plan_s);

  // Infinite if no way was found.
  double length_m() const { return length_m_; }
  // No way is shorter; 0 if the point has none, or beyond the best one's
  // length.
  double bound_m() const { return bound_m_; }
  ExcessOf Excess(const planning::PlanResult& result) const;

 private:
  // At the least cost in a space, starting from a way that can be driven.
  planning::Polyline Polished(const planning::ConfigurationSpace& space,
                              const planning::Polyline& way) const;
  void Offer(planning::Polyline way);
  planning::Polyline WayOf(const planning::PlanResult& result) const;

  const planning::PlanGround* ground_;
  planning::PlanRequest request_;
  planning::ConfigurationSpace comfortable_;
  // A metre costs a metre.
  planning::ConfigurationSpace plain_;
  planning::Polyline best_;
  double length_m_;
  double bound_m_ = 0;
};

}  // namespace treeline

#endif  // TESTS_TRAVERSABLE_WORLDS_BEST_KNOWN_H_
