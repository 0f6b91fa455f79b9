#include "nav_agent/behavior/unique_place_search.h"

#include <vector>

namespace treeline::behavior {

void UniquePlaceSearch::BeginWholeMap() {
  const std::optional<base::MonotonicTime> stamp = tracker_->ScanStamp();
  if (!stamp.has_value()) return;
  const std::optional<localization::TrackedMotion> motion =
      tracker_->MotionAt(*stamp);
  if (!motion.has_value()) return;
  scan_motion_ = *motion;
  place_.reset();
  tracker_->BeginOtherPlaces(std::nullopt);
  whole_map_ = WholeMap::kSearching;
}

bool UniquePlaceSearch::StepWholeMap() {
  if (whole_map_ != WholeMap::kSearching || !tracker_->StepOtherPlaces()) {
    return false;
  }
  whole_map_ = WholeMap::kDone;
  const std::vector<localization::RobotTracker::OtherPlace> places =
      tracker_->BestPlaces();
  if (places.empty()) return true;
  const localization::ScanFit& best = places.front().fit;
  const bool fits = best.explained >= options_.min_explained &&
                    best.contradicted <= options_.max_contradicted &&
                    best.judged >= options_.min_judged;
  const bool has_twin =
      places.size() > 1 && localization::FitScore(places[1].fit) >
                               localization::FitScore(best) - options_.margin;
  if (fits && !has_twin) {
    place_ = {.pose = places.front().pose, .motion = scan_motion_};
  }
  return true;
}

void UniquePlaceSearch::BeginOthers(const core::LevelPose& here) {
  own_fit_ = tracker_->FitAt(here).value_or(localization::ScanFit());
  tracker_->BeginOtherPlaces(here);
  others_ = OtherPlaces::kSearching;
}

bool UniquePlaceSearch::StepOthers() {
  if (others_ != OtherPlaces::kSearching || !tracker_->StepOtherPlaces()) {
    return false;
  }
  const std::vector<localization::RobotTracker::OtherPlace> others =
      tracker_->BestPlaces();
  others_ = OtherPlaces::kNone;
  if (others.empty()) return true;
  const double lead = localization::FitScore(others.front().fit) -
                      localization::FitScore(own_fit_);
  if (lead > options_.margin) {
    others_ = OtherPlaces::kBetter;
  } else if (lead > -options_.margin) {
    others_ = OtherPlaces::kAlike;
  }
  return true;
}

bool UniquePlaceSearch::IsBestPossible() const {
  return localization::FitScore(own_fit_) >= 1 - options_.margin;
}

}  // namespace treeline::behavior
