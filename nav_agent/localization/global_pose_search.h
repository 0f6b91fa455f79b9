// Where on the map a scan fits: all places, or those elsewhere than at one.
#ifndef NAV_AGENT_LOCALIZATION_GLOBAL_POSE_SEARCH_H_
#define NAV_AGENT_LOCALIZATION_GLOBAL_POSE_SEARCH_H_

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/laser_level_map.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

struct GlobalPoseSearchOptions {
  // In so many headings poses are tried at each place.
  int headings = kSearchHeadings;
  // Elsewhere is further away than either of these.
  double away_m = kOtherPlace_m;
  double away_rad = kOtherPlace_rad;
  // Of those that fit best, so many are handed over, at least away_m or
  // away_rad from one another.
  size_t candidates = kSearchCandidates;
  // What fits worse than the best by more than this, of the mean log likelihood
  // of a beam, is not handed over.
  double within = std::numeric_limits<double>::infinity();
};

// Whether two poses are the same place, as far as a search tells places apart.
bool AreNear(const core::LevelPose& a, const core::LevelPose& b, double away_m,
             double away_rad);

// The first place of each square.
std::vector<FreePlace> OnePlaceOfEachSquare(
    const std::vector<FreePlace>& free_places, double square_m);

// Works through all poses by the likelihood field, a slice at a time. Memory
// for a few thousand poses.
// Deterministic; not thread-safe.
class GlobalPoseSearch {
 public:
  // places: that are tried (OnePlaceOfEachSquare). here: what is near it is
  // left out; nullopt: nothing is.
  GlobalPoseSearch(std::shared_ptr<const std::vector<FreePlace>> places,
                   ScanPoints points,
                   const std::optional<core::LevelPose>& here,
                   const GlobalPoseSearchOptions& options = {});

  // Tries so many poses; field: the same each time. True when there is nothing
  // left to try.
  bool Step(const LikelihoodField& field, size_t slice = kSearchSlice);
  // The best that were found, the best first.
  std::vector<core::LevelPose> Best();
  // Whether more fitted than Best has handed over.
  bool is_cut_short() const { return is_cut_short_; }

 private:
  struct Tried {
    core::LevelPose pose;
    float log_likelihood = 0;
  };
  // Of the best, one for each place, in their order.
  void Reduce();

  ScanPoints points_;
  std::optional<core::LevelPose> here_;
  GlobalPoseSearchOptions options_;
  std::shared_ptr<const std::vector<FreePlace>> places_;
  // Of places_ times headings.
  size_t next_ = 0;
  // Not reduced yet, beyond what was kept.
  std::vector<Tried> best_;
  // What is not better is of no worth any more.
  float floor_ = -std::numeric_limits<float>::infinity();
  // The best that found no room.
  float best_dropped_ = -std::numeric_limits<float>::infinity();
  bool is_cut_short_ = false;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_GLOBAL_POSE_SEARCH_H_
