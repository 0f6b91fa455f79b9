#include "nav_agent/bridge/place_finder/place_report.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::place_finder {
namespace {

using messages::DiagnosticStatus;

DiagnosticStatus LocalizationStatus(const PlaceFinder::State& state) {
  DiagnosticStatus status;
  status.name = "treeline: localization";
  if (!state.verdict.has_value()) {
    status.level = DiagnosticStatus::kStale;
    status.message =
        !state.has_map    ? "no map: whether the robot is lost is not known"
        : !state.has_scan ? "no scan: whether the robot is lost is not known"
                          : "nobody says where the robot is";
    return status;
  }
  TellVerdict(*state.verdict, status);
  return status;
}

DiagnosticStatus RelocalizationStatus(const PlaceFinder::State& state) {
  DiagnosticStatus status;
  status.name = "treeline: relocalization";
  if (state.need == Need::kNone) {
    status.message = "not needed";
  } else if (!state.last_answer.ok()) {
    status.level = DiagnosticStatus::kError;
    status.message = std::string(state.last_answer.message());
  } else if (!state.obstacle.ok()) {
    status.level = DiagnosticStatus::kError;
    status.message = std::string(state.obstacle.message());
  } else if (state.is_server_elsewhere) {
    status.level = DiagnosticStatus::kError;
    status.message =
        "the server is sure of places that map, laser or gravity refuse: is "
        "it the scene of this map, and map_from_world right?";
  } else {
    status.level = DiagnosticStatus::kWarn;
    status.message = state.last_fix.empty()
                         ? "asking"
                         : absl::StrCat("looking on; ", state.last_fix);
  }
  status.values = {{"need", NeedName(state.need)},
                   {"questions", absl::StrCat(state.questions)},
                   {"answers", absl::StrCat(state.answers)},
                   {"refused by the gate", absl::StrCat(state.refused)},
                   {"places published", absl::StrCat(state.places)},
                   {"last fix", state.last_fix},
                   {"last round trip (s)",
                    absl::StrFormat("%.3f", state.last_round_trip_s)}};
  if (!state.camera_dispute.empty()) {
    status.values.push_back({"camera", state.camera_dispute});
  }
  return status;
}

}  // namespace

void TellVerdict(const localization::LostVerdict& verdict,
                 DiagnosticStatus& status) {
  status.message = localization::LostStateName(verdict.state);
  switch (verdict.state) {
    case localization::LostState::kLocalized:
      status.level = DiagnosticStatus::kOk;
      break;
    case localization::LostState::kMapChangedHere:
    case localization::LostState::kPeopleNearby:
      status.level = DiagnosticStatus::kWarn;
      break;
    case localization::LostState::kLost:
      status.level = DiagnosticStatus::kError;
      break;
  }
  status.values = {
      {"probability lost", absl::StrFormat("%.3f", verdict.probability)},
      {"reason", localization::LostReasonName(verdict.reason)}};
}

messages::DiagnosticArray ReportOf(const PlaceFinder::State& state,
                                   const messages::Time& stamp) {
  return {.header = {.stamp = stamp, .frame_id = ""},
          .status = {LocalizationStatus(state), RelocalizationStatus(state)}};
}

}  // namespace treeline::place_finder
