#include "nav_agent/mapping/scan_neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace treeline::mapping {
namespace {

// What is seen after a turn of a radian has changed as much as so far on (m).
constexpr double kTurnAsWay_m = 1;
// Of those before a scan, so many back; of each other pass, so many that are so
// far from each other, and so many of all.
constexpr std::array<int, 6> kBack = {1, 2, 3, 5, 8, 12};
constexpr int kOfPass = 2;
constexpr int kApart = 4;
constexpr size_t kOfOtherPasses = 6;
// Numbers of the scans nearest to a place are so far from each other.
constexpr int kApartNearby = 2;

// How far apart, and which.
using Near = std::pair<double, int>;

double Apart_m(const geometry::Rigid2& a, const geometry::Rigid2& b) {
  return geometry::Norm(a.translation - b.translation) +
         kTurnAsWay_m *
             std::abs(geometry::NormalizedAngle_rad(a.yaw_rad - b.yaw_rad));
}

// The nearest, whose numbers differ by at least `apart`.
std::vector<Near> Spread(std::vector<Near> near, size_t count, int apart) {
  std::sort(near.begin(), near.end());
  std::vector<Near> spread;
  for (const Near& one : near) {
    if (spread.size() >= count) break;
    const bool is_beside =
        std::any_of(spread.begin(), spread.end(), [&](const Near& other) {
          return std::abs(other.second - one.second) < apart;
        });
    if (!is_beside) spread.push_back(one);
  }
  return spread;
}

// Of passes before scan i, those nearest to it.
std::vector<Near> OfOtherPasses(const ScanWay& way, size_t i, double max_m) {
  std::vector<Near> found;
  std::vector<Near> pass;
  const auto end_pass = [&] {
    for (const Near& near : Spread(pass, kOfPass, kApart)) {
      found.push_back(near);
    }
    pass.clear();
  };
  for (size_t k = 0; k < i; ++k) {
    // The same pass is as near by its way.
    if (way.way_m[i] - way.way_m[k] < 2 * max_m) break;
    const double apart_m =
        Apart_m(way.map_from_scans[i], way.map_from_scans[k]);
    if (apart_m > max_m ||
        !way.may_be_compared(static_cast<int>(i), static_cast<int>(k))) {
      end_pass();
      continue;
    }
    pass.emplace_back(apart_m, static_cast<int>(k));
  }
  end_pass();
  std::sort(found.begin(), found.end());
  if (found.size() > kOfOtherPasses) found.resize(kOfOtherPasses);
  return found;
}

}  // namespace

std::vector<ScanPair> PairsOfOtherPasses(const ScanWay& way, double max_m,
                                         double min_way_m, int every,
                                         int count) {
  std::vector<ScanPair> pairs;
  std::vector<Near> near;
  for (size_t i = 0; i < way.map_from_scans.size();
       i += static_cast<size_t>(every)) {
    near.clear();
    for (size_t k = 0; k < i; ++k) {
      if (way.way_m[i] - way.way_m[k] < min_way_m) break;
      const double apart_m = geometry::Norm(way.map_from_scans[i].translation -
                                            way.map_from_scans[k].translation);
      if (apart_m > max_m ||
          !way.may_be_compared(static_cast<int>(i), static_cast<int>(k))) {
        continue;
      }
      near.emplace_back(apart_m, static_cast<int>(k));
    }
    for (const Near& one : Spread(near, static_cast<size_t>(count), 1)) {
      pairs.push_back({.a = static_cast<int>(i), .b = one.second});
    }
  }
  return pairs;
}

std::vector<ScanPair> PairsThatOverlap(const ScanWay& way, double max_m) {
  std::vector<ScanPair> pairs;
  for (size_t i = 1; i < way.map_from_scans.size(); ++i) {
    const int number = static_cast<int>(i);
    for (const Near& near : OfOtherPasses(way, i, max_m)) {
      pairs.push_back({.a = near.second, .b = number});
    }
    for (const int back : kBack) {
      const int before = number - back;
      if (before < 0) continue;
      if (way.may_be_compared(number, before)) {
        pairs.push_back({.a = before, .b = number});
      } else if (way.untold_between) {
        const std::optional<geometry::Vec2> untold =
            way.untold_between(number, before);
        if (untold.has_value()) {
          pairs.push_back({.a = before, .b = number, .untold = *untold});
        }
      }
    }
  }
  return pairs;
}

std::vector<size_t> NearestScans(
    std::span<const geometry::Rigid2> map_from_scans,
    const geometry::Rigid2& map_from_here, double max_m, size_t count) {
  std::vector<Near> near;
  for (size_t i = 0; i < map_from_scans.size(); ++i) {
    const geometry::Vec2 d =
        map_from_scans[i].translation - map_from_here.translation;
    if (std::abs(d.x) > max_m || std::abs(d.y) > max_m) continue;
    const double apart_m = Apart_m(map_from_scans[i], map_from_here);
    if (apart_m <= max_m) near.emplace_back(apart_m, static_cast<int>(i));
  }
  std::vector<size_t> nearest;
  for (const Near& one : Spread(std::move(near), count, kApartNearby)) {
    nearest.push_back(static_cast<size_t>(one.second));
  }
  return nearest;
}

}  // namespace treeline::mapping
