// Why a robot does not do what it was asked to do.
#ifndef NAV_AGENT_CORE_NAVIGATION_CAUSE_H_
#define NAV_AGENT_CORE_NAVIGATION_CAUSE_H_

#include <cstdint>

namespace treeline::core {

// Numbers are those of navigation.proto.
enum class NavigationCause : uint8_t {
  kNone = 0,
  // ---- of plans ----
  kStartBlocked = 1,  // no free ground near the robot
  kGoalBlocked = 2,   // no free ground near the goal
  kGoalOutside = 3,   // the goal is not on the map
  kNoPath = 4,        // free ground at both ends, and no way between
  kPlanTimeout = 5,   // none was found in the time allowed
  // ---- of drives ----
  kCancelled = 6,
  kPreempted = 7,       // another goal took its place
  kBlocked = 8,         // something stands in the way, and recoveries failed
  kNoProgress = 9,      // the robot does not get on
  kCollisionStop = 10,  // something is too near to move
  kRecoveryFailed = 11,
  // ---- safe stops ----
  kLaserLost = 12,
  kOdometryLost = 13,
  kBaseLost = 14,
  kEstimateLost = 15,  // the robot does not know where it is
  kControlLate = 16,   // the control loop missed its deadline by too much
  kTilted = 17,        // lifted, or on ground that is too steep
  kNeedHelp = 18,      // lost, and neither server nor search found it
  kInternal = 19,      // a defect of this program
  // ---- of operators ----
  kStopped = 20,  // stopped until somebody releases it
  // ---- of zones ----
  kZone = 21  // keep-out or one-way zones forbid it
};

// "goal_blocked" and so on.
const char* NavigationCauseName(NavigationCause cause);
// What a person can do about it, one sentence.
const char* NavigationCauseAdvice(NavigationCause cause);

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_NAVIGATION_CAUSE_H_
