// The way on, among what moves: how far it is to the goal from a place at a
// time.
#ifndef NAV_AGENT_MAPLESS_TIMED_WAY_H_
#define NAV_AGENT_MAPLESS_TIMED_WAY_H_

#include <span>
#include <vector>

#include "nav_agent/mapless/mover_tracker.h"
#include "nav_agent/mapless/way_field.h"

namespace treeline::mapless {

// How dear it is that a body is so near (gap_m, below 0: they overlap) to a
// mover as it is foretold for time_s from now, for each second of it: metres.
// What is foretold spreads with time.
double ThreatRate_mps(double gap_m, double time_s);

// Dynamic programming backwards over layers of time, around the robot: at the
// last layer it is what the way field says; before, the best of standing and of
// going on as far as the robot can in a layer's time, with the threat of all
// movers there and then. So it knows of passing before and behind something, of
// waiting, and of giving way. Not thread-safe.
class TimedWay {
 public:
  // For robots of this radius and speed.
  TimedWay(double body_m, double speed_mps);

  // No movers near: it is empty, and the way field alone counts.
  void Update(const WayField& way, std::span<const Mover> movers,
              geometry::Vec2 robot);
  void Clear() { to_go_.clear(); }
  bool empty() const { return to_go_.empty(); }

  // From a point, so long after the last Update (m, standing still counted as
  // the way that the robot could have gone); WayField::kNoWay outside.
  double ToGo(geometry::Vec2 point, double time_s) const;

 private:
  // Six metres to each side at 2 m/s, as much less as the robot is slower; 3.75
  // s.
  static constexpr int kColumns = 49;
  static constexpr int kLayers = 16;

  size_t IndexOf(int layer, int x, int y) const {
    return (static_cast<size_t>(layer) * kColumns + static_cast<size_t>(y)) *
               kColumns +
           static_cast<size_t>(x);
  }
  geometry::Vec2 CenterOf(int x, int y) const;
  std::vector<float> ThreatsAt(int layer, std::span<const Mover> movers) const;

  double body_m_;
  double speed_mps_;
  // Of a cell; kColumns of them are the window.
  double cell_m_;
  geometry::Vec2 origin_;
  // By layer, row, column.
  std::vector<float> to_go_;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_TIMED_WAY_H_
