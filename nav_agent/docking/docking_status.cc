#include "nav_agent/docking/docking_status.h"

namespace treeline::docking {

const char* DockingStateName(DockingState state) {
  switch (state) {
    case DockingState::kAway:
      return "away";
    case DockingState::kToStaging:
      return "to-staging";
    case DockingState::kDrivingIn:
      return "driving-in";
    case DockingState::kTouching:
      return "touching";
    case DockingState::kBackingOut:
      return "backing-out";
    case DockingState::kDocked:
      return "docked";
    case DockingState::kDrivingOut:
      return "driving-out";
  }
  return "unknown";
}

const char* DockingOutcomeName(DockingOutcome outcome) {
  switch (outcome) {
    case DockingOutcome::kNone:
      return "none";
    case DockingOutcome::kUnderWay:
      return "under-way";
    case DockingOutcome::kSucceeded:
      return "succeeded";
    case DockingOutcome::kFailed:
      return "failed";
    case DockingOutcome::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

const char* ChargeStateName(ChargeState state) {
  switch (state) {
    case ChargeState::kOff:
      return "off";
    case ChargeState::kEnough:
      return "enough";
    case ChargeState::kUnknown:
      return "unknown";
    case ChargeState::kLow:
      return "low";
    case ChargeState::kGoing:
      return "going";
    case ChargeState::kCharging:
      return "charging";
  }
  return "unknown";
}

}  // namespace treeline::docking
