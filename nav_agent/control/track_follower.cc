#include "nav_agent/control/track_follower.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::control {
namespace {

// A line's direction is that over this length (m).
constexpr double kDirection_m = 0.15;
// The slowest that is driven where there is a way at all (m/s).
constexpr double kCreep_mps = 0.08;
// Within this of its heading a turn is done (rad).
constexpr double kTurned_rad = 0.01;

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

}  // namespace

double TurnRate_radps(double angle_rad, const core::RobotModel& robot,
                      const TrackFollowerOptions& options) {
  const double left_rad = std::abs(angle_rad);
  if (left_rad < kTurned_rad) return 0;
  const double brake = options.yaw_share * options.acceleration_share *
                       robot.max_yaw_acceleration_radps2;
  // Near the end in proportion, so that lateness does not make it swing.
  const double rate =
      std::min({options.yaw_share * robot.max_yaw_rate_radps,
                std::sqrt(2 * brake * left_rad), 4.0 * left_rad});
  return std::copysign(rate, angle_rad);
}

std::vector<double> SpeedProfile(std::span<const TrackPoint> track,
                                 double end_mps, const core::RobotModel& robot,
                                 const TrackFollowerOptions& options) {
  std::vector<double> speeds(track.size(), 0);
  if (track.empty()) return speeds;
  const std::vector<double> along_m = AlongTrack(track);
  const double most_mps =
      std::min(options.max_forward_mps, robot.max_forward_mps);
  const double yaw_rate = options.yaw_share * robot.max_yaw_rate_radps;
  const double brake = options.acceleration_share * robot.max_deceleration_mps2;
  for (size_t i = 0; i < track.size(); ++i) {
    const double turn_rad = std::abs(TurnAt_rad(track, along_m, along_m[i]));
    const double curvature = turn_rad / kDirection_m;
    double speed = std::min(
        most_mps, options.narrow_mps + options.narrow_per_m *
                                           std::max(0.0, track[i].clearance_m));
    if (curvature > 1e-6) speed = std::min(speed, yaw_rate / curvature);
    // Where it will turn on the spot.
    if (turn_rad > options.turn_from_rad) speed = kCreep_mps;
    speed *= 1 - 0.5 * std::clamp(track[i].slope_rad / robot.max_slope_rad, 0.0,
                                  1.0);
    speeds[i] = speed;
  }
  speeds.back() = std::min(speeds.back(), end_mps);
  for (size_t i = track.size() - 1; i > 0; --i) {
    const double piece_m = along_m[i] - along_m[i - 1];
    speeds[i - 1] = std::min(
        speeds[i - 1], std::sqrt(speeds[i] * speeds[i] + 2 * brake * piece_m));
  }
  return speeds;
}

core::VelocityCommand FollowTrack(const geometry::Rigid2& map_from_base,
                                  double forward_mps,
                                  std::span<const TrackPoint> track,
                                  double end_mps, const core::RobotModel& robot,
                                  const TrackFollowerOptions& options,
                                  FollowState& state) {
  if (track.size() < 2) return {};
  const std::vector<double> along_m = AlongTrack(track);
  const double look_ahead_m =
      std::min(options.look_ahead_most_m,
               options.look_ahead_base_m +
                   options.look_ahead_s * std::max(0.0, forward_mps));
  const geometry::Vec2 target =
      map_from_base.Inverse() * PointAt(track, along_m, look_ahead_m);
  const double bearing_rad = std::atan2(target.y, target.x);
  const double off_rad = std::abs(bearing_rad);
  if (off_rad > options.turn_from_rad) state.is_turning = true;
  if (off_rad < options.turn_until_rad) state.is_turning = false;
  if (state.is_turning) {
    return {.forward_mps = 0,
            .yaw_rate_radps = TurnRate_radps(bearing_rad, robot, options)};
  }
  const std::vector<double> speeds =
      SpeedProfile(track, end_mps, robot, options);
  // What it can reach within the next tenth of a second counts.
  double speed = speeds[0];
  const double distance_m = std::max(0.05, geometry::Norm(target));
  const double curvature = 2 * target.y / (distance_m * distance_m);
  const double yaw_rate = options.yaw_share * robot.max_yaw_rate_radps;
  if (std::abs(curvature) > 1e-6) {
    speed = std::min(speed, yaw_rate / std::abs(curvature));
  }
  speed *= std::max(0.15, 1 - off_rad / options.turn_from_rad);
  return {.forward_mps = speed,
          .yaw_rate_radps = std::clamp(speed * curvature, -yaw_rate, yaw_rate)};
}

}  // namespace treeline::control
