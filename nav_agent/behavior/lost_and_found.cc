#include "nav_agent/behavior/lost_and_found.h"

#include <utility>

#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/relocalization_state_machine.h"

namespace treeline::behavior {

const char* RecoveryMethodName(RecoveryMethod method) {
  switch (method) {
    case RecoveryMethod::kServer:
      return "server";
    case RecoveryMethod::kAmclOnly:
      return "amcl";
    case RecoveryMethod::kInjectionOnly:
      return "injection";
  }
  return "?";
}

const char* RecoveryStateName(RecoveryState state) {
  switch (state) {
    case RecoveryState::kIdle:
      return "idle";
    case RecoveryState::kStopping:
      return "stopping";
    case RecoveryState::kLooking:
      return "looking";
    case RecoveryState::kAsking:
      return "asking";
    case RecoveryState::kTurning:
      return "turning";
    case RecoveryState::kConfirming:
      return "confirming";
    case RecoveryState::kSearching:
      return "searching";
    case RecoveryState::kFound:
      return "found";
    case RecoveryState::kNeedHelp:
      return "need help";
  }
  return "?";
}

const char* RecoveryCauseText(RecoveryCause cause) {
  switch (cause) {
    case RecoveryCause::kVerdict:
      return "the robot is lost";
    case RecoveryCause::kStart:
      return "nobody has told the robot where it is";
    case RecoveryCause::kPerson:
      return "a person asked where the robot is";
    case RecoveryCause::kCheck:
      return "the server sees the robot elsewhere";
  }
  return "?";
}

absl::Status LostAndFoundOptions::Validate() const {
  TL_RETURN_IF_ERROR(gate.Validate());
  TL_RETURN_IF_ERROR(base::CheckRange("lost: deadline_s", deadline_s, 0.1, 60));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_questions", max_questions, 0, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_failures", max_failures, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: most_server_s", most_server_s, 0, 3600));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: most_search_s", most_search_s, 0, 3600));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: settle_s", settle_s, 0, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: turn_radps", turn_radps, 0.05, 3));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: move_mps", move_mps, 0.01, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: confirm_scans", confirm_scans, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: confirm_turn_rad", confirm_turn_rad, 0, 7));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: most_confirm_s", most_confirm_s, 1, 60));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: confirm_explained", confirm_explained, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: confirm_contradicted",
                                      confirm_contradicted, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: search_explained", search_explained, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: search_contradicted", search_contradicted, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: search_hold_s", search_hold_s, 0, 600));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: search_hold_rad", search_hold_rad, 0, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: search_share", search_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: search_std_m", search_std_m, 0, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: alias_margin", alias_margin, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: help_interval_s", help_interval_s, 0, 1e6));
  return base::CheckRange("lost: check_interval_s", check_interval_s, 0, 1e6);
}

absl::StatusOr<std::unique_ptr<LostAndFound>> LostAndFound::Create(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, localization::RobotTracker& tracker,
    core::RelocalizationPort* server, const LostAndFoundOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  if (map == nullptr) return absl::InvalidArgumentError("lost: no map");
  return std::make_unique<RelocalizationStateMachine>(std::move(map), robot,
                                                      tracker, server, options);
}

}  // namespace treeline::behavior
