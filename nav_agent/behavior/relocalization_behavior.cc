#include "nav_agent/behavior/relocalization_behavior.h"

#include <utility>

#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/relocalization_state_machine.h"

namespace treeline::behavior {

const char* RelocalizationMethodName(RelocalizationMethod method) {
  switch (method) {
    case RelocalizationMethod::kServer:
      return "server";
    case RelocalizationMethod::kAmclOnly:
      return "amcl";
    case RelocalizationMethod::kInjectionOnly:
      return "injection";
  }
  return "?";
}

const char* RelocalizationStateName(RelocalizationState state) {
  switch (state) {
    case RelocalizationState::kIdle:
      return "idle";
    case RelocalizationState::kStopping:
      return "stopping";
    case RelocalizationState::kLooking:
      return "looking";
    case RelocalizationState::kAsking:
      return "asking";
    case RelocalizationState::kTurning:
      return "turning";
    case RelocalizationState::kConfirming:
      return "confirming";
    case RelocalizationState::kSearching:
      return "searching";
    case RelocalizationState::kFound:
      return "found";
    case RelocalizationState::kNeedHelp:
      return "need help";
  }
  return "?";
}

const char* RelocalizationCauseText(RelocalizationCause cause) {
  switch (cause) {
    case RelocalizationCause::kVerdict:
      return "the robot is lost";
    case RelocalizationCause::kStart:
      return "nobody has told the robot where it is";
    case RelocalizationCause::kPerson:
      return "a person asked where the robot is";
    case RelocalizationCause::kCheck:
      return "the server sees the robot elsewhere";
  }
  return "?";
}

absl::Status RelocalizationBehaviorOptions::Validate() const {
  TL_RETURN_IF_ERROR(gate.Validate());
  TL_RETURN_IF_ERROR(base::CheckRange("lost: deadline_s", deadline_s, 0.1, 60));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_questions", max_questions, 0, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_failures", max_failures, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_server_s", max_server_s, 0, 3600));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_search_s", max_search_s, 0, 3600));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: settle_s", settle_s, 0, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: turn_radps", turn_radps, 0.05, 3));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: move_mps", move_mps, 0.01, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: confirm_scans", confirm_scans, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: confirm_turn_rad", confirm_turn_rad, 0, 7));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_confirm_s", max_confirm_s, 1, 60));
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

absl::StatusOr<std::unique_ptr<RelocalizationBehavior>>
RelocalizationBehavior::Create(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, localization::RobotTracker& tracker,
    core::RelocalizationPort* server,
    const RelocalizationBehaviorOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  if (map == nullptr) return absl::InvalidArgumentError("lost: no map");
  return std::make_unique<RelocalizationStateMachine>(std::move(map), robot,
                                                      tracker, server, options);
}

}  // namespace treeline::behavior
