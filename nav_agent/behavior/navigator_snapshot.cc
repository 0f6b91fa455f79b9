#include "nav_agent/behavior/navigator_snapshot.h"

namespace treeline::behavior {

const char* NavigatorModeName(NavigatorMode mode) {
  switch (mode) {
    case NavigatorMode::kIdle:
      return "idle";
    case NavigatorMode::kPlanning:
      return "planning";
    case NavigatorMode::kDriving:
      return "driving";
    case NavigatorMode::kRecovering:
      return "recovering";
    case NavigatorMode::kLost:
      return "lost";
    case NavigatorMode::kRelocalizing:
      return "relocalizing";
    case NavigatorMode::kPaused:
      return "paused";
    case NavigatorMode::kSafeStop:
      return "safe_stop";
    case NavigatorMode::kNeedHelp:
      return "need_help";
    case NavigatorMode::kStopped:
      return "stopped";
    case NavigatorMode::kManual:
      return "manual";
  }
  return "unknown";
}

}  // namespace treeline::behavior
