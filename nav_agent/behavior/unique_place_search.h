// Whether a scan fits at one place of the map only: rooms that are alike cannot
// be told apart by the laser.
#ifndef NAV_AGENT_BEHAVIOR_UNIQUE_PLACE_SEARCH_H_
#define NAV_AGENT_BEHAVIOR_UNIQUE_PLACE_SEARCH_H_

#include <cstdint>
#include <optional>

#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

struct UniquePlaceOptions {
  // A place counts only where the scan fits so well, of so many judged beams.
  double min_explained = kSureExplained;
  double max_contradicted = kSearchContradicted;
  int min_judged = kMinJudgedBeams;
  // Two places look the same if their scores differ by less than this.
  double margin = kAliasMargin;
};

// Where a scan fits, and nowhere else nearly as well.
struct UniquePlace {
  core::LevelPose pose;
  // The wheels' of that scan's moment.
  localization::TrackedMotion motion;
};

// What a scan shows elsewhere than at one place.
enum class OtherPlaces : uint8_t {
  kNotSearched,
  kSearching,
  kNone,   // it fits nowhere else nearly as well
  kAlike,  // it fits elsewhere nearly as well
  kBetter  // it fits clearly better elsewhere
};

// Works with the tracker's search over the map, which is one: the question that
// was begun last is the one that it works on. tracker must outlive it; not
// thread-safe.
class UniquePlaceSearch {
 public:
  UniquePlaceSearch(localization::RobotTracker& tracker,
                    const UniquePlaceOptions& options)
      : tracker_(&tracker), options_(options) {}

  // ---- which place it is, of the whole map ----

  // With the newest scan. A place that was found before is forgotten.
  void BeginWholeMap();
  // Goes on a slice; true in the step in which the search ends.
  bool StepWholeMap();
  // Ends it without a result, or forgets that there was one; the place stays.
  void EndWholeMap() { whole_map_ = WholeMap::kNotBegun; }
  // It was begun, whether or not it has ended.
  bool has_begun_whole_map() const { return whole_map_ != WholeMap::kNotBegun; }
  // nullopt: no place fits well enough, or more than one does.
  const std::optional<UniquePlace>& place() const { return place_; }
  void ForgetPlace() { place_.reset(); }

  // ---- whether there are others than this one ----

  // With the newest scan, whose fit at `here` is what others are compared with.
  void BeginOthers(const core::LevelPose& here);
  // While they are searched for; true in the step in which the search ends.
  bool StepOthers();
  void ForgetOthers() { others_ = OtherPlaces::kNotSearched; }
  OtherPlaces others() const { return others_; }
  // No place could fit better by the margin.
  bool IsBestPossible() const;

 private:
  enum class WholeMap : uint8_t { kNotBegun, kSearching, kDone };

  localization::RobotTracker* tracker_;
  UniquePlaceOptions options_;
  WholeMap whole_map_ = WholeMap::kNotBegun;
  localization::TrackedMotion scan_motion_;
  std::optional<UniquePlace> place_;
  OtherPlaces others_ = OtherPlaces::kNotSearched;
  localization::ScanFit own_fit_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_UNIQUE_PLACE_SEARCH_H_
