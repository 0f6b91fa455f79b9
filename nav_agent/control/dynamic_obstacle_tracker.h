// Who moves about near the robot, and where somebody is who went out of its
// sight.
#ifndef NAV_AGENT_CONTROL_DYNAMIC_OBSTACLE_TRACKER_H_
#define NAV_AGENT_CONTROL_DYNAMIC_OBSTACLE_TRACKER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/clock.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/control/observed_point.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/core/sensor_data.h"

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
  // Seen so often, it is there; not seen so often where it should be, it is
  // not.
  int scans_to_begin = kScansToBegin;
  int scans_to_end = kScansToEnd;
  // Out of sight it walks on as it did, and every second may be so much further
  // from there (m). After so long it is forgotten (s).
  double position_uncertainty_mps = kPositionUncertainty_mps;
  double memory_s = kRecently_s;
};

// One that moves.
struct DynamicObstacle {
  geometry::Vec2 in_map;
  geometry::Vec2 velocity_mps;
  // Since it was seen last; 0: it is seen (s).
  double unseen_s = 0;
  // How far from in_map its middle may be (m).
  double position_uncertainty_m = 0;
};

// A scan, from where it was taken, and what of it moves (among `points`).
struct TrackedScan {
  core::RangeSensorInfo laser;
  geometry::Rigid3 map_from_laser;
  core::LaserScan scan;
  std::span<const ObservedPoint> points;
};

// What moves in scans of planar lasers, followed from one to the next and on
// where no laser looks: behind the robot, behind others. Pure; deterministic;
// not thread-safe.
class DynamicObstacleTracker {
 public:
  explicit DynamicObstacleTracker(const DynamicObstacleTrackerOptions& options)
      : options_(options) {}

  // What the lasers show at `stamp`, each in its newest scan.
  void AddLooks(base::MonotonicTime stamp, std::span<const TrackedScan> looks);
  void Clear() { tracks_.clear(); }

  std::vector<DynamicObstacle> DynamicObstacles() const;
  // When one was seen last; nullopt: never.
  std::optional<base::MonotonicTime> last_seen() const { return last_seen_; }

 private:
  struct Track {
    geometry::Vec2 in_map;
    geometry::Vec2 velocity_mps;
    int seen = 0;
    // Of them, those that place and speed rest on.
    int fitted = 0;
    // In a row, where it should have been seen.
    int missed = 0;
    double unseen_s = 0;
  };

  // How lasers see what is at a place, the one that sees best.
  enum class Sight : uint8_t {
    kNot = 0,   // it looks elsewhere, or something is in between
    kPart = 1,  // half of it may be beyond the first or the last beam
    kFull = 2
  };
  Sight SightIn(const TrackedScan& look, geometry::Vec2 in_map) const;
  Sight SightOf(std::span<const TrackedScan> looks,
                geometry::Vec2 in_map) const;
  void Follow(Track& track, geometry::Vec2 in_map, double interval_s) const;

  DynamicObstacleTrackerOptions options_;
  std::vector<Track> tracks_;
  std::optional<base::MonotonicTime> last_;
  std::optional<base::MonotonicTime> last_seen_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_DYNAMIC_OBSTACLE_TRACKER_H_
