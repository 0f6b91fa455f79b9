#include "nav_agent/control/speed_profile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "nav_agent/control/braking_regulator.h"
#include "nav_agent/control/clearance_regulator.h"
#include "nav_agent/control/corner_regulator.h"
#include "nav_agent/control/curvature_regulator.h"
#include "nav_agent/control/slope_regulator.h"
#include "nav_agent/control/speed_regulator.h"
#include "nav_agent/control/zone_regulator.h"

namespace treeline::control {
namespace {

// The angle between the directions before and after a place on the track.
double TurnAt_rad(std::span<const TrackPoint> track,
                  std::span<const double> along_m, double at_m) {
  const double end_m = along_m.back();
  if (at_m < kDirection_m || at_m > end_m - kDirection_m) return 0;
  const geometry::Vec2 here = PointAt(track, along_m, at_m);
  const geometry::Vec2 in = here - PointAt(track, along_m, at_m - kDirection_m);
  const geometry::Vec2 out =
      PointAt(track, along_m, at_m + kDirection_m) - here;
  return std::atan2(geometry::Cross(in, out), geometry::Dot(in, out));
}

CurvatureRegulator CurvatureOf(const core::RobotModel& robot) {
  return {.max_yaw_rate_radps = kYawShare * robot.max_yaw_rate_radps};
}

}  // namespace

std::vector<double> AlongTrack(std::span<const TrackPoint> track) {
  std::vector<double> along_m(track.size(), 0);
  for (size_t i = 1; i < track.size(); ++i) {
    along_m[i] =
        along_m[i - 1] + geometry::Norm(track[i].in_map - track[i - 1].in_map);
  }
  return along_m;
}

geometry::Vec2 PointAt(std::span<const TrackPoint> track,
                       std::span<const double> along_m, double wanted_m) {
  const auto next = std::ranges::lower_bound(along_m, wanted_m);
  if (next == along_m.end()) return track.back().in_map;
  const auto i = static_cast<size_t>(next - along_m.begin());
  if (i == 0) return track.front().in_map;
  const double piece_m = along_m[i] - along_m[i - 1];
  const double part =
      piece_m > 1e-9 ? (wanted_m - along_m[i - 1]) / piece_m : 1.0;
  return track[i - 1].in_map + part * (track[i].in_map - track[i - 1].in_map);
}

std::vector<double> SpeedProfile(std::span<const TrackPoint> track,
                                 double end_mps, const core::RobotModel& robot,
                                 const SpeedProfileOptions& options) {
  std::vector<double> speeds(track.size(), 0);
  if (track.empty()) return speeds;
  const std::vector<double> along_m = AlongTrack(track);
  const SpeedRegulatorSwitches& is_on = options.switches;
  for (size_t i = 0; i < track.size(); ++i) {
    const double turn_rad = std::abs(TurnAt_rad(track, along_m, along_m[i]));
    const ProfilePoint point = {.clearance_m = track[i].clearance_m,
                                .slope_rad = track[i].slope_rad,
                                .turn_rad = turn_rad,
                                .curvature_per_m = turn_rad / kDirection_m,
                                .max_mps = track[i].max_mps};
    double speed_mps = std::min(options.max_forward_mps, robot.max_forward_mps);
    const auto pass = [&](bool is_at_work,
                          const SpeedRegulator auto& regulator) {
      if (is_at_work) speed_mps = regulator.Regulated(speed_mps, point);
    };
    pass(is_on.clearance, ClearanceRegulator());
    pass(is_on.curvature, CurvatureOf(robot));
    pass(is_on.corner, CornerRegulator());
    pass(is_on.slope, SlopeRegulator{.max_slope_rad = robot.max_slope_rad});
    pass(is_on.zone, ZoneRegulator());
    speeds[i] = speed_mps;
  }
  if (!is_on.braking) return speeds;
  const BrakingRegulator braking = {
      .deceleration_mps2 = kAccelerationShare * robot.max_deceleration_mps2};
  speeds.back() = std::min(speeds.back(), end_mps);
  for (size_t i = track.size() - 1; i > 0; --i) {
    speeds[i - 1] = braking.Regulated(speeds[i - 1], speeds[i],
                                      along_m[i] - along_m[i - 1]);
  }
  return speeds;
}

double SpeedOnArc_mps(double speed_mps, double curvature_per_m,
                      const core::RobotModel& robot,
                      const SpeedProfileOptions& options) {
  if (!options.switches.curvature) return speed_mps;
  return CurvatureOf(robot).Regulated(
      speed_mps, {.curvature_per_m = std::abs(curvature_per_m)});
}

}  // namespace treeline::control
