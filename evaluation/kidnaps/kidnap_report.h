// What a suite of kidnaps comes to.
#ifndef EVALUATION_KIDNAPS_KIDNAP_REPORT_H_
#define EVALUATION_KIDNAPS_KIDNAP_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/kidnaps/kidnap_suite.h"

namespace treeline::kidnaps {

int WrongResumptions(const std::vector<KidnapRun>& runs);
// For people: one line a world, warm and cold, then the sum, then what failed
// and with which seeds. What is missing of `expected` runs was not run.
std::string KidnapSummary(const std::vector<KidnapRun>& runs, int expected);
// docs/reference/suites.md describes it. method, fault: as the command was
// told.
std::string KidnapJson(const std::vector<KidnapRun>& runs, int expected,
                       const std::string& method, const std::string& fault);

}  // namespace treeline::kidnaps

#endif  // EVALUATION_KIDNAPS_KIDNAP_REPORT_H_
