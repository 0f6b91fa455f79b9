#include "nav_agent/core/navigation_cause.h"

#include <array>
#include <cstddef>

namespace treeline::core {
namespace {

struct CauseText {
  const char* name;
  const char* advice;
};

constexpr std::array<CauseText, 22> kTexts = {{
    {"none", "Nothing is wrong."},
    {"start_blocked",
     "No free ground is near the robot: move it by hand into the open, or map "
     "the place again."},
    {"goal_blocked",
     "No free ground is near the goal: choose one with room for the robot."},
    {"goal_outside", "The goal is not on the map: choose one that is."},
    {"no_path",
     "No way leads to the goal: open a door, clear what blocks, or choose "
     "another goal."},
    {"plan_timeout", "No way was found in time: send the goal again."},
    {"cancelled", "Somebody cancelled the goal."},
    {"preempted", "Another goal took its place."},
    {"blocked", "Clear the way, and send the goal again."},
    {"no_progress",
     "The robot does not get on: look whether a wheel is stuck or slips."},
    {"collision_stop", "Something is too near to move: clear it away."},
    {"recovery_failed",
     "Clear the robot's surroundings, and send the goal "
     "again."},
    {"laser_lost", "Look at the laser's cable, power and address."},
    {"odometry_lost", "Look at the base's cable and power."},
    {"base_lost", "Look at the base's cable, power and emergency stop."},
    {"estimate_lost", "The robot looks for its place: give it a moment."},
    {"control_late", "The machine is too busy: stop other programs on it."},
    {"tilted", "Set the robot upright, on ground that it can stand on."},
    {"need_help",
     "Show the robot where it is: set its pose on the operator's page."},
    {"internal", "This is a defect: send the log to the developers."},
    {"stopped",
     "Somebody stopped the robot: release it when nothing is in danger."},
    {"zone",
     "Zones forbid it: choose another goal, or change the keep-out and one-way "
     "zones."},
}};

const CauseText& TextOf(NavigationCause cause) {
  return kTexts.at(static_cast<size_t>(cause));
}

}  // namespace

const char* NavigationCauseName(NavigationCause cause) {
  return TextOf(cause).name;
}

const char* NavigationCauseAdvice(NavigationCause cause) {
  return TextOf(cause).advice;
}

}  // namespace treeline::core
