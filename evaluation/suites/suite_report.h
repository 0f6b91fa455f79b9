// What the reports of suites share: JSON, tables for people, pictures of what
// went wrong.
#ifndef EVALUATION_SUITES_SUITE_REPORT_H_
#define EVALUATION_SUITES_SUITE_REPORT_H_

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "evaluation/suites/suite_run.h"

namespace treeline::suites {

// Of all runs, those that are good (0 to 1).
template <typename Run>
double GoodShare(const std::vector<Run>& runs) {
  if (runs.empty()) return 0;
  return static_cast<double>(std::ranges::count_if(
             runs, [](const Run& run) { return run.IsGood(); })) /
         static_cast<double>(runs.size());
}

// Sums of runs by name, in the order in which the names come.
template <typename Tally>
class Tallies {
 public:
  template <typename Run>
  void Add(const std::string& name, const Run& run) {
    auto it = std::ranges::find(rows_, name, &Row::first);
    if (it == rows_.end()) it = rows_.insert(rows_.end(), {name, Tally()});
    it->second.Add(run);
  }
  const std::vector<std::pair<std::string, Tally>>& rows() const {
    return rows_;
  }

 private:
  using Row = std::pair<std::string, Tally>;
  std::vector<Row> rows_;
};

// Of the sorted values that at this share of the way (0: the least, 1: the
// largest), to the nearest; 0 of none. base::Quantile takes the next higher.
double NearestQuantile(std::vector<double> values, double share);

// ---- for people ----

// "3 of 10 missions were not run.", or nothing.
std::string NotRunText(size_t done, int expected, const std::string& runs);
// "; 2 collisions", or nothing.
std::string CollisionsText(const SuiteRun& run);

// The plan with the way driven, STEM.png, and beside it, STEM.txt, what
// happened when. Errors of writing.
absl::Status WriteRunPicture(const std::string& stem,
                             const worlds::World& world, const SuiteRun& run,
                             const std::string& title);

// ---- for programs: docs/reference/suites.md ----

std::string StepTimesJson(const StepTimes& times);
std::string PoseMissJson(const PoseMiss& error);
std::string PlacementJson(const simulator::RobotPlacement& placement);

// The first line of a run's entry. kind: what else tells one run from another,
// a name and its JSON.
std::string RunHeadJson(const SuiteRun& run,
                        const std::pair<std::string, std::string>& kind,
                        const std::string& outcome, bool is_good);
// "simulated_s" to "edge_entries".
std::string DriveJson(const SuiteRun& run);

// A list of all runs' entries.
template <typename Run>
std::string RunsJson(const std::vector<Run>& runs,
                     std::string (*run_json)(const Run&)) {
  std::string json = "[";
  const char* separator = "\n";
  for (const Run& run : runs) {
    absl::StrAppend(&json, separator, run_json(run));
    separator = ",\n";
  }
  return json + "\n  ]";
}

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_REPORT_H_
