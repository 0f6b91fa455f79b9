// What the states of a recovery work with, and what they tell.
#ifndef NAV_AGENT_BEHAVIOR_RELOCALIZATION_TOOLS_H_
#define NAV_AGENT_BEHAVIOR_RELOCALIZATION_TOOLS_H_

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/behavior/scan_watch.h"
#include "nav_agent/behavior/search_motion.h"
#include "nav_agent/behavior/swing_motion.h"
#include "nav_agent/behavior/unique_place_search.h"

namespace treeline::behavior {

// What a recovery says of itself. Not thread-safe.
class RelocalizationReport {
 public:
  void Note(const char* kind, std::string text) {
    notes_.push_back({.kind = kind, .text = std::move(text)});
  }
  std::vector<RelocalizationNote> TakeNotes() {
    return std::exchange(notes_, {});
  }

  // The last answer of the server, and what became of it.
  std::optional<core::RelocalizationAnswer> answer;
  std::string answer_verdict;

 private:
  std::vector<RelocalizationNote> notes_;
};

// Kept from one state to the next. tracker must outlive it.
struct RelocalizationTools {
  RelocalizationTools(
      std::shared_ptr<const traversability::NavigationMap> navigation_map,
      const core::RobotModel& robot_model,
      localization::RobotTracker& robot_tracker,
      const RelocalizationBehaviorOptions& recovery_options)
      : map(std::move(navigation_map)),
        robot(robot_model),
        tracker(robot_tracker),
        options(recovery_options),
        unique(robot_tracker,
               {.min_explained = recovery_options.search_explained,
                .max_contradicted = recovery_options.search_contradicted,
                .min_judged = recovery_options.gate.min_judged_beams,
                .margin = recovery_options.alias_margin}) {}

  std::shared_ptr<const traversability::NavigationMap> map;
  core::RobotModel robot;
  localization::RobotTracker& tracker;
  const RelocalizationBehaviorOptions options;
  RelocalizationReport report;
  // Of the place that is on trial.
  ScanWatch scans;
  TurnMeter turns;
  UniquePlaceSearch unique;
  SwingMotion swing;
  SearchMotion search_motion;
};

// Scans of fewer judged beams say nothing of a place that is on trial.
inline int MinJudgedOnTrial(const RelocalizationBehaviorOptions& options) {
  return options.gate.min_judged_beams / 2;
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RELOCALIZATION_TOOLS_H_
