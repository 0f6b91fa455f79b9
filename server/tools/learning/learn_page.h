// The page that `treeline learn` ends with: how good the scene will be, where
// it will work, and where to record more.
#ifndef SERVER_TOOLS_LEARNING_LEARN_PAGE_H_
#define SERVER_TOOLS_LEARNING_LEARN_PAGE_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/core/keyframes/coverage.h"
#include "server/tools/learning/verdict.h"
#include "server/tools/learning/weak_spots.h"

namespace treeline::learning {

// A held-out picture that was not answered rightly.
struct MissedPicture {
  std::string stem;
  std::string why;   // "not recognised", "off by 12 cm"
  std::string jpeg;  // for the page
};

struct PageCoverage {
  keyframes::CoverageSummary summary;
  std::string png;
  std::vector<WeakSpot> weak_spots;  // A, B, ... in the picture
};

// One step of the work, and what came of it.
struct LearnStep {
  std::string name;
  std::string result;
  double seconds = 0;
};

struct LearnPage {
  std::string scene;
  std::string source;
  std::string made_utc;
  std::string software;
  bool units_are_metres = true;
  // When an answer is right: "5 cm and 5 degrees".
  std::string right_within;
  std::vector<HeldOutTrial> trials;
  // Pictures of nothing that were asked about, and how many were answered.
  int foreign_pictures = 0;
  int foreign_answered = 0;
  std::optional<PageCoverage> coverage;
  std::string no_coverage_because;  // where there is none
  int missed = 0;                   // in all; `missed_pictures` are some
  std::vector<MissedPicture> missed_pictures;
  std::vector<LearnStep> steps;
  std::vector<std::string> notes;
  // What to do next: a heading and a command line each.
  std::vector<std::pair<std::string, std::string>> commands;
};

// What the page says of where to record more, an entry a place; "A" and so on
// come from the order of the weak spots. Empty: nowhere in particular.
std::vector<std::string> AdviceOf(const LearnPage& page);

// One HTML file without scripts that needs no other. Texts are escaped.
std::string LearnPageHtml(const LearnPage& page);

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_LEARN_PAGE_H_
