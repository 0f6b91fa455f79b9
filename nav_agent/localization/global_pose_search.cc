#include "nav_agent/localization/global_pose_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "nav_agent/localization/parameters.h"

namespace treeline::localization {

GlobalPoseSearch::GlobalPoseSearch(std::shared_ptr<const LaserLevelMap> map,
                                   ScanPoints points,
                                   const std::optional<core::LevelPose>& here,
                                   const GlobalPoseSearchOptions& options)
    : map_(std::move(map)),
      points_(std::move(points)),
      here_(here),
      options_(options) {
  // One free place of each square.
  std::set<std::tuple<int, int64_t, int64_t>> taken;
  for (const FreePlace& place : map_->free_places()) {
    const auto x =
        static_cast<int64_t>(std::floor(place.center.x / options_.place_m));
    const auto y =
        static_cast<int64_t>(std::floor(place.center.y / options_.place_m));
    if (taken.insert({place.place.level, x, y}).second) {
      places_.push_back(place);
    }
  }
}

bool GlobalPoseSearch::AreNear(const core::LevelPose& a,
                               const core::LevelPose& b) const {
  return geometry::Norm(a.map_from_base.translation -
                        b.map_from_base.translation) < options_.away_m &&
         std::abs(geometry::NormalizedAngle_rad(a.map_from_base.yaw_rad -
                                                b.map_from_base.yaw_rad)) <
             options_.away_rad &&
         std::abs(a.place.height_m - b.place.height_m) < kOtherFloor_m;
}

bool GlobalPoseSearch::IsHere(const core::LevelPose& pose) const {
  return here_.has_value() && AreNear(pose, *here_);
}

bool GlobalPoseSearch::Step() {
  const auto headings = static_cast<size_t>(options_.headings);
  const size_t all = places_.size() * headings;
  if (next_ >= all || points_.size() == 0) return true;
  const size_t end = std::min(all, next_ + options_.slice);
  std::vector<Tried> tried;
  tried.reserve(end - next_);
  PoseArrays poses;
  poses.Resize(end - next_);
  for (size_t i = next_; i < end; ++i) {
    const FreePlace& place = places_[i / headings];
    const double yaw_rad = geometry::NormalizedAngle_rad(
        2 * std::numbers::pi * static_cast<double>(i % headings) /
        static_cast<double>(headings));
    tried.push_back({.pose = {.map_from_base = {place.center, yaw_rad},
                              .place = place.place}});
    poses.Set(i - next_, tried.back().pose.map_from_base, place.place.height_m);
  }
  std::vector<float> sums(tried.size());
  map_->field().SumLogLikelihoods(points_, poses, sums);
  for (size_t i = 0; i < tried.size(); ++i) tried[i].log_likelihood = sums[i];
  next_ = end;
  Keep(tried);
  return next_ >= all;
}

void GlobalPoseSearch::Keep(std::vector<Tried>& tried) {
  std::ranges::stable_sort(tried, [](const Tried& a, const Tried& b) {
    return a.log_likelihood > b.log_likelihood;
  });
  for (const Tried& one : tried) {
    // The rest of a slice is of no worth.
    if (best_.size() >= options_.candidates &&
        one.log_likelihood <= best_.back().log_likelihood) {
      break;
    }
    if (IsHere(one.pose)) continue;
    const auto near = std::ranges::find_if(best_, [&](const Tried& other) {
      return AreNear(other.pose, one.pose);
    });
    if (near == best_.end()) {
      best_.push_back(one);
    } else if (near->log_likelihood < one.log_likelihood) {
      *near = one;
    } else {
      continue;
    }
    std::ranges::stable_sort(best_, [](const Tried& a, const Tried& b) {
      return a.log_likelihood > b.log_likelihood;
    });
    if (best_.size() > options_.candidates) best_.pop_back();
  }
}

std::vector<core::LevelPose> GlobalPoseSearch::Best() const {
  std::vector<core::LevelPose> poses;
  poses.reserve(best_.size());
  for (const Tried& one : best_) poses.push_back(one.pose);
  return poses;
}

}  // namespace treeline::localization
