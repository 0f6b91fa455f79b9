#include "nav_agent/control/pursuit_regulator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/turn_rate.h"

namespace treeline::control {

void PursuitRegulator::Regulate(const RegulatorInput& input,
                                RegulatedVelocity& regulated) {
  if (regulated.is_near_goal) return;
  regulated.velocity = Command(input.pose, input.track);
}

core::VelocityCommand PursuitRegulator::Command(
    const ControlPose& pose, std::span<const TrackPoint> track) {
  if (track.size() < 2) return {};
  const double look_ahead_m =
      kLookAheadBase_m + kLookAheadTime_s * std::max(0.0, pose.forward_mps);
  const geometry::Vec2 target = pose.pose.map_from_base.Inverse() *
                                PointAt(track, AlongTrack(track), look_ahead_m);
  const double bearing_rad = std::atan2(target.y, target.x);
  const double off_rad = std::abs(bearing_rad);
  if (off_rad > kTurnFrom_rad) is_turning_ = true;
  if (off_rad < kTurnUntil_rad) is_turning_ = false;
  if (is_turning_) {
    return {.forward_mps = 0,
            .yaw_rate_radps = TurnOnSpotRate_radps(bearing_rad, robot_)};
  }
  const double distance_m = std::max(kCell_m, geometry::Norm(target));
  const double curvature = 2 * target.y / (distance_m * distance_m);
  double speed = SpeedOnArc_mps(SpeedProfile(track, 0, robot_, options_)[0],
                                curvature, robot_, options_);
  speed = std::max(std::min(kCreep_mps, speed),
                   speed * (1 - off_rad / kTurnFrom_rad));
  const double yaw_rate = kYawShare * robot_.max_yaw_rate_radps;
  return {.forward_mps = speed,
          .yaw_rate_radps = std::clamp(speed * curvature, -yaw_rate, yaw_rate)};
}

}  // namespace treeline::control
