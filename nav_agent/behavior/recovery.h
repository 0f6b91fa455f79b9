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

namespace treeline {

class Recovery final : public LostAndFound {
 public:
  Recovery(std::shared_ptr<const NavigationMap> map, const RobotModel& robot,
           RobotTracker& tracker, RelocalizationPort* server,
           const LostAndFoundOptions& options);

  void AddFrame(const RgbdFrame& frame) override;
  void Begin(RecoveryCause cause, MonotonicTime now) override;
  void WasTold(MonotonicTime now) override;
  Output Step(const RecoveryInput& input) override;
  RecoveryState state() const override { return state_; }
  bool WantsPictures(MonotonicTime now) const override;
  std::vector<RecoveryNote> TakeNotes() override;
  const std::optional<RelocalizationAnswer>& answer() const override {
    return answer_;
  }
  const std::string& answer_verdict() const override { return answer_verdict_; }
  std::shared_ptr<const RgbdFrame> QueryFrame() const override {
    return query_frame_;
  }

 private:
  using Answer = absl::StatusOr<RelocalizationAnswer>;

  void Go(RecoveryState state, MonotonicTime now);
  double InState_s(MonotonicTime now) const;
  void Note(const char* kind, std::string text);
  bool MayAsk() const;
  void Ask(const TrackedMotion& motion, MonotonicTime now);
  // The answer if there is one, or that there is none in time.
  std::optional<Answer> AnswerBy(MonotonicTime now);

  // What each state does.
  VelocityCommand Stopping(MonotonicTime now);
  VelocityCommand Looking(MonotonicTime now);
  VelocityCommand Asking(const RecoveryInput& input);
  VelocityCommand Turning(const RecoveryInput& input);
  VelocityCommand Confirming(const RecoveryInput& input);
  VelocityCommand Searching(const RecoveryInput& input);
  void Idle(const RecoveryInput& input);
  // Stands, and asks now and then.
  void Helpless(MonotonicTime now);

  // After an answer.
  void Failed(const absl::Status& status, MonotonicTime now);
  void Judge(const RelocalizationAnswer& answer, MonotonicTime now);
  void LookElsewhere(MonotonicTime now);
  // Of a fix that was seen twice, the views are sure together.
  void Seed(const GatedFix& fix, bool was_seen_twice, MonotonicTime now);
  void LookAgain(const std::string& why, MonotonicTime now);
  void NotConfirmed(const std::string& why, MonotonicTime now);
  void Found(const std::string& how, MonotonicTime now);
  void GiveUpServer(const std::string& why, MonotonicTime now);
  void BeginSearch(MonotonicTime now);
  void NeedHelp(MonotonicTime now);
  void RestoreBefore(MonotonicTime now);

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
  void StepLook(MonotonicTime now);
  bool MayTryClear() const;
  // The same, but a fix that waits for a second view gets that first, if it
  // does not take many questions.
  bool IsLasersTurn() const;
  // Gives it to AMCL; false: that refused it.
  bool TryClear(MonotonicTime now);
  bool IsClearPlace(const GatedFix& fix) const;

  // While searching: the answer to a question that was open when it began;
  // true: it changed the state.
  bool TookAnswer(MonotonicTime now);
  // While searching: whether to stand for the next picture.
  bool IsTimeToAsk(MonotonicTime now) const;
  // While searching: whether it may be believed now.
  bool SearchHolds(MonotonicTime now);
  void BreakHold();
  void LookAnywhere(MonotonicTime now);
  void EndCycle(MonotonicTime now);
  VelocityCommand SearchMotion(const RecoveryInput& input);
  VelocityCommand TurnTowards(double yaw_in_odom_rad) const;
  // Turns on; where something holds it, it swings there and back as far as that
  // and the collision stop let it, and goes ahead if that is nowhere.
  VelocityCommand Swing(const RecoveryInput& input, double speed_radps);

  // The check while driving.
  void CheckSoon(MonotonicTime now);
  void BeginCheck(const RecoveryInput& input);
  void EndCheck(const RelocalizationAnswer& answer, MonotonicTime now);

  std::shared_ptr<const NavigationMap> map_;
  RobotTracker& tracker_;
  RelocalizationPort* server_;
  LostAndFoundOptions options_;
  FixGate gate_;
  ViewBelief belief_;

  RecoveryState state_ = RecoveryState::kIdle;
  RecoveryCause cause_ = RecoveryCause::kVerdict;
  MonotonicTime since_;
  MonotonicTime began_;
  std::vector<RecoveryNote> notes_;
  std::shared_ptr<const RgbdFrame> frame_;
  std::shared_ptr<const RgbdFrame> query_frame_;
  std::optional<RelocalizationAnswer> answer_;
  std::string answer_verdict_;

  // Since when the wheels stand.
  std::optional<MonotonicTime> stands_;
  // The question: of which moment, and when it was asked.
  std::optional<TrackedMotion> asked_motion_;
  MonotonicTime asked_;
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
  std::optional<MonotonicTime> swing_blocked_;
  int sides_blocked_ = 0;
  // Where something held it last that it turned to: right, left.
  std::array<std::optional<Rigid2>, 2> held_at_;
  // Where it thought it was when it began.
  std::optional<TrackedPose> before_;
  std::optional<TrackedMotion> before_motion_;
  bool was_seeded_ = false;

  // Confirming.
  std::optional<GatedFix> seed_;
  bool seen_twice_ = false;
  std::optional<MonotonicTime> scan_;
  int good_scans_ = 0;
  int bad_scans_ = 0;
  double turned_rad_ = 0;
  std::optional<double> last_yaw_rad_;
  Alias alias_ = Alias::kNotLooked;
  RobotTracker::ScanFit alias_own_;

  // The laser's own search: of which moment, and what came of it.
  enum class Look { kNone, kLooking, kDone };
  Look look_ = Look::kNone;
  std::optional<TrackedMotion> look_motion_;
  std::optional<LevelPose> clear_;
  bool clear_was_tried_ = false;

  // Searching.
  std::optional<MonotonicTime> search_began_;
  std::optional<MonotonicTime> last_pause_;
  // What AMCL has is the clear place.
  bool holds_clear_ = false;
  bool searches_anywhere_ = false;
  std::optional<MonotonicTime> holds_since_;
  double hold_turned_rad_ = 0;
  // Of that, when other places were looked for.
  double alias_turned_rad_ = 0;
  double cycle_turned_rad_ = 0;
  double best_free_m_ = 0;
  double best_free_yaw_rad_ = 0;
  enum class Leg { kTurn, kFace, kMove };
  Leg leg_ = Leg::kTurn;
  Rigid2 leg_from_;
  double leg_m_ = 0;
  int cycles_ = 0;

  // Since it said that it needs help, and when it asked last since.
  bool needs_help_ = false;
  std::optional<MonotonicTime> last_help_;

  // The check.
  std::optional<MonotonicTime> last_check_;
  bool is_checking_ = false;
};

}  // namespace treeline

#endif  // NAV_AGENT_BEHAVIOR_RECOVERY_H_
