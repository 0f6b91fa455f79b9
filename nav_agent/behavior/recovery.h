// LostAndFound as it is: states, and what each does in a step.
#ifndef NAV_AGENT_BEHAVIOR_RECOVERY_H_
#define NAV_AGENT_BEHAVIOR_RECOVERY_H_

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav_agent/behavior/lost_and_found.h"
#include "nav_agent/behavior/view_belief.h"

namespace treeline::behavior {

class Recovery final : public LostAndFound {
 public:
  Recovery(std::shared_ptr<const traversability::NavigationMap> map,
           const core::RobotModel& robot, localization::RobotTracker& tracker,
           core::RelocalizationPort* server,
           const LostAndFoundOptions& options);

  void AddFrame(const core::RgbdFrame& frame) override;
  void Begin(RecoveryCause cause, base::MonotonicTime now) override;
  void WasTold(base::MonotonicTime now) override;
  Output Step(const RecoveryInput& input) override;
  RecoveryState state() const override { return state_; }
  bool WantsPictures(base::MonotonicTime now) const override;
  std::vector<RecoveryNote> TakeNotes() override;
  const std::optional<core::RelocalizationAnswer>& answer() const override {
    return answer_;
  }
  const std::string& answer_verdict() const override { return answer_verdict_; }
  std::shared_ptr<const core::RgbdFrame> QueryFrame() const override {
    return query_frame_;
  }

 private:
  using Answer = absl::StatusOr<core::RelocalizationAnswer>;

  void Go(RecoveryState state, base::MonotonicTime now);
  double InState_s(base::MonotonicTime now) const;
  void Note(const char* kind, std::string text);
  bool MayAsk() const;
  void Ask(const localization::TrackedMotion& motion, base::MonotonicTime now);
  // The answer if there is one, or that there is none in time.
  std::optional<Answer> AnswerBy(base::MonotonicTime now);

  // What each state does.
  core::VelocityCommand Stopping(base::MonotonicTime now);
  core::VelocityCommand Looking(base::MonotonicTime now);
  core::VelocityCommand Asking(const RecoveryInput& input);
  core::VelocityCommand Turning(const RecoveryInput& input);
  core::VelocityCommand Confirming(const RecoveryInput& input);
  core::VelocityCommand Searching(const RecoveryInput& input);
  void Idle(const RecoveryInput& input);
  // Stands, and asks now and then.
  void Helpless(base::MonotonicTime now);

  // After an answer.
  void Failed(const absl::Status& status, base::MonotonicTime now);
  void Judge(const core::RelocalizationAnswer& answer, base::MonotonicTime now);
  void LookElsewhere(base::MonotonicTime now);
  // Of a fix that was seen twice, the views are sure together.
  void Seed(const GatedFix& fix, bool was_seen_twice, base::MonotonicTime now);
  void LookAgain(const std::string& why, base::MonotonicTime now);
  void NotConfirmed(const std::string& why, base::MonotonicTime now);
  void Found(const std::string& how, base::MonotonicTime now);
  void GiveUpServer(const std::string& why, base::MonotonicTime now);
  void BeginSearch(base::MonotonicTime now);
  void NeedHelp(base::MonotonicTime now);
  void RestoreBefore(base::MonotonicTime now);

  // Confirming and searching: what the newest scan says, once.
  enum class ScanSays { kNothingNew, kGood, kBad };
  ScanSays WatchScan(double explained, double contradicted);
  bool IsPoseTight(double share, double std_m) const;
  // Other places where the scan fits nearly as well, or clearly better.
  enum class Alias { kNotLooked, kLooking, kNone, kSome, kBetter };
  // Once they are known.
  Alias AliasFound() const;
  // The laser's own search over the whole map, with one scan, while the server
  // is asked. The place is *clear* if that scan fits there well and nowhere
  // else nearly as well.
  void BeginLook();
  void StepLook(base::MonotonicTime now);
  bool MayTryClear() const;
  // The same, but a fix that waits for a second view gets that first, if it
  // does not take many questions.
  bool IsLasersTurn() const;
  // Gives it to AMCL; false: that refused it.
  bool TryClear(base::MonotonicTime now);
  bool IsClearPlace(const GatedFix& fix) const;

  // While searching: the answer to a question that was open when it began;
  // true: it changed the state.
  bool TookAnswer(base::MonotonicTime now);
  // While searching: whether to stand for the next picture.
  bool IsTimeToAsk(base::MonotonicTime now) const;
  // While searching: whether it may be believed now.
  bool SearchHolds(base::MonotonicTime now);
  void BreakHold();
  void LookAnywhere(base::MonotonicTime now);
  void EndCycle(base::MonotonicTime now);
  core::VelocityCommand SearchMotion(const RecoveryInput& input);
  core::VelocityCommand TurnTowards(double yaw_in_odom_rad) const;
  // Turns on; where something holds it, it swings there and back as far as that
  // and the collision stop let it, and goes ahead if that is nowhere.
  core::VelocityCommand Swing(const RecoveryInput& input, double speed_radps);

  // The check while driving.
  void CheckSoon(base::MonotonicTime now);
  void BeginCheck(const RecoveryInput& input);
  void EndCheck(const core::RelocalizationAnswer& answer,
                base::MonotonicTime now);

  std::shared_ptr<const traversability::NavigationMap> map_;
  localization::RobotTracker& tracker_;
  core::RelocalizationPort* server_;
  LostAndFoundOptions options_;
  FixGate gate_;
  ViewBelief belief_;

  RecoveryState state_ = RecoveryState::kIdle;
  RecoveryCause cause_ = RecoveryCause::kVerdict;
  base::MonotonicTime since_;
  base::MonotonicTime began_;
  std::vector<RecoveryNote> notes_;
  std::shared_ptr<const core::RgbdFrame> frame_;
  std::shared_ptr<const core::RgbdFrame> query_frame_;
  std::optional<core::RelocalizationAnswer> answer_;
  std::string answer_verdict_;

  // Since when the wheels stand.
  std::optional<base::MonotonicTime> stands_;
  // The question: of which moment, and when it was asked.
  std::optional<localization::TrackedMotion> asked_motion_;
  base::MonotonicTime asked_;
  int questions_ = 0;
  int failures_ = 0;
  // Localized, and refused by the gate, in a row.
  int refused_ = 0;
  // A question of a recovery is open.
  bool asks_ = false;
  bool server_is_useless_ = false;
  // Fixes that wait for another one that agrees.
  std::vector<GatedFix> waiting_;
  double target_rad_ = 0;
  // The side that it swings to, since when it has not moved there, and how
  // often in a row that was so.
  double swing_ = 1;
  std::optional<base::MonotonicTime> swing_blocked_;
  int sides_blocked_ = 0;
  // Where something held it last that it turned to: right, left.
  std::array<std::optional<geometry::Rigid2>, 2> held_at_;
  // Where it thought it was when it began.
  std::optional<localization::TrackedPose> before_;
  std::optional<localization::TrackedMotion> before_motion_;
  bool was_seeded_ = false;

  // Confirming.
  std::optional<GatedFix> seed_;
  bool seen_twice_ = false;
  std::optional<base::MonotonicTime> scan_;
  int good_scans_ = 0;
  int bad_scans_ = 0;
  double turned_rad_ = 0;
  std::optional<double> last_yaw_rad_;
  Alias alias_ = Alias::kNotLooked;
  localization::RobotTracker::ScanFit alias_own_;

  // The laser's own search: of which moment, and what came of it.
  enum class Look { kNone, kLooking, kDone };
  Look look_ = Look::kNone;
  std::optional<localization::TrackedMotion> look_motion_;
  std::optional<core::LevelPose> clear_;
  bool clear_was_tried_ = false;

  // Searching.
  std::optional<base::MonotonicTime> search_began_;
  std::optional<base::MonotonicTime> last_pause_;
  // What AMCL has is the clear place.
  bool holds_clear_ = false;
  bool searches_anywhere_ = false;
  std::optional<base::MonotonicTime> holds_since_;
  double hold_turned_rad_ = 0;
  // Of that, when other places were looked for.
  double alias_turned_rad_ = 0;
  double cycle_turned_rad_ = 0;
  double best_free_m_ = 0;
  double best_free_yaw_rad_ = 0;
  enum class Leg { kTurn, kFace, kMove };
  Leg leg_ = Leg::kTurn;
  geometry::Rigid2 leg_from_;
  double leg_m_ = 0;
  int cycles_ = 0;

  // Since it said that it needs help, and when it asked last since.
  bool needs_help_ = false;
  std::optional<base::MonotonicTime> last_help_;

  // The check.
  std::optional<base::MonotonicTime> last_check_;
  bool is_checking_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RECOVERY_H_
