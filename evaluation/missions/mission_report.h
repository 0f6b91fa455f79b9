// What a suite of missions comes to.
#ifndef EVALUATION_MISSIONS_MISSION_REPORT_H_
#define EVALUATION_MISSIONS_MISSION_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/missions/mission_suite.h"
#include "simulation/worlds/world.h"

namespace treeline::missions {

// For people: one line a world, then the sum, then what failed and with which
// seeds. What is missing of `expected` runs was not run.
std::string MissionSummary(const std::vector<MissionRun>& runs, int expected);
// docs/reference/suites.md describes it.
std::string MissionJson(const std::vector<MissionRun>& runs, int expected,
                        bool people, const worlds::Rearrangement& rearranged);

}  // namespace treeline::missions

#endif  // EVALUATION_MISSIONS_MISSION_REPORT_H_
