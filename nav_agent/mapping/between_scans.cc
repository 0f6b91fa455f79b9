#include "nav_agent/mapping/between_scans.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "nav_agent/mapping/scan_neighbours.h"
#include "nav_agent/mapping/scan_plane.h"

namespace treeline::mapping {
namespace {

// A scan is laid upon so many keyscans.
constexpr size_t kPartners = 12;

// What is added to a place that was reached after way_m.
struct Offset {
  double way_m = 0;
  geometry::Vec2 m = {};
  double rad = 0;
};

Offset Between(const Offset& a, const Offset& b, double way_m) {
  const double length_m = b.way_m - a.way_m;
  const double part =
      length_m > 0 ? std::clamp((way_m - a.way_m) / length_m, 0.0, 1.0) : 0;
  return {.way_m = way_m,
          .m = (1 - part) * a.m + part * b.m,
          .rad = (1 - part) * a.rad + part * b.rad};
}

Offset OffsetOf(double way_m, const geometry::Rigid2& was,
                const geometry::Rigid2& is) {
  return {.way_m = way_m,
          .m = is.translation - was.translation,
          .rad = geometry::NormalizedAngle_rad(is.yaw_rad - was.yaw_rad)};
}

geometry::Rigid2 Moved(const geometry::Rigid2& pose, const Offset& offset) {
  return {pose.translation + offset.m,
          geometry::NormalizedAngle_rad(pose.yaw_rad + offset.rad)};
}

// What is not known of a scan between two keyscans, by odometry from both.
OdometryDoubt::Sigma SigmaBetween(
    const geometry::Rigid2& motion,
    const std::optional<geometry::Rigid2>& this_from_next,
    const OdometryDoubt& doubt) {
  OdometryDoubt::Sigma sigma = doubt.SigmaOf(motion);
  if (!this_from_next.has_value()) return sigma;
  const OdometryDoubt::Sigma other =
      doubt.SigmaOf(motion.Inverse() * *this_from_next);
  return {.m = 1 / std::hypot(1 / sigma.m, 1 / other.m),
          .rad = 1 / std::hypot(1 / sigma.rad, 1 / other.rad)};
}

// All keyscans, to lay others upon.
class Ground {
 public:
  Ground(std::span<const Keyscan> keyscans, const ScanSurfelOptions& options,
         double max_gap_m, double max_tilt)
      : keyscans_(keyscans), max_gap_m_(max_gap_m), max_tilt_(max_tilt) {
    surfels_.reserve(keyscans.size());
    for (const Keyscan& keyscan : keyscans) {
      surfels_.emplace_back(SurfelsOf(*keyscan.scan, options));
      poses_.push_back(keyscan.map_from_base);
    }
  }

  // Those near to a place that is tied to keyscan k.
  std::vector<PlacedSurfels> Near(size_t k, const geometry::Rigid2& here,
                                  double max_m) const {
    const ScanPlane plane = keyscans_[k].Plane();
    std::vector<PlacedSurfels> near;
    for (const size_t i : NearestScans(poses_, here, max_m, kPartners)) {
      const ScanPlane other = keyscans_[i].Plane();
      if (Gap_m(plane, other) > max_gap_m_ ||
          TiltBetween(plane, other) > max_tilt_) {
        continue;
      }
      near.push_back({.scan = &surfels_[i], .map_from_scan = poses_[i]});
    }
    return near;
  }

 private:
  std::span<const Keyscan> keyscans_;
  const double max_gap_m_;
  const double max_tilt_;
  std::vector<ScanSurfels> surfels_;
  std::vector<geometry::Rigid2> poses_;
};

void AddOffsets(std::span<const Offset> offsets, std::span<ScanPlace> places) {
  size_t at = 0;
  for (ScanPlace& place : places) {
    while (at + 2 < offsets.size() && offsets[at + 1].way_m <= place.way_m) {
      ++at;
    }
    place.keyscan_from_base =
        Moved(place.keyscan_from_base,
              Between(offsets[at], offsets[at + 1], place.way_m));
  }
}

}  // namespace

void BetweenScans::Refine(std::span<Keyscan> keyscans,
                          const OdometryDoubt& doubt, double max_gap_m,
                          double max_tilt, std::span<ScanPlace> places) const {
  const Ground ground(keyscans, options_.surfels, max_gap_m, max_tilt);
  auto scan = scans_.begin();
  size_t end = 0;
  for (size_t begin = 0; begin < places.size(); begin = end) {
    // Of one keyscan.
    const size_t k = places[begin].keyscan;
    for (end = begin + 1; end < places.size(); ++end) {
      if (places[end].keyscan != k) break;
    }
    while (scan != scans_.end() && scan->place < begin) ++scan;
    if (k >= keyscans.size()) continue;
    const geometry::Rigid2& map_from_keyscan = keyscans[k].map_from_base;
    Offset last = {.way_m = places[end - 1].way_m};
    std::optional<geometry::Rigid2> this_from_next;
    if (end < places.size() && k + 1 < keyscans.size() &&
        places[end].keyscan == k + 1 &&
        keyscans[k + 1].previous_from_this.has_value()) {
      Keyscan& next = keyscans[k + 1];
      this_from_next = map_from_keyscan.Inverse() * next.map_from_base;
      last = OffsetOf(places[end].way_m, *next.previous_from_this,
                      *this_from_next);
      next.previous_from_this = this_from_next;
    }
    std::vector<Offset> offsets = {{.way_m = places[begin].way_m}};
    for (; scan != scans_.end() && scan->place < end; ++scan) {
      const ScanPlace& place = places[scan->place];
      const geometry::Rigid2 guess = Moved(
          place.keyscan_from_base, Between(offsets.front(), last, place.way_m));
      const OdometryDoubt::Sigma sigma =
          SigmaBetween(guess, this_from_next, doubt);
      const geometry::Rigid2 map_from_guess = map_from_keyscan * guess;
      const geometry::Rigid2 map_from_scan = AlignWithBundle(
          scan->surfels, ground.Near(k, map_from_guess, options_.overlap_m),
          map_from_guess, sigma.m, sigma.rad, options_);
      offsets.push_back(OffsetOf(place.way_m, place.keyscan_from_base,
                                 map_from_keyscan.Inverse() * map_from_scan));
    }
    offsets.push_back(last);
    AddOffsets(offsets, places.subspan(begin + 1, end - begin - 1));
  }
}

}  // namespace treeline::mapping
