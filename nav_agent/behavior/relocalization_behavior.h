// How a lost robot finds its place again: it stops, asks a server, does not
// believe the answer, looks again, and goes on when it is sure. What it does is
// drawn in docs/explanation/kidnap-recovery.md.
#ifndef NAV_AGENT_BEHAVIOR_RELOCALIZATION_BEHAVIOR_H_
#define NAV_AGENT_BEHAVIOR_RELOCALIZATION_BEHAVIOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// What a lost robot may do, for comparisons.
enum class RelocalizationMethod : uint8_t {
  kServer = 0,        // asks, and looks over the map with the laser meanwhile
  kAmclOnly = 1,      // AMCL looks everywhere while the robot turns and moves
  kInjectionOnly = 2  // only AMCL's own injection
};
const char* RelocalizationMethodName(RelocalizationMethod method);

enum class RelocalizationState : uint8_t {
  kIdle = 0,        // knows its place, or was never told to look for it
  kStopping = 1,    // until the wheels stand
  kLooking = 2,     // waits for a picture taken since
  kAsking = 3,      // waits for the server's answer
  kTurning = 4,     // to where the next picture says most
  kConfirming = 5,  // took a fix: it must hold while the robot moves
  kSearching = 6,   // AMCL looks everywhere
  kFound = 7,       // for one step; then kIdle
  kNeedHelp = 8     // until it is told its place, or a server knows it
};
const char* RelocalizationStateName(RelocalizationState state);

enum class RelocalizationCause : uint8_t {
  kVerdict = 0,  // the lost detector's
  kStart = 1,    // no start pose was given
  kPerson = 2,   // a person asked
  kCheck = 3     // the server's answer to a check disagrees
};
// "the robot is lost": for people.
const char* RelocalizationCauseText(RelocalizationCause cause);

struct RelocalizationBehaviorOptions {
  RelocalizationMethod method = RelocalizationMethod::kServer;
  FixGateOptions gate;
  // Of one question (s, 0.1 to 60).
  double deadline_s = kAnswerDeadline_s;
  // Questions, failed ones too, before it goes on without the server.
  int max_questions = kMaxQuestions;
  // Failures in a row (no server, too late, no such scene) after which it does.
  int max_failures = kMaxFailures;
  // A recovery ends after so long (s): in kNeedHelp.
  double max_server_s = kMaxServerSearch_s;
  double max_search_s = kMaxLaserSearch_s;
  // Pictures are taken so long after the wheels stood (s).
  double settle_s = kPictureSettle_s;
  double turn_radps = kRecoveryTurn_radps;
  double move_mps = kRecoveryMove_mps;
  // Confirming: scans that must fit in a row, and the turn (rad) meanwhile. A
  // scan fits if the map explains this share of it and contradicts at most
  // that.
  int confirm_scans = kConfirmScans;
  double confirm_turn_rad = kNewViewTurn_rad;
  double max_confirm_s = kMaxConfirming_s;
  double confirm_explained = kConfirmExplained;
  double confirm_contradicted = kConfirmContradicted;
  // What AMCL finds by itself must fit better, for longer (s, rad), with so
  // much of its weight in one place this small (m), and no other place of the
  // map may fit nearly as well: by this share of the beams.
  double search_explained = kSureExplained;
  double search_contradicted = kSearchContradicted;
  double search_hold_s = kSearchHold_s;
  double search_hold_rad = kSearchHold_rad;
  double search_share = kSearchShare;
  double search_std_m = kSearchStd_m;
  double alias_margin = kAliasMargin;
  // Asks this often while it drives straight and knows its place (s); 0: never.
  double check_interval_s = kCheckInterval_s;
  // A robot that needs help asks this often (s); 0: never.
  double help_interval_s = kAskFailedInterval_s;

  absl::Status Validate() const;
};

// What the navigator knows when it steps.
struct RelocalizationInput {
  base::MonotonicTime now;
  // A goal is being driven to, about straight ahead.
  bool drives_straight = false;
  // It recovers: the way to the goal is not as the map has it.
  bool is_in_trouble = false;
  // What the controller has seen allows; not what the map has, which is
  // elsewhere for a robot that is lost.
  bool can_turn = true;
  double free_ahead_m = 0;
  // 0 while people may come up behind it.
  double free_behind_m = 0;
};

struct RelocalizationNote {
  // As NavigatorEvent's: "lost", "fix", "recovery", "resume", "help", "check".
  std::string kind;
  std::string text;
};

// Owned by the navigator, which steps it with everything else, gives it the
// camera's frames, and lets its wishes through the collision stop. Looks at the
// tracker's verdict itself, and tells the tracker. Deterministic if the server
// is; not thread-safe.
class RelocalizationBehavior {
 public:
  // `tracker` and `server` (null: none) must outlive it.
  static absl::StatusOr<std::unique_ptr<RelocalizationBehavior>> Create(
      std::shared_ptr<const traversability::NavigationMap> map,
      const core::RobotModel& robot, localization::RobotTracker& tracker,
      core::RelocalizationPort* server,
      const RelocalizationBehaviorOptions& options);
  virtual ~RelocalizationBehavior() = default;

  // Whether a picture taken now would be looked at: a question or a check is
  // due.
  virtual bool WantsPictures(base::MonotonicTime now) const = 0;
  // Every frame of the camera; the newest is kept.
  virtual void AddFrame(const core::RgbdFrame& frame) = 0;
  // Begins a recovery by order, also while there is one, or after kNeedHelp.
  virtual void Begin(RelocalizationCause cause, base::MonotonicTime now) = 0;
  // A person told the tracker where the robot is: no recovery now.
  virtual void NotePoseWasSet(base::MonotonicTime now) = 0;

  // After the tracker got what there is. Begins by itself when the verdict is
  // "lost". While IsActive the robot does nothing but `wanted`.
  struct Output {
    RelocalizationState state = RelocalizationState::kIdle;
    core::VelocityCommand wanted;
  };
  virtual Output Step(const RelocalizationInput& input) = 0;

  virtual RelocalizationState state() const = 0;
  // Neither kIdle nor kFound.
  bool IsActive() const {
    return state() != RelocalizationState::kIdle &&
           state() != RelocalizationState::kFound;
  }
  // Since the last call.
  virtual std::vector<RelocalizationNote> TakeNotes() = 0;
  // The last answer of the server, and what became of it.
  virtual const std::optional<core::RelocalizationAnswer>& answer() const = 0;
  virtual const std::string& answer_verdict() const = 0;
  // The last frame that was sent; null: none yet.
  virtual std::shared_ptr<const core::RgbdFrame> QueryFrame() const = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RELOCALIZATION_BEHAVIOR_H_
