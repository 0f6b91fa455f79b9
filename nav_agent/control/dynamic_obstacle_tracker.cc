#include "nav_agent/control/dynamic_obstacle_tracker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "nav_agent/control/driving_parameters.h"

namespace treeline::control {

void DynamicObstacleTracker::Clear() {
  tracks_.clear();
  hidden_.Clear();
}

std::vector<DynamicObstacleTracker::Cluster> DynamicObstacleTracker::ClustersOf(
    std::span<const TrackedScan> looks) const {
  std::vector<Cluster> clusters;
  const auto add = [&](geometry::Vec2 in_map) {
    auto nearest = std::ranges::find_if(clusters, [&](const Cluster& cluster) {
      return geometry::Norm(cluster.Middle() - in_map) < options_.size_m;
    });
    if (nearest == clusters.end()) {
      nearest = clusters.insert(clusters.end(), Cluster());
    }
    nearest->sum = nearest->sum + in_map;
    ++nearest->points;
  };
  for (const TrackedScan& look : looks) {
    for (const ObservedPoint& point : look.points) {
      if (point.is_moving) add(point.in_map);
    }
  }
  return clusters;
}

bool DynamicObstacleTracker::IsCut(std::span<const TrackedScan> looks,
                                   geometry::Vec2 in_map) const {
  bool is_seen = false;
  for (const TrackedScan& look : looks) {
    const std::optional<BeamTowards> beam = BeamTo(look, in_map);
    if (!beam.has_value() || beam->range_m <= beam->away_m - kInFront_m) {
      continue;
    }
    if (beam->to_edge_m >= options_.cut_m) return false;
    is_seen = true;
  }
  return is_seen;
}

void DynamicObstacleTracker::Follow(Track& track, geometry::Vec2 in_map,
                                    double interval_s) const {
  // Who comes into sight again is there, not between there and where it was
  // expected, and goes another way perhaps.
  if (track.unseen_s > kLately_s) track.fitted = 0;
  track.fitted = std::min(track.fitted + 1, options_.fitted_scans);
  const double n = track.fitted;
  const geometry::Vec2 surprise = in_map - track.in_map;
  track.in_map = track.in_map + (2 * (2 * n - 1) / (n * (n + 1))) * surprise;
  if (track.fitted > 1 && interval_s > 0) {
    track.velocity_mps =
        track.velocity_mps + (6 / (n * (n + 1) * interval_s)) * surprise;
    const double speed_mps = geometry::Norm(track.velocity_mps);
    if (speed_mps > kMaxWalkingSpeed_mps) {
      track.velocity_mps =
          (kMaxWalkingSpeed_mps / speed_mps) * track.velocity_mps;
    }
  }
  if (geometry::Norm(track.in_map - track.begun_at) > options_.size_m) {
    track.has_walked = true;
  }
  track.unseen_s = 0;
  track.stands = false;
  ++track.seen;
}

bool DynamicObstacleTracker::Stand(Track& track,
                                   std::span<const TrackedScan> looks) const {
  if (!track.has_walked) return false;
  Cluster there;
  for (const TrackedScan& look : looks) {
    for (const ObservedPoint& point : look.points) {
      if (!point.is_new || point.is_moving ||
          geometry::Norm(point.in_map - track.in_map) > options_.size_m) {
        continue;
      }
      there.sum = there.sum + point.in_map;
      ++there.points;
    }
  }
  if (there.points == 0) return false;
  track.in_map = there.Middle();
  track.velocity_mps = {};
  track.fitted = 0;
  track.unseen_s = 0;
  track.stands = true;
  return true;
}

DynamicObstacleTracker::Cluster* DynamicObstacleTracker::Find(
    const Track& track, std::span<Cluster> clusters) const {
  Cluster* best = nullptr;
  double best_m = 0;
  for (Cluster& cluster : clusters) {
    const geometry::Vec2 middle = cluster.Middle();
    const double off_m = geometry::Norm(middle - track.in_map);
    if (cluster.is_taken || (best != nullptr && off_m >= best_m)) continue;
    if (off_m < options_.reach_m ||
        (track.unseen_s > 0 &&
         hidden_.MayBeNear(track.who, middle, options_.size_m))) {
      best = &cluster;
      best_m = off_m;
    }
  }
  return best;
}

void DynamicObstacleTracker::Match(std::span<const TrackedScan> looks,
                                   std::span<Cluster> clusters,
                                   double interval_s) {
  // Whoever was seen last is sought first: a cluster is his rather than that of
  // one who may be anywhere.
  std::ranges::stable_sort(tracks_, {}, &Track::unseen_s);
  std::vector<geometry::Vec2> standing;
  for (Track& track : tracks_) {
    track.in_map = track.in_map + interval_s * track.velocity_mps;
    Cluster* const found = Find(track, clusters);
    if (found == nullptr) {
      const bool is_other =
          std::ranges::any_of(standing, [&](geometry::Vec2 in_map) {
            return geometry::Norm(in_map - track.in_map) < options_.size_m;
          });
      if (!is_other && Stand(track, looks)) {
        standing.push_back(track.in_map);
        hidden_.Put(track.who, track.in_map, options_.body_m);
      } else {
        track.unseen_s += interval_s;
      }
      continue;
    }
    found->is_taken = true;
    const geometry::Vec2 middle = found->Middle();
    // Of what is cut off by the edge of the view, the middle is not seen.
    if (track.fitted > options_.fitted_scans / 2 && IsCut(looks, middle)) {
      track.unseen_s = 0;
    } else {
      Follow(track, middle, interval_s);
    }
    hidden_.Put(track.who, middle, options_.body_m);
  }
}

// Clusters beside one that is followed are its own.
void DynamicObstacleTracker::Begin(std::span<const Cluster> clusters) {
  for (const Cluster& cluster : clusters) {
    if (cluster.is_taken) continue;
    const geometry::Vec2 middle = cluster.Middle();
    const bool is_known = std::ranges::any_of(clusters, [&](const Cluster& of) {
      return of.is_taken &&
             geometry::Norm(of.Middle() - middle) < options_.body_m;
    });
    if (is_known) continue;
    const std::optional<int> who = hidden_.Take();
    if (!who.has_value()) return;
    hidden_.Put(*who, middle, options_.body_m);
    tracks_.push_back({.who = *who,
                       .begun_at = middle,
                       .in_map = middle,
                       .velocity_mps = {},
                       .seen = 1,
                       .fitted = 1});
  }
}

void DynamicObstacleTracker::Forget() {
  std::erase_if(tracks_, [&](const Track& track) {
    const auto is_lost = [&] {
      const double area_m2 = hidden_.Area_m2(track.who);
      return area_m2 == 0 || area_m2 > options_.lost_area_m2;
    };
    const bool has_gone = track.unseen_s > options_.memory_s ||
                          (track.unseen_s > 0 &&
                           (track.seen < options_.scans_to_begin || is_lost()));
    if (has_gone) hidden_.Give(track.who);
    return has_gone;
  });
}

void DynamicObstacleTracker::AddLooks(base::MonotonicTime stamp,
                                      std::span<const TrackedScan> looks,
                                      const HiddenPlaces::IsSolid& is_solid) {
  const double interval_s =
      last_.has_value() ? std::chrono::duration<double>(stamp - *last_).count()
                        : 0;
  last_ = stamp;
  if (interval_s < 0 || interval_s > kLongestInterval_s) Clear();
  if (looks.empty()) return;
  const geometry::Vec3& at = looks.front().map_from_laser.translation;
  hidden_.Spread({at.x, at.y}, interval_s, is_solid);
  std::vector<Cluster> clusters = ClustersOf(looks);
  Match(looks, clusters, interval_s);
  Begin(clusters);
  hidden_.LookThrough(looks);
  Forget();
  for (const Track& track : tracks_) {
    if (track.unseen_s == 0 && !track.stands &&
        track.seen >= options_.scans_to_begin) {
      last_seen_ = stamp;
    }
  }
}

std::vector<DynamicObstacle> DynamicObstacleTracker::DynamicObstacles() const {
  std::vector<DynamicObstacle> movers;
  for (const Track& track : tracks_) {
    if (track.seen < options_.scans_to_begin) continue;
    movers.push_back({.in_map = track.in_map,
                      .velocity_mps = track.velocity_mps,
                      .unseen_s = track.unseen_s});
  }
  return movers;
}

std::vector<geometry::Vec2> DynamicObstacleTracker::Hidden() const {
  uint32_t who = 0;
  for (const Track& track : tracks_) {
    if (track.seen >= options_.scans_to_begin) who |= uint32_t{1} << track.who;
  }
  return hidden_.PlacesOf(who);
}

}  // namespace treeline::control
