// What stood in the way and is not on the map.
#ifndef NAV_AGENT_BEHAVIOR_OBSTACLE_MEMORY_H_
#define NAV_AGENT_BEHAVIOR_OBSTACLE_MEMORY_H_

#include <functional>
#include <vector>

#include "nav_agent/behavior/navigator.h"

namespace treeline::behavior {

// Discs that plans go around. Each is forgotten after a while, sooner if it is
// seen that nothing is there any more, and later if it is met again and again.
// Not thread-safe.
class ObstacleMemory {
 public:
  explicit ObstacleMemory(const NavigatorLimits& limits) : limits_(limits) {}

  // One that is known is remembered for longer.
  void Add(const planning::Blockage& blockage, base::MonotonicTime now);
  // Forgets what is too old. How many.
  int Fade(base::MonotonicTime now);
  // A scan's beams, from where the laser is to where each ended, in the map,
  // level by level: blockages that many beams pass and none ends in are free,
  // if that is seen for a while; not those of which something is seen
  // otherwise, below the laser's plane or above it. How many were forgotten.
  int SeeThrough(int level, geometry::Vec2 laser,
                 const std::vector<geometry::Vec2>& ends,
                 const std::function<bool(const planning::Blockage&)>& is_seen);
  // Of a robot that was told, or found, that it is elsewhere.
  void Clear() { known_.clear(); }

  std::vector<planning::Blockage> All() const;
  bool empty() const { return known_.empty(); }

 private:
  struct Known {
    planning::Blockage blockage;
    base::MonotonicTime since;
    double lasts_s = 0;
    // Scans in a row that saw it free.
    int seen_free = 0;
  };

  NavigatorLimits limits_;
  std::vector<Known> known_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_OBSTACLE_MEMORY_H_
