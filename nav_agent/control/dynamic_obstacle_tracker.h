// Who moves about near the robot, and where somebody is who went out of its
// sight.
#ifndef NAV_AGENT_CONTROL_DYNAMIC_OBSTACLE_TRACKER_H_
#define NAV_AGENT_CONTROL_DYNAMIC_OBSTACLE_TRACKER_H_

#include <optional>
#include <span>
#include <vector>

#include "common/base/clock.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/control/hidden_parameters.h"
#include "nav_agent/control/hidden_places.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/tracked_scan.h"

namespace treeline::control {

struct DynamicObstacleTrackerOptions {
  // Points so near to the middle of one are its own, legs of one person for
  // instance (m).
  double size_m = kLegsApart_m;
  // What is so near to the edge of the view is half out of it (m).
  double cut_m = kCutAtEdge_m;
  // It is taken for the one that was expected within this (m).
  double reach_m = kLegReach_m;
  // Place and speed are those of the straight line through its last so many
  // places, roughly: an alpha-beta filter whose gains are those of a least
  // squares fit to all (Benedict and Bordner's growing memory) until there are
  // so many.
  int fitted_scans = kFittedScans;
  // Seen so often, it is there.
  int scans_to_begin = kScansToBegin;
  // What is so near to what is seen of it may be its own as well (m).
  double body_m = kLegReach_m;
  // Out of sight it is forgotten after so long, or when it may be anywhere in
  // so much room (s, m2).
  double lost_area_m2 = kLostArea_m2;
  double memory_s = kHiddenMemory_s;
};

// One that moves, or moved.
struct DynamicObstacle {
  geometry::Vec2 in_map;
  geometry::Vec2 velocity_mps;
  // Since it was seen last; 0: it is seen (s).
  double unseen_s = 0;
};

// What moves in scans of planar lasers, followed from one to the next; where no
// laser looks, behind the robot or behind others, by the places that it can
// have reached there. Who walked and stands is followed, too. Pure;
// deterministic; not thread-safe.
class DynamicObstacleTracker {
 public:
  explicit DynamicObstacleTracker(const DynamicObstacleTrackerOptions& options)
      : options_(options), hidden_({}) {}

  // What the lasers show at `stamp`, each in its newest scan. is_solid: where
  // nobody can be; null: nowhere.
  void AddLooks(base::MonotonicTime stamp, std::span<const TrackedScan> looks,
                const HiddenPlaces::IsSolid& is_solid = nullptr);
  void Clear();

  std::vector<DynamicObstacle> DynamicObstacles() const;
  // Centres of cells that somebody, or a part of him, may be in unseen.
  std::vector<geometry::Vec2> Hidden() const;
  // When one was seen to move last; nullopt: never.
  std::optional<base::MonotonicTime> last_seen() const { return last_seen_; }

 private:
  struct Track {
    // Its number among the hidden places.
    int who = 0;
    geometry::Vec2 begun_at;
    geometry::Vec2 in_map;
    geometry::Vec2 velocity_mps;
    int seen = 0;
    // Of them, those that place and speed rest on.
    int fitted = 0;
    double unseen_s = 0;
    // It has come from somewhere else; and stands.
    bool has_walked = false;
    bool stands = false;
  };
  struct Cluster {
    geometry::Vec2 sum;
    int points = 0;
    bool is_taken = false;
    geometry::Vec2 Middle() const { return (1.0 / points) * sum; }
  };

  std::vector<Cluster> ClustersOf(std::span<const TrackedScan> looks) const;
  // The cluster nearest to where it is expected that may be it; null: none.
  Cluster* Find(const Track& track, std::span<Cluster> clusters) const;
  // Half of what is seen there may be beyond the view.
  bool IsCut(std::span<const TrackedScan> looks, geometry::Vec2 in_map) const;
  void Follow(Track& track, geometry::Vec2 in_map, double interval_s) const;
  // Whether it stands where it was: that is seen, but does not move.
  bool Stand(Track& track, std::span<const TrackedScan> looks) const;
  void Match(std::span<const TrackedScan> looks, std::span<Cluster> clusters,
             double interval_s);
  void Begin(std::span<const Cluster> clusters);
  void Forget();

  DynamicObstacleTrackerOptions options_;
  HiddenPlaces hidden_;
  std::vector<Track> tracks_;
  std::optional<base::MonotonicTime> last_;
  std::optional<base::MonotonicTime> last_seen_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_DYNAMIC_OBSTACLE_TRACKER_H_
