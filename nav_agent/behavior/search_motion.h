// How a robot moves that looks for its place by laser: a full turn, then to the
// freest side, again and again. Where it cannot turn to that, or no side is
// free, it backs up first.
#ifndef NAV_AGENT_BEHAVIOR_SEARCH_MOTION_H_
#define NAV_AGENT_BEHAVIOR_SEARCH_MOTION_H_

#include <cstdint>
#include <optional>

#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/behavior/swing_motion.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

struct SearchSpeeds {
  double turn_radps = 0;
  double move_mps = 0;
};

// Not thread-safe.
class SearchMotion {
 public:
  struct Result {
    core::VelocityCommand wanted;
    // A full turn has ended in this step.
    bool has_turned_around = false;
    // A move has.
    bool has_arrived = false;
    // It has because something came in its way.
    bool was_blocked = false;
  };

  void Begin(base::MonotonicTime now);
  // After something else than the search moved the robot: the leg's time begins
  // anew.
  void Resume(base::MonotonicTime now) { leg_since_ = now; }
  // The place that it was at was wrong: what it passed since counts as seen.
  void CountOneTurn() { turns_ = 1; }
  // Next it faces this direction (rad, of the odometry) and moves so far, at
  // this speed: somebody knows more of the way than what is free ahead.
  void GoTo(double yaw_in_odom_rad, double way_m, double move_mps,
            const localization::TrackedMotion& motion, base::MonotonicTime now);
  // Not on a turn.
  bool is_moving() const { return leg_ != Leg::kTurn; }
  // On a way of GoTo.
  bool is_under_way() const { return ordered_.has_value(); }
  // Such a way ends here: a turn begins.
  void EndWay(const localization::TrackedMotion& motion,
              base::MonotonicTime now);
  // The robot turned by so much (rad, at least 0).
  void AddTurn(double turned_rad) { turned_rad_ += turned_rad; }

  Result Step(const localization::TrackedMotion& motion,
              const RelocalizationInput& input, const SearchSpeeds& speeds,
              SwingMotion& swing);

 private:
  enum class Leg : uint8_t { kTurn, kFace, kBackUp, kMove };

  void NextLeg(Leg leg, const localization::TrackedMotion& motion,
               base::MonotonicTime now);
  Result Turn(const localization::TrackedMotion& motion,
              const RelocalizationInput& input, const SearchSpeeds& speeds,
              SwingMotion& swing);
  core::VelocityCommand Face(const localization::TrackedMotion& motion,
                             const RelocalizationInput& input,
                             double turn_radps);
  core::VelocityCommand BackUp(const localization::TrackedMotion& motion,
                               base::MonotonicTime now);
  // It wants to move, and has not for long.
  bool IsHeld(bool moves, base::MonotonicTime now);
  // Where it is and looks, something held it that its free way does not show.
  bool WasHeldHere(const localization::TrackedMotion& motion) const;
  // Something holds it that is to face a direction: it backs up and tries
  // again; or goes ahead, and looks for a way from there. False: no room.
  bool BacksUp(const localization::TrackedMotion& motion,
               const RelocalizationInput& input);
  bool GoesAhead(const localization::TrackedMotion& motion,
                 const RelocalizationInput& input);
  Result Move(const localization::TrackedMotion& motion,
              const RelocalizationInput& input, double move_mps);
  bool IsStuck(base::MonotonicTime now) const;

  Leg leg_ = Leg::kTurn;
  base::MonotonicTime leg_since_;
  geometry::Rigid2 leg_from_;
  // Of a move, ahead or back.
  double leg_m_ = 0;
  // For the direction that it is to face.
  bool has_backed_up_ = false;
  // What GoTo has ordered.
  struct Way {
    double yaw_rad = 0;
    double way_m = 0;
    double move_mps = 0;
  };
  std::optional<Way> ordered_;
  // Of a robot that faces its way, or moves: since when it has not.
  std::optional<base::MonotonicTime> held_since_;
  // Where the last move ended that was held.
  std::optional<geometry::Rigid2> move_held_at_;
  // Since the leg began.
  double turned_rad_ = 0;
  // Full turns that ended.
  int turns_ = 0;
  // The freest way of this turn, less where the robot came from.
  double best_free_m_ = 0;
  double best_free_yaw_rad_ = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SEARCH_MOTION_H_
