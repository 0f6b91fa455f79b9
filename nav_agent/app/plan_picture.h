// A world from above, with the way that a robot took.
#ifndef NAV_AGENT_APP_PLAN_PICTURE_H_
#define NAV_AGENT_APP_PLAN_PICTURE_H_

#include "common/image/image.h"
#include "common/synthetic/world.h"
#include "nav_agent/app/simulation_run.h"
#include "nav_agent/sim/terrain.h"

namespace treeline {

// North (+y) is up. Ground is grey, lighter where it is higher; ramps are
// ochre, stairs brown, furniture dark, walls black, glass blue. The tour is a
// thin grey line, the track blue from a green start; collisions are red where
// the robot caused them and orange where not, falls are purple. Of floors over
// one another the highest shows.
ColorImage DrawPlan(const World& world, const Terrain& terrain,
                    const SimulationResult& result);

}  // namespace treeline

#endif  // NAV_AGENT_APP_PLAN_PICTURE_H_
