// Without a server: what the laser says of itself, or else AMCL that looks
// everywhere while the robot turns and moves. A place is believed only if it
// holds for long, over much of a turn, and no other place fits nearly as well.
#ifndef NAV_AGENT_BEHAVIOR_LASER_SEARCH_H_
#define NAV_AGENT_BEHAVIOR_LASER_SEARCH_H_

#include <cstdint>
#include <optional>

#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/behavior/parting_drive.h"
#include "nav_agent/behavior/relocalization_tools.h"

namespace treeline::behavior {

// Goes on where it was after questions to the server have interrupted it. Not
// thread-safe.
class LaserSearch {
 public:
  LaserSearch(RelocalizationTools& tools, base::MonotonicTime now);

  // Gives AMCL the place where alone the scan fits; false: it refused that.
  bool TryUniquePlace(const UniquePlace& place,
                      const localization::TrackedMotion& motion,
                      RelocalizationTools& tools, base::MonotonicTime now);
  // AMCL looks everywhere, unless the method leaves that to its own injection.
  void LookEverywhere(RelocalizationTools& tools, base::MonotonicTime now);
  // After a question: the robot stands where it stood.
  static void Resume(RelocalizationTools& tools, base::MonotonicTime now) {
    tools.search_motion.Resume(now);
  }
  // Whether the fix is of the place that is all but sure among those that
  // explain the scans of several viewpoints: two sensors that err apart say the
  // same.
  static bool IsLikeliest(const GatedFix& fix,
                          const RelocalizationTools& tools);
  // What was believed meanwhile did not hold: AMCL is to look everywhere after
  // the next turn.
  void NoteRefuted(RelocalizationTools& tools);

  // Before Step.
  void AddTurn(const localization::TrackedMotion& motion,
               RelocalizationTools& tools);

  struct ServerState {
    bool may_be_asked = false;
    bool is_asked = false;
    bool has_failed = false;
  };
  enum class Outcome : uint8_t {
    kOpen,
    kFound,
    kTimeIsUp,
    kAsks,        // the robot is to stand for a picture
    kCamerasTurn  // the unique place does not hold: the camera looks on
  };
  struct Result {
    Outcome outcome = Outcome::kOpen;
    core::VelocityCommand wanted;
  };
  Result Step(const RelocalizationInput& input,
              const localization::TrackedMotion& motion,
              const ServerState& server, RelocalizationTools& tools);

 private:
  void BreakHold(RelocalizationTools& tools);
  // Whether what AMCL has may be believed now.
  bool Holds(RelocalizationTools& tools, base::MonotonicTime now);
  // What AMCL has is not where the wheels have brought it from what it had a
  // step ago: another place.
  bool HasJumped(RelocalizationTools& tools);
  // AMCL's place has held for long enough: whether there are others like it.
  bool IsOnlyPlace(RelocalizationTools& tools);
  bool IsTimeToAsk(const ServerState& server, base::MonotonicTime now) const;
  Outcome EndTurn(const ServerState& server, RelocalizationTools& tools,
                  base::MonotonicTime now);
  // Turns and ways; to where the places that are left differ.
  Result Move(const RelocalizationInput& input,
              const localization::TrackedMotion& motion,
              const ServerState& server, RelocalizationTools& tools);

  base::MonotonicTime began_;
  // The last stand for a picture.
  base::MonotonicTime last_pause_;
  // What AMCL has is the place where alone a scan fits.
  bool holds_unique_place_ = false;
  // AMCL was told, or looks everywhere, since the search began.
  bool has_told_amcl_ = false;
  // AMCL has looked everywhere since it was told last, and what it found was in
  // doubt: once it is not any more, all other places are excluded by scans from
  // several viewpoints.
  bool has_spread_ = false;
  bool was_in_doubt_ = false;
  // AMCL's place a step ago, and the wheels' then.
  struct Before {
    core::LevelPose pose;
    localization::TrackedMotion motion;
  };
  std::optional<Before> before_;
  PartingDrive parting_;
  std::optional<base::MonotonicTime> holds_since_;
  // Since then; and of that, when other places were searched for (rad).
  double hold_turned_rad_ = 0;
  double others_turned_rad_ = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_LASER_SEARCH_H_
