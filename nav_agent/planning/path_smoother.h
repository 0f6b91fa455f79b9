// A way made shorter.
#ifndef NAV_AGENT_PLANNING_PATH_SMOOTHER_H_
#define NAV_AGENT_PLANNING_PATH_SMOOTHER_H_

#include <cstdint>
#include <limits>
#include <vector>

#include "common/base/random.h"
#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

// Of a way between two headings.
class PathSmoother {
 public:
  // `way` must be one that can be driven. It gets no longer than max_length_m
  // (m), or than it is, to cost less.
  PathSmoother(const ConfigurationSpace& space, double start_yaw_rad,
               double goal_yaw_rad, Polyline way,
               double max_length_m = std::numeric_limits<double>::infinity());

  // One attempt at random: a straight line instead of some, a corner cut off,
  // or a point or several moved, or one left out. True if the way costs less
  // now.
  bool Try(base::Random& random);

  const Polyline& way() const { return way_; }
  double cost_m() const { return cost_m_; }
  double length_m() const { return along_m_.back(); }

 private:
  // Puts `between` between the points `first` and `last`, if that can be driven
  // and costs less.
  bool Replace(size_t first, size_t last, const Polyline& between);
  bool TryShortcut(base::Random& random);
  bool TryCut(base::Random& random);
  bool TryMove(base::Random& random);
  bool TryShift(size_t point, base::Random& random);
  double YawInto(size_t point) const;
  double YawOutOf(size_t point) const;
  void SumUp();

  const ConfigurationSpace* space_;
  double start_yaw_rad_;
  double goal_yaw_rad_;
  Polyline way_;
  double max_length_m_;
  double cost_m_ = 0;
  // From the start to each point (m), and what each line costs (m).
  std::vector<double> along_m_;
  std::vector<double> line_cost_m_;
};

// What turning where it stands costs (m).
double TurnCost_m(double from_yaw_rad, double to_yaw_rad);
// The cost of a way (m): its lines', and some for turning.
double PathCost_m(const ConfigurationSpace& space, double start_yaw_rad,
                  double goal_yaw_rad, const Polyline& way);
double PathLength_m(const Polyline& way);
// Whether all lines and turns of the way can be driven.
bool CanBeDriven(const ConfigurationSpace& space, double start_yaw_rad,
                 double goal_yaw_rad, const Polyline& way);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_PATH_SMOOTHER_H_
