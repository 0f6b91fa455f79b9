// Which scans of a drive may see the same things.
#ifndef NAV_AGENT_MAPPING_SCAN_NEIGHBOURS_H_
#define NAV_AGENT_MAPPING_SCAN_NEIGHBOURS_H_

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"

namespace treeline::mapping {

// Two scans, by number.
struct ScanPair {
  int a = 0;
  int b = 0;
  // A unit vector in the map along which they can't be compared, or 0: surfaces
  // across it tell nothing.
  geometry::Vec2 untold = {};
};

// Scans in the order in which they were taken.
struct ScanWay {
  std::span<const geometry::Rigid2> map_from_scans;
  std::span<const double> way_m;  // travelled until each
  // Whether what two of them see can be compared: not on different floors.
  std::function<bool(int, int)> may_be_compared;
  // Of two that can't, one shortly after the other: along which direction; or
  // that they have nothing in common. Unset: nothing.
  std::function<std::optional<geometry::Vec2>(int, int)> untold_between = {};
};

// Of every `every`-th scan, the `count` nearest earlier ones within max_m that
// were taken at least min_way_m before: other passes of the same place.
std::vector<ScanPair> PairsOfOtherPasses(const ScanWay& way, double max_m,
                                         double min_way_m, int every,
                                         int count);

// For laying all scans upon each other: each with some before it on the way,
// near ones and farther ones, and with the nearest of each other pass within
// max_m, where turns count, too (kTurnAsWay_m).
std::vector<ScanPair> PairsThatOverlap(const ScanWay& way, double max_m);

// The nearest scans to a place, at most `count` within max_m, turns counting as
// above, no two of which were taken one after the other.
std::vector<size_t> NearestScans(
    std::span<const geometry::Rigid2> map_from_scans,
    const geometry::Rigid2& map_from_here, double max_m, size_t count);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_NEIGHBOURS_H_
