// A lost robot that several places are left for drives to where they differ.
#ifndef NAV_AGENT_BEHAVIOR_PARTING_DRIVE_H_
#define NAV_AGENT_BEHAVIOR_PARTING_DRIVE_H_

#include <optional>
#include <vector>

#include "nav_agent/behavior/parting_view.h"
#include "nav_agent/behavior/relocalization_tools.h"

namespace treeline::behavior {

// The places that are left of a robot that is in doubt, its own first; none
// while it is not known which.
std::vector<localization::PossiblePlace> PlacesLeft(
    const localization::RobotTracker& tracker);

// Chooses a view whenever the search has come to the end of a turn or of a way,
// and sends the search motion there. Says which places are left. Not
// thread-safe.
class PartingDrive {
 public:
  // The search has come to the end of a turn or of a way, which something
  // blocked or not.
  void Begin(const localization::TrackedMotion& motion, bool was_blocked,
             RelocalizationTools& tools);
  // Whether a view is being chosen: the robot stands meanwhile.
  bool is_choosing() const { return view_.has_value(); }
  void Step(const localization::TrackedMotion& motion,
            RelocalizationTools& tools, base::MonotonicTime now);

 private:
  void NoteChoice(const std::vector<localization::PossiblePlace>& places,
                  const std::optional<PartingLeg>& leg,
                  RelocalizationTools& tools) const;

  std::optional<PartingView> view_;
  std::vector<localization::PossiblePlace> places_;
  // Where it chose before, in the odometry's frame.
  std::vector<geometry::Vec2> seen_from_in_odom_;
  // What ended a way before its end: in the odometry's frame.
  std::vector<geometry::Vec2> blocked_in_odom_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PARTING_DRIVE_H_
