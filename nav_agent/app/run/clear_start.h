// People of a simulated world who would run into a robot that has just begun.
#ifndef NAV_AGENT_APP_RUN_CLEAR_START_H_
#define NAV_AGENT_APP_RUN_CLEAR_START_H_

#include "common/geometry/rigid2.h"
#include "simulation/worlds/world.h"

namespace treeline::run_app {

// Bodies of people see no robot. Those that walk (what stays in its place, such
// as doors, is left alone) keep `room_m` between their outline and `start`
// (world): where they would come nearer they walk around it, in the same time.
void KeepOffStart(geometry::Vec2 start, double room_m, worlds::World& world);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_CLEAR_START_H_
