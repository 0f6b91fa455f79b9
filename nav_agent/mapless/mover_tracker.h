// What moves about the robot: seen in scans, followed, and foretold.
#ifndef NAV_AGENT_MAPLESS_MOVER_TRACKER_H_
#define NAV_AGENT_MAPLESS_MOVER_TRACKER_H_

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "common/base/clock.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/mapless/evidence_grid.h"

namespace treeline::mapless {

// A disc that moves evenly.
struct Mover {
  geometry::Vec2 in_map;
  geometry::Vec2 velocity_mps;
  double radius_m = 0;

  geometry::Vec2 After(double seconds) const {
    return in_map + seconds * velocity_mps;
  }
};

// Beams that end beside each other are of one thing, or of several that touch,
// where there is a dent between them; a circle through them says
// where its middle is, whatever side of it is seen and whatever hides a part of
// it. A thing whose middles of the last kFittedScans scans lie on a line that
// is driven along, and which came to where the map had nothing, moves: it is
// cut out of the map (GridBeam::is_on_mover) and foretold along that line.
// control::DynamicObstacleTracker follows people, by their legs, against a map;
// here things have a size, and the map is what was seen a moment ago.
// Deterministic; not thread-safe.
class MoverTracker {
 public:
  // One scan's beams, in the order of their angles; notes those that end on
  // what moves, and takes it out of the map.
  void Add(base::MonotonicTime stamp, std::span<GridBeam> beams,
           EvidenceGrid& map);
  void Clear() { tracks_.clear(); }

  // Where they are at this time.
  std::vector<Mover> MoversAt(base::MonotonicTime now) const;

 private:
  // Beams that end on one thing.
  struct Thing {
    size_t first = 0;
    size_t count = 0;
    geometry::Vec2 center;
    double radius_m = 0;
    // A circle through its points fits them.
    bool is_round = false;
    // Of its points, those where something has stood for long, and where
    // nothing was.
    double old_share = 0;
    double new_share = 0;
  };
  struct Sighting {
    base::MonotonicTime stamp;
    geometry::Vec2 center;
  };
  struct Track {
    std::deque<Sighting> seen;
    // Of the line through them, at `stamp`.
    base::MonotonicTime stamp;
    geometry::Vec2 in_map;
    geometry::Vec2 velocity_mps;
    double radius_m = 0;
    bool moves = false;
  };

  static std::vector<Thing> ThingsIn(std::span<const GridBeam> beams,
                                     const EvidenceGrid& map);
  // Of beams that end beside each other: those that touch and are round and
  // wide, or else all of it as one.
  static void AddThings(std::span<const GridBeam> beams, size_t first,
                        size_t count, const EvidenceGrid& map,
                        std::vector<Thing>& things);
  static std::optional<Thing> ThingOf(std::span<const GridBeam> beams,
                                      size_t first, size_t count,
                                      const EvidenceGrid& map);
  static void Follow(Track& track, const Thing& thing,
                     base::MonotonicTime stamp, EvidenceGrid& map);

  std::vector<Track> tracks_;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_MOVER_TRACKER_H_
