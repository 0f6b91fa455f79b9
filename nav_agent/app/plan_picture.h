// A world from above, with the way that a robot took.
#ifndef NAV_AGENT_APP_PLAN_PICTURE_H_
#define NAV_AGENT_APP_PLAN_PICTURE_H_

#include <optional>
#include <vector>

#include "common/geometry/rigid2.h"
#include "common/image/image.h"
#include "common/synthetic/world.h"
#include "nav_agent/app/simulation_run.h"
#include "nav_agent/sim/terrain.h"

namespace treeline {

// What else a plan shows, in the world's frame.
struct PlanMarks {
  // Where it was to go: a green arrow.
  std::optional<Rigid2> goal = std::nullopt;
  // What the robot had planned: a thin magenta line.
  std::vector<Vec3> path = {};
  // Where the robot is, as it believes: a red arrow; and really: a blue one.
  std::optional<Rigid2> believed = std::nullopt;
  std::optional<Rigid2> really = std::nullopt;
};

// North (+y) is up. Ground is grey, lighter where it is higher; ramps are
// ochre, stairs brown, furniture dark, walls black, glass blue. The tour is a
// thin grey line, the track blue from a green start; collisions are red where
// the robot caused them and orange where not, falls are purple. Of floors over
// one another the highest shows.
ColorImage DrawPlan(const World& world, const Terrain& terrain,
                    const SimulationResult& result,
                    const PlanMarks& marks = {});

}  // namespace treeline

#endif  // NAV_AGENT_APP_PLAN_PICTURE_H_
