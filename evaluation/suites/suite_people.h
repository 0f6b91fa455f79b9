// People that a suite adds to a world, beside those that walk about there.
#ifndef EVALUATION_SUITES_SUITE_PEOPLE_H_
#define EVALUATION_SUITES_SUITE_PEOPLE_H_

#include "simulation/simulator/simulator.h"
#include "simulation/worlds/world.h"

namespace treeline::suites {

// The world's first person, of World::bodies; -1: there is none.
int PersonOf(const worlds::World& world);

// There, a pause, back, a pause, and so on.
worlds::Motion ToAndFro(const simulator::RobotPlacement& from,
                        const simulator::RobotPlacement& to, double walk_mps,
                        double pause_s);

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_PEOPLE_H_
