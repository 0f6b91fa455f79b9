// What a suite of dockings comes to.
#ifndef EVALUATION_DOCKINGS_DOCKING_REPORT_H_
#define EVALUATION_DOCKINGS_DOCKING_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/dockings/docking_suite.h"

namespace treeline::dockings {

// For people: one line a world and scene, then the sum, then what failed and
// with which seeds. What is missing of `expected` runs was not run.
std::string DockingSummary(const std::vector<DockingRun>& runs, int expected);
// docs/reference/suites.md describes it.
std::string DockingJson(const std::vector<DockingRun>& runs, int expected);

}  // namespace treeline::dockings

#endif  // EVALUATION_DOCKINGS_DOCKING_REPORT_H_
