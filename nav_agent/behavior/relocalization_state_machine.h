// RelocalizationBehavior as it is: which state follows which. What a state does
// is in a class of its own: relocalization_states.h, confirming_state.h,
// laser_search.h.
#ifndef NAV_AGENT_BEHAVIOR_RELOCALIZATION_STATE_MACHINE_H_
#define NAV_AGENT_BEHAVIOR_RELOCALIZATION_STATE_MACHINE_H_

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "nav_agent/behavior/confirming_state.h"
#include "nav_agent/behavior/fix_checker.h"
#include "nav_agent/behavior/laser_search.h"
#include "nav_agent/behavior/next_best_view.h"
#include "nav_agent/behavior/pending_fixes.h"
#include "nav_agent/behavior/place_before.h"
#include "nav_agent/behavior/place_check.h"
#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/behavior/relocalization_states.h"
#include "nav_agent/behavior/relocalization_tools.h"
#include "nav_agent/behavior/server_question.h"

namespace treeline::behavior {

class RelocalizationStateMachine final : public RelocalizationBehavior {
 public:
  RelocalizationStateMachine(
      std::shared_ptr<const traversability::NavigationMap> map,
      const core::RobotModel& robot, localization::RobotTracker& tracker,
      core::RelocalizationPort* server,
      const RelocalizationBehaviorOptions& options);

  void AddFrame(const core::RgbdFrame& frame) override;
  void Begin(RelocalizationCause cause, base::MonotonicTime now) override;
  void NotePoseWasSet(base::MonotonicTime now) override;
  Output Step(const RelocalizationInput& input) override;
  RelocalizationState state() const override;
  bool WantsPictures(base::MonotonicTime now) const override;
  std::vector<RelocalizationNote> TakeNotes() override {
    return tools_.report.TakeNotes();
  }
  const std::optional<core::RelocalizationAnswer>& answer() const override {
    return tools_.report.answer;
  }
  const std::string& answer_verdict() const override {
    return tools_.report.answer_verdict;
  }
  std::shared_ptr<const core::RgbdFrame> QueryFrame() const override {
    return question_.frame();
  }

 private:
  // In RelocalizationState's order.
  using State = std::variant<IdleState, StoppingState, LookingState,
                             AskingState, TurningState, ConfirmingState,
                             SearchingState, FoundState, NeedHelpState>;
  // What a question to the server serves, and where the robot goes back to when
  // that brings nothing: to the next direction, to the search by laser, or to
  // standing and waiting.
  struct CameraPhase {};
  using Phase = std::variant<CameraPhase, LaserSearch, HelpWait>;

  // One recovery, from its beginning to its end.
  struct Episode {
    RelocalizationCause cause = RelocalizationCause::kVerdict;
    base::MonotonicTime began;
    int questions = 0;
    // Questions in a row without an answer.
    int failures = 0;
    bool is_server_useless = false;
    // Answers that said nothing, since one that did.
    int refused = 0;
    // Of places that the laser would not tell from others.
    int second_looks = 0;
    PendingFixes pending;
    PlaceBefore before;
    bool has_tried_unique_place = false;
    NextBestView belief;
  };

  bool MayAsk() const;
  // The laser alone may get on faster, and goes on asking now and then.
  bool IsServerFruitless() const;
  void Ask(const localization::TrackedMotion& motion, base::MonotonicTime now);

  // What each state does.
  void StepIdle(const RelocalizationInput& input);
  void StepStopping(base::MonotonicTime now);
  void StepLooking(base::MonotonicTime now);
  void StepAsking(base::MonotonicTime now);
  core::VelocityCommand StepTurning(const RelocalizationInput& input);
  core::VelocityCommand StepConfirming(const RelocalizationInput& input);
  core::VelocityCommand StepSearching(const RelocalizationInput& input);
  void StepNeedHelp(base::MonotonicTime now);

  // The laser's own search over the whole map, with one scan, while the server
  // is asked.
  void BeginWholeMap();
  void StepWholeMap(base::MonotonicTime now);
  bool MayTryUniquePlace() const;
  // The same, but a fix that waits for a second view gets that first, if it
  // does not take many questions.
  bool IsLasersTurn() const;
  bool TryUniquePlace(base::MonotonicTime now);
  bool IsUniquePlace(const GatedFix& fix) const;

  // After an answer.
  void TakeAnswer(const ServerQuestion::Answer& answer,
                  base::MonotonicTime now);
  void Failed(const absl::Status& status, base::MonotonicTime now);
  void Judge(const core::RelocalizationAnswer& answer, base::MonotonicTime now);
  void LookElsewhere(base::MonotonicTime now);
  bool SeedWaitingUniquePlace(base::MonotonicTime now);
  void TurnToNextView(base::MonotonicTime now);
  // Of a fix that was seen twice, the views are sure together.
  void Seed(const GatedFix& fix, bool was_seen_twice, base::MonotonicTime now);
  void LookAgain(const std::string& why, base::MonotonicTime now);
  void NotConfirmed(const std::string& why, base::MonotonicTime now);
  void Found(const std::string& how, base::MonotonicTime now);
  void GiveUpServer(const std::string& why, base::MonotonicTime now);
  void BeginSearch(base::MonotonicTime now);
  void NeedHelp(base::MonotonicTime now);
  // Where the phase goes on, if it is not the camera's.
  bool ReturnToPhase(base::MonotonicTime now);

  RelocalizationTools tools_;
  FixChecker checker_;
  ServerQuestion question_;
  PlaceCheck check_;
  // The camera's newest.
  std::shared_ptr<const core::RgbdFrame> frame_;
  Episode episode_;
  Phase phase_;
  State state_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RELOCALIZATION_STATE_MACHINE_H_
