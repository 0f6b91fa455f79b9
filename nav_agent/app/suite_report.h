// What suites of runs come to: JSON, tables for people, pictures of what went
// wrong.
#ifndef NAV_AGENT_APP_SUITE_REPORT_H_
#define NAV_AGENT_APP_SUITE_REPORT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/app/mission_suite.h"

namespace treeline {

// "..." with what JSON wants escaped.
std::string JsonQuoted(absl::string_view text);

// For people: one line a world, then the sum, then what failed and with which
// seeds. What is missing of `expected` runs was not run.
std::string MissionSummary(const std::vector<MissionRun>& runs, int expected);
// docs/suites.md describes it.
std::string MissionJson(const std::vector<MissionRun>& runs, int expected,
                        bool people);
// Of all runs, those that are good (0 to 1).
double GoodShare(const std::vector<MissionRun>& runs);

// The plan with the way driven, and beside it, FILE.txt, what happened when.
// Errors of writing.
absl::Status WriteRunPicture(const std::string& stem, const World& world,
                             const SimulationResult& record,
                             const PlanMarks& marks,
                             const std::vector<NavigatorEvent>& events,
                             const std::string& title);

// ---- what both suites' reports share ----
std::string StepTimesJson(const StepTimes& times);
std::string PoseMissJson(const PoseMiss& error);
std::string PlacementJson(const RobotPlacement& placement);

}  // namespace treeline

#endif  // NAV_AGENT_APP_SUITE_REPORT_H_
