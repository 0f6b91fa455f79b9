// What suites of runs come to: JSON, tables for people, pictures of what went
// wrong.
#ifndef EVALUATION_MISSIONS_SUITE_REPORT_H_
#define EVALUATION_MISSIONS_SUITE_REPORT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "evaluation/missions/mission_suite.h"

namespace treeline::missions {

// "..." with what JSON wants escaped.
std::string JsonQuoted(absl::string_view text);

// For people: one line a world, then the sum, then what failed and with which
// seeds. What is missing of `expected` runs was not run.
std::string MissionSummary(const std::vector<MissionRun>& runs, int expected);
// docs/reference/suites.md describes it.
std::string MissionJson(const std::vector<MissionRun>& runs, int expected,
                        bool people);
// Of all runs, those that are good (0 to 1).
double GoodShare(const std::vector<MissionRun>& runs);

// The plan with the way driven, and beside it, FILE.txt, what happened when.
// Errors of writing.
absl::Status WriteRunPicture(
    const std::string& stem, const worlds::World& world,
    const runs::SimulationResult& record, const runs::PlanMarks& marks,
    const std::vector<behavior::NavigatorEvent>& events,
    const std::string& title);

// ---- what both suites' reports share ----
std::string StepTimesJson(const suites::StepTimes& times);
std::string PoseMissJson(const suites::PoseMiss& error);
std::string PlacementJson(const simulator::RobotPlacement& placement);

}  // namespace treeline::missions

#endif  // EVALUATION_MISSIONS_SUITE_REPORT_H_
