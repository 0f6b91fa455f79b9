#include "nav_agent/mapping/scan_outline.h"

#include <algorithm>
#include <cmath>

namespace treeline::mapping {
namespace {

// Returns on either side of one, by which it is told how dense they are.
constexpr size_t kAround = 3;

// Whether one surface explains both returns: a and b from the origin, ranges
// and angle between the beams known.
bool OnOneSurface(geometry::Vec2 a, geometry::Vec2 b, double nearer_m,
                  double increment_rad, const ScanOutlineOptions& options) {
  const double gap_m = geometry::Norm(b - a);
  if (gap_m > options.max_join_m) return false;
  // Beams increment apart that hit a surface at an angle g are
  // r * increment / sin(g) apart on it.
  return nearer_m * increment_rad >=
         gap_m * std::sin(options.min_incidence_rad);
}

// Whether a return lies between those of its neighbours, nearer than one and
// farther than the other, with a surface to neither: it met a surface almost
// along it, or two at once. Where along the beam it lies means little.
bool IsInBetween(std::span<const float> ranges_m, int beam,
                 const core::RangeSensorInfo& laser,
                 const ScanOutlineOptions& options) {
  if (beam < 1 || beam + 1 >= static_cast<int>(ranges_m.size())) return false;
  const double angle_rad = std::abs(laser.angle_increment_rad);
  const double here_m = ranges_m[static_cast<size_t>(beam)];
  const auto at = [](double range_m, double angle) {
    return geometry::Vec2{range_m * std::cos(angle), range_m * std::sin(angle)};
  };
  int farther = 0;
  for (const int side : {-1, 1}) {
    const double other_m = ranges_m[static_cast<size_t>(beam + side)];
    if (std::isfinite(other_m) &&
        OnOneSurface(at(here_m, 0), at(other_m, angle_rad),
                     std::min(here_m, other_m), angle_rad, options)) {
      return false;
    }
    if (!(other_m <= here_m)) ++farther;
  }
  return farther == 1;
}

struct Return {
  geometry::Vec2 at;
  bool joins = false;  // the one before it, as one surface
};

std::vector<Return> ReturnsOf(std::span<const float> ranges_m,
                              const core::RangeSensorInfo& laser,
                              const geometry::Rigid3& level_from_laser,
                              const ScanOutlineOptions& options,
                              const geometry::Rigid2& first_from_last) {
  const bool moves = first_from_last != geometry::Rigid2{};
  const double per_beam = 1.0 / std::max<double>(1, laser.beams - 1);
  std::vector<Return> returns;
  int last_beam = -2;
  double last_range_m = 0;
  for (int beam = 0; beam < static_cast<int>(ranges_m.size()); ++beam) {
    const double range_m = ranges_m[static_cast<size_t>(beam)];
    if (!std::isfinite(range_m) || range_m <= laser.range_min_m ||
        range_m > options.max_range_m ||
        (laser.range_max_m > 0 && range_m >= laser.range_max_m) ||
        IsInBetween(ranges_m, beam, laser, options)) {
      continue;
    }
    const double angle_rad = laser.AngleOf_rad(beam);
    const geometry::Vec3 point =
        level_from_laser * geometry::Vec3{range_m * std::cos(angle_rad),
                                          range_m * std::sin(angle_rad), 0};
    if (point.z < options.min_height_m || point.z > options.max_height_m) {
      continue;
    }
    geometry::Vec2 here = {point.x, point.y};
    if (moves) {
      const double part = beam * per_beam;
      const geometry::Rigid2 first_from_now = {
          .translation = part * first_from_last.translation,
          .yaw_rad = part * first_from_last.yaw_rad};
      here = first_from_now * here;
    }
    const bool joins =
        beam == last_beam + 1 &&
        OnOneSurface(returns.back().at, here, std::min(last_range_m, range_m),
                     std::abs(laser.angle_increment_rad), options);
    returns.push_back({.at = here, .joins = joins});
    last_beam = beam;
    last_range_m = range_m;
  }
  return returns;
}

// How many of the returns begin, ..., end - 1, which are of one surface, are
// spacing_m of it: by those around, since to stop at the first that is far
// enough prefers those whose noise took them on along the surface, and bends
// what is seen on a slant.
size_t GroupSize(std::span<const Return> surface, size_t begin,
                 double spacing_m) {
  const size_t from = begin - std::min(begin, kAround);
  const size_t to = std::min(begin + kAround, surface.size() - 1);
  const double apart_m = geometry::Norm(surface[to].at - surface[from].at);
  const auto steps = static_cast<double>(to - from);
  const size_t left = surface.size() - begin;
  if (apart_m * static_cast<double>(left) <= spacing_m * steps) return left;
  return std::clamp<size_t>(
      static_cast<size_t>(std::ceil(spacing_m * steps / apart_m)), 1, left);
}

void AddSurface(std::span<const Return> surface, double spacing_m,
                ScanOutline* scan) {
  for (size_t begin = 0; begin < surface.size();) {
    const size_t count = GroupSize(surface, begin, spacing_m);
    geometry::Vec2 sum;
    for (const Return& one : surface.subspan(begin, count)) sum = sum + one.at;
    scan->points_m.push_back((1.0 / static_cast<double>(count)) * sum);
    begin += count;
    scan->joined.push_back(begin < surface.size() ? 1 : 0);
  }
}

}  // namespace

absl::Status ScanOutlineOptions::Validate() const {
  if (!(max_range_m > 0) || !(spacing_m >= 0) || !(max_join_m >= 0) ||
      !(min_incidence_rad >= 0) || !(min_incidence_rad < 1.57) ||
      !(max_height_m > min_height_m)) {
    return absl::InvalidArgumentError(
        "scan points: lengths must be 0 or more, max_range_m above 0, "
        "min_incidence_rad from 0 to 1.57, max_height_m above min_height_m");
  }
  return absl::OkStatus();
}

ScanOutline MakeScanOutline(std::span<const float> ranges_m,
                            const core::RangeSensorInfo& laser,
                            const geometry::Rigid3& level_from_laser,
                            const ScanOutlineOptions& options,
                            const geometry::Rigid2& first_from_last) {
  ScanOutline scan;
  scan.seen_from = {level_from_laser.translation.x,
                    level_from_laser.translation.y};
  const std::vector<Return> returns =
      ReturnsOf(ranges_m, laser, level_from_laser, options, first_from_last);
  const std::span<const Return> all(returns);
  for (size_t begin = 0; begin < all.size();) {
    size_t end = begin + 1;
    while (end < all.size() && all[end].joins) ++end;
    AddSurface(all.subspan(begin, end - begin), options.spacing_m, &scan);
    begin = end;
  }
  return scan;
}

ScanOutline Thinned(const ScanOutline& scan, size_t every) {
  ScanOutline thinned;
  for (size_t i = 0; i < scan.size(); i += every) {
    thinned.points_m.push_back(scan.points_m[i]);
    thinned.joined.push_back(0);
  }
  return thinned;
}

}  // namespace treeline::mapping
