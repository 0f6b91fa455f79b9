// What a suite of kidnaps comes to.
#ifndef EVALUATION_KIDNAPS_KIDNAP_REPORT_H_
#define EVALUATION_KIDNAPS_KIDNAP_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/kidnaps/kidnap_suite.h"
#include "simulation/worlds/world.h"

namespace treeline::kidnaps {

int WrongResumptions(const std::vector<KidnapRun>& runs);
// What all runs of a suite have in common, as the command was told.
struct KidnapConditions {
  std::string method;
  std::string fault;
  // Light of the runs, and of the drive that their map was made from.
  building::Lighting lighting = building::Lighting::kDay;
  building::Lighting map_lighting = building::Lighting::kDay;
  worlds::Rearrangement rearranged{};
};

// For people: one line a world, warm and cold, then the sum, then what failed
// and with which seeds. What is missing of `expected` runs was not run.
std::string KidnapSummary(const std::vector<KidnapRun>& runs, int expected);
// docs/reference/suites.md describes it.
std::string KidnapJson(const std::vector<KidnapRun>& runs, int expected,
                       const KidnapConditions& conditions);

}  // namespace treeline::kidnaps

#endif  // EVALUATION_KIDNAPS_KIDNAP_REPORT_H_
