// How a robot gets on with its dock, and with its charge.
#ifndef NAV_AGENT_DOCKING_DOCKING_STATUS_H_
#define NAV_AGENT_DOCKING_DOCKING_STATUS_H_

#include <cstdint>
#include <optional>
#include <string>

namespace treeline::docking {

enum class DockingState : uint8_t {
  kAway = 0,
  kToStaging = 1,  // drives, as to any goal, to the pose before its dock
  kDrivingIn = 2,
  kTouching = 3,    // in the dock; waits for the battery to tell of a contact
  kBackingOut = 4,  // for another try, or to give up
  kDocked = 5,
  kDrivingOut = 6  // before it does anything else
};
// "away", "to-staging" and so on.
const char* DockingStateName(DockingState state);

// What became of the docking that somebody asked for last.
enum class DockingOutcome : uint8_t {
  kNone = 0,  // nobody asked
  kUnderWay = 1,
  kSucceeded = 2,
  kFailed = 3,
  kCancelled = 4
};
const char* DockingOutcomeName(DockingOutcome outcome);

struct DockingStatus {
  // Counts dockings since the agent's start, from 1; 0: none yet.
  uint64_t id = 0;
  DockingOutcome outcome = DockingOutcome::kNone;
  // Of one that failed or was cancelled: why; of one that succeeded, how well.
  std::string why = {};
  // Tries to drive in that came to nothing.
  int failed_tries = 0;
  DockingState state = DockingState::kAway;
  // That it drives to, stands in or drives out of; empty: none.
  std::string dock = {};
};

enum class ChargeState : uint8_t {
  kOff = 0,  // it is not to charge by itself, or there is no dock
  kEnough = 1,
  kUnknown = 2,  // the battery does not tell its charge: nothing happens
  kLow = 3,      // and it does not go: `why` says what it waits for
  kGoing = 4,
  kCharging = 5
};
// "off", "enough" and so on.
const char* ChargeStateName(ChargeState state);

struct ChargeStatus {
  ChargeState state = ChargeState::kOff;
  // For people.
  std::string why = {};
};

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCKING_STATUS_H_
