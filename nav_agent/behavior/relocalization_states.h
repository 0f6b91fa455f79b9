// The states of a recovery in which nothing is believed yet: the robot comes to
// a stand, waits for a picture and for the server's answer, turns to where the
// next picture promises most. Each has its own data and says what came of it;
// relocalization_state_machine.h says what follows.
#ifndef NAV_AGENT_BEHAVIOR_RELOCALIZATION_STATES_H_
#define NAV_AGENT_BEHAVIOR_RELOCALIZATION_STATES_H_

#include <cstdint>
#include <optional>

#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

// The robot knows its place, or was never told to look for it.
struct IdleState {};

// Until the wheels stand.
class StoppingState {
 public:
  explicit StoppingState(base::MonotonicTime now) : since_(now) {}
  // True once they have stood for settle_s, or do not stand in time.
  bool Step(const std::optional<localization::TrackedMotion>& motion,
            double settle_s, base::MonotonicTime now);

 private:
  base::MonotonicTime since_;
  std::optional<base::MonotonicTime> standing_since_;
};

// Until there is a picture taken since.
class LookingState {
 public:
  explicit LookingState(base::MonotonicTime now) : since_(now) {}
  enum class Outcome : uint8_t { kWaiting, kHasPicture, kNoPictures };
  // frame: the camera's newest; null: none yet.
  Outcome Step(const core::RgbdFrame* frame, base::MonotonicTime now) const;

 private:
  base::MonotonicTime since_;
};

// Until the server has answered.
class AskingState {
 public:
  explicit AskingState(base::MonotonicTime now) : since_(now) {}
  // An answer that may come any moment is waited for without doing anything
  // else; not for longer.
  bool HasPatience(base::MonotonicTime now) const;

 private:
  base::MonotonicTime since_;
};

// Turns to a direction in the frame of the odometry (rad).
class TurningState {
 public:
  TurningState(double target_rad, base::MonotonicTime now)
      : target_rad_(target_rad), since_(now) {}
  enum class Outcome : uint8_t { kTurns, kThere, kNoRoom };
  // kThere also where it takes too long.
  struct Result {
    Outcome outcome = Outcome::kTurns;
    core::VelocityCommand wanted;
  };
  Result Step(const localization::TrackedMotion& motion, double max_radps,
              base::MonotonicTime now) const;

 private:
  double target_rad_;
  base::MonotonicTime since_;
};

// It was found in the step before.
struct FoundState {};

// Looks for its place by laser: LaserSearch has the data.
struct SearchingState {};

// Stands, and waits to be told: HelpWait has the data.
struct NeedHelpState {};

// What a robot that has given up waits for. It asks a server now and then, as
// that may have come back.
class HelpWait {
 public:
  explicit HelpWait(base::MonotonicTime now) : last_asked_(now) {}
  // interval_s 0: never.
  bool IsTimeToAsk(double interval_s, base::MonotonicTime now) const;
  void NoteAsked(base::MonotonicTime now) { last_asked_ = now; }

 private:
  base::MonotonicTime last_asked_;
};

// Pictures older than this are not asked about.
bool IsFresh(const core::RgbdFrame& frame, base::MonotonicTime now);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RELOCALIZATION_STATES_H_
