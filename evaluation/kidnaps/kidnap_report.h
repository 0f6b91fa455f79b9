// What a suite of kidnaps comes to.
#ifndef EVALUATION_KIDNAPS_KIDNAP_REPORT_H_
#define EVALUATION_KIDNAPS_KIDNAP_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/kidnaps/kidnap_suite.h"

namespace treeline::kidnaps {

// Back in time, nothing hit, no stairs, no fall.
bool IsGood(const KidnapRun& run);
double GoodShare(const std::vector<KidnapRun>& runs);
int WrongResumptions(const std::vector<KidnapRun>& runs);
// As MissionSummary and MissionJson. method, fault: as the command was told.
std::string KidnapSummary(const std::vector<KidnapRun>& runs, int expected);
std::string KidnapJson(const std::vector<KidnapRun>& runs, int expected,
                       const std::string& method, const std::string& fault);

}  // namespace treeline::kidnaps

#endif  // EVALUATION_KIDNAPS_KIDNAP_REPORT_H_
