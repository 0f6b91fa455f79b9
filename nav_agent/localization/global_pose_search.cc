#include "nav_agent/localization/global_pose_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

// Poses that wait to be reduced, as a multiple of the places that are kept.
constexpr size_t kMinWaiting = 4096;
constexpr size_t kWaitingPerCandidate = 8;

}  // namespace

bool AreNear(const core::LevelPose& a, const core::LevelPose& b, double away_m,
             double away_rad) {
  return geometry::Norm(a.map_from_base.translation -
                        b.map_from_base.translation) < away_m &&
         std::abs(geometry::NormalizedAngle_rad(
             a.map_from_base.yaw_rad - b.map_from_base.yaw_rad)) < away_rad &&
         std::abs(a.place.height_m - b.place.height_m) < kOtherFloor_m;
}

std::vector<FreePlace> OnePlaceOfEachSquare(
    const std::vector<FreePlace>& free_places, double square_m) {
  std::set<std::tuple<int, int64_t, int64_t>> taken;
  std::vector<FreePlace> places;
  for (const FreePlace& place : free_places) {
    const auto x = static_cast<int64_t>(std::floor(place.center.x / square_m));
    const auto y = static_cast<int64_t>(std::floor(place.center.y / square_m));
    if (taken.insert({place.place.level, x, y}).second) {
      places.push_back(place);
    }
  }
  return places;
}

GlobalPoseSearch::GlobalPoseSearch(
    std::shared_ptr<const std::vector<FreePlace>> places, ScanPoints points,
    const std::optional<core::LevelPose>& here,
    const GlobalPoseSearchOptions& options)
    : points_(std::move(points)),
      here_(here),
      options_(options),
      places_(std::move(places)) {}

bool GlobalPoseSearch::Step(const LikelihoodField& field, size_t slice) {
  const auto headings = static_cast<size_t>(options_.headings);
  const size_t all = places_->size() * headings;
  if (next_ >= all || points_.size() == 0) return true;
  const size_t end = std::min(all, next_ + slice);
  std::vector<core::LevelPose> tried;
  tried.reserve(end - next_);
  PoseArrays poses;
  poses.Resize(end - next_);
  for (size_t i = next_; i < end; ++i) {
    const FreePlace& place = (*places_)[i / headings];
    const double yaw_rad = geometry::NormalizedAngle_rad(
        2 * std::numbers::pi * static_cast<double>(i % headings) /
        static_cast<double>(headings));
    tried.push_back(
        {.map_from_base = {place.center, yaw_rad}, .place = place.place});
    poses.Set(i - next_, tried.back().map_from_base, place.place.height_m);
  }
  std::vector<float> sums(tried.size());
  field.SumLogLikelihoods(points_, poses, sums);
  next_ = end;
  const size_t waiting =
      std::max(kMinWaiting, kWaitingPerCandidate * options_.candidates);
  for (size_t i = 0; i < tried.size(); ++i) {
    if (sums[i] <= floor_) continue;
    if (here_.has_value() &&
        AreNear(tried[i], *here_, options_.away_m, options_.away_rad)) {
      continue;
    }
    best_.push_back({.pose = tried[i], .log_likelihood = sums[i]});
    if (best_.size() >= waiting) Reduce();
  }
  return next_ >= all;
}

void GlobalPoseSearch::Reduce() {
  std::ranges::stable_sort(best_, [](const Tried& a, const Tried& b) {
    return a.log_likelihood > b.log_likelihood;
  });
  // Kept ones by squares that are as wide as a place.
  std::map<std::pair<int64_t, int64_t>, std::vector<size_t>> squares;
  const auto square_of = [this](const Tried& one) {
    const geometry::Vec2 at = one.pose.map_from_base.translation;
    return std::pair{static_cast<int64_t>(std::floor(at.x / options_.away_m)),
                     static_cast<int64_t>(std::floor(at.y / options_.away_m))};
  };
  std::vector<Tried> kept;
  const auto is_taken = [&](const Tried& one) {
    const auto [x, y] = square_of(one);
    for (int64_t dx = -1; dx <= 1; ++dx) {
      for (int64_t dy = -1; dy <= 1; ++dy) {
        const auto square = squares.find({x + dx, y + dy});
        if (square == squares.end()) continue;
        for (const size_t i : square->second) {
          if (AreNear(kept[i].pose, one.pose, options_.away_m,
                      options_.away_rad)) {
            return true;
          }
        }
      }
    }
    return false;
  };
  for (const Tried& one : best_) {
    if (one.log_likelihood <
        best_.front().log_likelihood -
            options_.within * static_cast<double>(points_.size())) {
      break;
    }
    if (is_taken(one)) continue;
    if (kept.size() >= options_.candidates) {
      best_dropped_ = std::max(best_dropped_, one.log_likelihood);
      break;
    }
    squares[square_of(one)].push_back(kept.size());
    kept.push_back(one);
  }
  if (kept.empty()) return;
  floor_ =
      kept.front().log_likelihood -
      static_cast<float>(options_.within * static_cast<double>(points_.size()));
  if (kept.size() >= options_.candidates) {
    floor_ = std::max(floor_, kept.back().log_likelihood);
  }
  best_ = std::move(kept);
}

std::vector<core::LevelPose> GlobalPoseSearch::Best() {
  Reduce();
  is_cut_short_ = !best_.empty() &&
                  best_dropped_ >=
                      best_.front().log_likelihood -
                          options_.within * static_cast<double>(points_.size());
  std::vector<core::LevelPose> poses;
  poses.reserve(best_.size());
  for (const Tried& one : best_) poses.push_back(one.pose);
  return poses;
}

}  // namespace treeline::localization
