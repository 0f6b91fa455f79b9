// What a suite of fields comes to, for people and for programs.
#ifndef EVALUATION_FIELDS_FIELD_REPORT_H_
#define EVALUATION_FIELDS_FIELD_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/fields/field_suite.h"

namespace treeline::fields {

double MeanScore(const std::vector<FieldRun>& runs);

// How many reached the goal, the mean score, and each run that did not.
std::string FieldSummary(const std::vector<FieldRun>& runs, int expected);

// docs/reference/suites.md.
std::string FieldJson(const std::vector<FieldRun>& runs, int expected,
                      const std::string& robot);

}  // namespace treeline::fields

#endif  // EVALUATION_FIELDS_FIELD_REPORT_H_
