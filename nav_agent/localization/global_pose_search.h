// Where on the map a scan fits: all places, or those elsewhere than at one.
#ifndef NAV_AGENT_LOCALIZATION_GLOBAL_POSE_SEARCH_H_
#define NAV_AGENT_LOCALIZATION_GLOBAL_POSE_SEARCH_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/laser_level_map.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

struct GlobalPoseSearchOptions {
  // Poses are tried at places this far apart (m) and in so many headings.
  double place_m = kSearchGrid_m;
  int headings = kSearchHeadings;
  // Elsewhere is further away than either of these.
  double away_m = kOtherPlace_m;
  double away_rad = kOtherPlace_rad;
  // Of those that fit best, so many are handed over, at least away_m or
  // away_rad from one another.
  size_t candidates = kSearchCandidates;
  // Poses of one Step.
  size_t slice = kSearchSlice;
};

// Works through all poses by the likelihood field, a slice at a time.
// Deterministic; not thread-safe.
class GlobalPoseSearch {
 public:
  // here: what is near it is left out; nullopt: nothing is.
  GlobalPoseSearch(std::shared_ptr<const LaserLevelMap> map, ScanPoints points,
                   const std::optional<core::LevelPose>& here,
                   const GlobalPoseSearchOptions& options = {});

  // True when there is nothing left to try.
  bool Step();
  // The best that were found, the best first.
  std::vector<core::LevelPose> Best() const;

 private:
  struct Tried {
    core::LevelPose pose;
    float log_likelihood = 0;
  };
  bool IsHere(const core::LevelPose& pose) const;
  bool AreNear(const core::LevelPose& a, const core::LevelPose& b) const;
  void Keep(std::vector<Tried>& tried);

  std::shared_ptr<const LaserLevelMap> map_;
  ScanPoints points_;
  std::optional<core::LevelPose> here_;
  GlobalPoseSearchOptions options_;
  std::vector<FreePlace> places_;
  // Of places_ times headings.
  size_t next_ = 0;
  std::vector<Tried> best_;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_GLOBAL_POSE_SEARCH_H_
