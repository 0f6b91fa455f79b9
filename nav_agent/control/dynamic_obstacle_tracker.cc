#include "nav_agent/control/dynamic_obstacle_tracker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <utility>

#include "nav_agent/control/driving_parameters.h"

namespace treeline::control {
namespace {

struct Cluster {
  geometry::Vec2 sum;
  int points = 0;
  geometry::Vec2 Middle() const { return (1.0 / points) * sum; }
};

std::vector<Cluster> ClustersOf(std::span<const TrackedScan> looks,
                                double size_m) {
  std::vector<Cluster> clusters;
  const auto add = [&](geometry::Vec2 in_map) {
    auto nearest = std::ranges::find_if(clusters, [&](const Cluster& cluster) {
      return geometry::Norm(cluster.Middle() - in_map) < size_m;
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

}  // namespace

DynamicObstacleTracker::Sight DynamicObstacleTracker::SightIn(
    const TrackedScan& look, geometry::Vec2 in_map) const {
  const core::RangeSensorInfo& laser = look.laser;
  const geometry::Vec3 in_laser =
      look.map_from_laser.Inverse() *
      geometry::Vec3{in_map.x, in_map.y, look.map_from_laser.translation.z};
  const double beam =
      (std::atan2(in_laser.y, in_laser.x) - laser.angle_min_rad) /
      laser.angle_increment_rad;
  if (!(beam >= 0 && beam <= laser.beams - 1)) return Sight::kNot;
  const double away_m = std::hypot(in_laser.x, in_laser.y);
  const float range_m =
      look.scan.ranges_m[static_cast<size_t>(std::lround(beam))];
  if (!(range_m >= laser.range_min_m && range_m > away_m - kInFront_m)) {
    return Sight::kNot;
  }
  const double to_edge_rad =
      laser.angle_increment_rad * std::min(beam, laser.beams - 1 - beam);
  return to_edge_rad * away_m < options_.cut_m ? Sight::kPart : Sight::kFull;
}

DynamicObstacleTracker::Sight DynamicObstacleTracker::SightOf(
    std::span<const TrackedScan> looks, geometry::Vec2 in_map) const {
  Sight best = Sight::kNot;
  for (const TrackedScan& look : looks) {
    best = std::max(best, SightIn(look, in_map));
  }
  return best;
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
  track.unseen_s = 0;
  track.missed = 0;
  ++track.seen;
}

void DynamicObstacleTracker::AddLooks(base::MonotonicTime stamp,
                                      std::span<const TrackedScan> looks) {
  const double interval_s =
      last_.has_value() ? std::chrono::duration<double>(stamp - *last_).count()
                        : 0;
  last_ = stamp;
  if (interval_s < 0 || interval_s > kLongestInterval_s) Clear();
  std::vector<Cluster> clusters = ClustersOf(looks, options_.size_m);
  for (Track& track : tracks_) {
    track.in_map = track.in_map + interval_s * track.velocity_mps;
    const auto nearest =
        std::ranges::min_element(clusters, {}, [&](const Cluster& cluster) {
          return geometry::Norm(cluster.Middle() - track.in_map);
        });
    if (nearest != clusters.end() &&
        geometry::Norm(nearest->Middle() - track.in_map) <
            options_.reach_m +
                options_.position_uncertainty_mps * track.unseen_s) {
      // Of what is cut off by the edge of the view, the middle is not seen.
      if (track.fitted > options_.fitted_scans / 2 &&
          SightOf(looks, nearest->Middle()) == Sight::kPart) {
        track.unseen_s = 0;
      } else {
        Follow(track, nearest->Middle(), interval_s);
      }
      clusters.erase(nearest);
      continue;
    }
    track.unseen_s += interval_s;
    track.missed =
        SightOf(looks, track.in_map) == Sight::kFull ? track.missed + 1 : 0;
  }
  std::erase_if(tracks_, [&](const Track& track) {
    return track.missed >= options_.scans_to_end ||
           track.unseen_s > options_.memory_s ||
           (track.unseen_s > 0 && track.seen < options_.scans_to_begin);
  });
  for (const Track& track : tracks_) {
    if (track.unseen_s == 0 && track.seen >= options_.scans_to_begin) {
      last_seen_ = stamp;
    }
  }
  for (const Cluster& cluster : clusters) {
    tracks_.push_back({.in_map = cluster.Middle(),
                       .velocity_mps = {},
                       .seen = 1,
                       .fitted = 1});
  }
}

std::vector<DynamicObstacle> DynamicObstacleTracker::DynamicObstacles() const {
  std::vector<DynamicObstacle> movers;
  for (const Track& track : tracks_) {
    if (track.seen < options_.scans_to_begin) continue;
    movers.push_back({.in_map = track.in_map,
                      .velocity_mps = track.velocity_mps,
                      .unseen_s = track.unseen_s,
                      .position_uncertainty_m =
                          options_.position_uncertainty_mps * track.unseen_s});
  }
  return movers;
}

}  // namespace treeline::control
