#include "nav_agent/mapping/scan_outline.h"

#include <algorithm>
#include <cmath>

namespace treeline::mapping {
namespace {

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
  const bool moves = first_from_last != geometry::Rigid2{};
  const double per_beam = 1.0 / std::max<double>(1, laser.beams - 1);
  int last_beam = -2;          // of the return before this one
  geometry::Vec2 last_return;  // where it was
  double last_range_m = 0;
  bool surface = false;  // since the last kept point
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
        OnOneSurface(last_return, here, std::min(last_range_m, range_m),
                     std::abs(laser.angle_increment_rad), options);
    surface = (last_beam >= 0) && joins && (surface || !scan.empty());
    last_beam = beam;
    last_return = here;
    last_range_m = range_m;
    if (!scan.empty() && joins && surface &&
        geometry::Norm(here - scan.points_m.back()) < options.spacing_m) {
      continue;
    }
    if (!scan.empty()) scan.joined.back() = surface ? 1 : 0;
    scan.points_m.push_back(here);
    scan.joined.push_back(0);
    surface = true;
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
