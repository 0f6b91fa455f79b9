#include "evaluation/laser_slam/degraded_log.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline::laser_slam {
namespace {

// Of one step between scans, `number` in the log.
geometry::Rigid2 Worse(const geometry::Rigid2& step, size_t number,
                       const Degradation& d) {
  base::Random random(d.seed, number);
  const double way_m = geometry::Norm(step.translation);
  const double turn_rad = std::abs(step.yaw_rad);
  const double way_error_m = d.m_per_m * way_m * random.NextGaussian();
  const double turn_error_rad =
      std::hypot(d.rad_per_rad * turn_rad, d.rad_per_m * way_m) *
      random.NextGaussian();
  geometry::Rigid2 worse = step;
  if (way_m > 0) {
    worse.translation = (1 + way_error_m / way_m) * step.translation;
  }
  worse.yaw_rad =
      d.turn_scale * step.yaw_rad + d.turn_per_m_rad * way_m + turn_error_rad;
  const bool slips =
      d.slip_every_m > 0 && random.NextUnit() < way_m / d.slip_every_m;
  if (slips) {
    worse.translation.x += d.slip_m * random.NextGaussian();
    worse.yaw_rad += d.slip_rad * random.NextGaussian();
  }
  return worse;
}

bool IsKept(size_t number, const Degradation& d) {
  const auto every = static_cast<size_t>(d.every_scan);
  if (number % every != 0) return false;
  if (d.gap_every == 0) return true;
  const size_t kept = number / every;
  const auto period = static_cast<size_t>(d.gap_every + d.gap_scans);
  return kept % period < static_cast<size_t>(d.gap_every);
}

}  // namespace

absl::Status Degradation::Validate() const {
  const bool noise = m_per_m >= 0 && rad_per_rad >= 0 && rad_per_m >= 0 &&
                     slip_every_m >= 0 && slip_m >= 0 && slip_rad >= 0 &&
                     turn_scale > 0 && std::isfinite(turn_per_m_rad);
  if (!noise || every_scan < 1 || every_beam < 1 || gap_every < 0 ||
      gap_scans < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "degradation '", name,
        "': errors must be 0 or more, turn_scale above 0, and every_scan and "
        "every_beam at least 1"));
  }
  return absl::OkStatus();
}

absl::StatusOr<recording::LaserLog> Degraded(const recording::LaserLog& log,
                                             const Degradation& degradation) {
  TL_RETURN_IF_ERROR(degradation.Validate());
  const auto every_beam = static_cast<size_t>(degradation.every_beam);
  recording::LaserLog worse = {.laser = log.laser,
                               .base_from_laser = log.base_from_laser,
                               .scans = {},
                               .odometry = {}};
  worse.laser.angle_increment_rad *= degradation.every_beam;
  worse.laser.beams =
      (log.laser.beams + degradation.every_beam - 1) / degradation.every_beam;
  geometry::Rigid2 odom_from_base;
  for (size_t i = 0; i < log.scans.size(); ++i) {
    const recording::RecordedScan& scan = log.scans[i];
    if (i == 0) {
      odom_from_base = scan.odom_from_base;
    } else {
      const geometry::Rigid2 step =
          log.scans[i - 1].odom_from_base.Inverse() * scan.odom_from_base;
      odom_from_base = odom_from_base * Worse(step, i, degradation);
    }
    if (!IsKept(i, degradation)) continue;
    recording::RecordedScan kept = {
        .stamp = scan.stamp, .odom_from_base = odom_from_base, .ranges_m = {}};
    for (size_t beam = 0; beam < scan.ranges_m.size(); beam += every_beam) {
      kept.ranges_m.push_back(scan.ranges_m[beam]);
    }
    worse.scans.push_back(std::move(kept));
  }
  if (worse.scans.size() < 2 || worse.laser.beams < 2) {
    return absl::InvalidArgumentError(absl::StrCat(
        "degradation '", degradation.name, "' leaves ", worse.scans.size(),
        " scans of ", worse.laser.beams, " beams: there must be two of both"));
  }
  return worse;
}

std::vector<Degradation> StandardDegradations() {
  return {
      {},
      {.name = "noise 5 % of way and turn",
       .m_per_m = 0.05,
       .rad_per_rad = 0.05,
       .rad_per_m = 0.02},
      {.name = "noise 20 %",
       .m_per_m = 0.2,
       .rad_per_rad = 0.2,
       .rad_per_m = 0.1},
      {.name = "noise 40 %",
       .m_per_m = 0.4,
       .rad_per_rad = 0.4,
       .rad_per_m = 0.3},
      {.name = "turns told 25 % too large", .turn_scale = 1.25},
      {.name = "turns told 25 % too small", .turn_scale = 0.75},
      {.name = "slip of 15 deg, 0.2 m each 5 m",
       .slip_every_m = 5,
       .slip_m = 0.2,
       .slip_rad = 0.26},
      {.name = "slip of 30 deg, 0.2 m each 5 m",
       .slip_every_m = 5,
       .slip_m = 0.2,
       .slip_rad = 0.52},
      // Of a track of 0.4 m: one wheel is larger by a twenty-fifth.
      {.name = "wheels of two sizes, 0.1 rad each m", .turn_per_m_rad = 0.1},
      {.name = "every 3rd scan", .every_scan = 3},
      {.name = "every 2nd beam", .every_beam = 2},
      {.name = "10 scans lost after each 40", .gap_every = 40, .gap_scans = 10},
      {.name = "every 3rd scan, noise 20 %",
       .m_per_m = 0.2,
       .rad_per_rad = 0.2,
       .rad_per_m = 0.1,
       .every_scan = 3},
  };
}

}  // namespace treeline::laser_slam
