// Speeds along a track: as fast as limits allow.
#ifndef NAV_AGENT_CONTROL_TRACK_FOLLOWER_H_
#define NAV_AGENT_CONTROL_TRACK_FOLLOWER_H_

#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// A point of the line that is driven along.
struct TrackPoint {
  geometry::Vec2 in_map;
  // The free distance of the footprint there (m), and the ground's slope.
  double clearance_m = 1;
  double slope_rad = 0;
};

struct TrackFollowerOptions {
  double max_forward_mps = 0.6;
  // Shares of the robot's accelerations that profiles are made with: the rest
  // is for corrections.
  double acceleration_share = 0.6;
  double yaw_share = 0.7;
  // The line is steered for so far ahead: base + time * speed, within these.
  double look_ahead_base_m = 0.22;
  double look_ahead_s = 0.45;
  double look_ahead_most_m = 0.55;
  // Beside obstacles: speed is at most base + factor * clearance.
  double narrow_mps = 0.15;
  double narrow_per_m = 1.2;
  // If the line leads this far off the heading, the robot turns on the spot,
  // until it is within the other.
  double turn_from_rad = 0.9;
  double turn_until_rad = 0.25;
};

struct FollowState {
  bool is_turning = false;
};

// Speeds (m/s) at each point of a track that begins at the robot: at most
// max_forward, narrow_mps + narrow_per_m * clearance, the yaw rate's limit over
// the curvature; slower on slopes; such that the robot can slow down in time
// for each point ahead and ends at end_mps (the time-optimal profile backwards,
// v^2 = v_end^2 + 2 a s; forwards the base's own limits rule).
std::vector<double> SpeedProfile(std::span<const TrackPoint> track,
                                 double end_mps, const core::RobotModel& robot,
                                 const TrackFollowerOptions& options);

// What to do at a pose near the track's beginning: pure pursuit (Coulter 1992)
// of a point ahead at the profile's speed, or turning on the spot.
core::VelocityCommand FollowTrack(const geometry::Rigid2& map_from_base,
                                  double forward_mps,
                                  std::span<const TrackPoint> track,
                                  double end_mps, const core::RobotModel& robot,
                                  const TrackFollowerOptions& options,
                                  FollowState& state);

// Turning on the spot by an angle, to stand after it: the yaw rate from which
// the robot can brake in time.
double TurnRate_radps(double angle_rad, const core::RobotModel& robot,
                      const TrackFollowerOptions& options);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_TRACK_FOLLOWER_H_
