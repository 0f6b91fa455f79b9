// Speeds along a track: as fast as limits allow.
#ifndef NAV_AGENT_CONTROL_SPEED_PROFILE_H_
#define NAV_AGENT_CONTROL_SPEED_PROFILE_H_

#include <span>
#include <vector>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/regulator_switches.h"
#include "nav_agent/control/track_point.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

struct SpeedProfileOptions {
  // The robot's own limit holds beside this.
  double max_forward_mps = kMaxForward_mps;
  SpeedRegulatorSwitches switches;
};

// Lengths from a track's first point to each (m).
std::vector<double> AlongTrack(std::span<const TrackPoint> track);
// The point wanted_m along a track that is not empty; its last beyond its end.
geometry::Vec2 PointAt(std::span<const TrackPoint> track,
                       std::span<const double> along_m, double wanted_m);

// Speeds (m/s) at each point of a track that begins at the robot, from the
// lesser of max_forward_mps and the robot's own, by these regulators in this
// order:
//
//   1. ClearanceRegulator  slower beside obstacles
//   2. CurvatureRegulator  as fast as it can turn along the line
//   3. CornerRegulator     at a creep to where it will turn on the spot
//   4. SlopeRegulator      slower on slopes
//   5. ZoneRegulator       no faster than speed zones allow
//   6. BrakingRegulator    from the last point, where it is at most end_mps,
//                          backwards: in time for each point ahead
//
// The profile is time-optimal backwards; forwards the base's own limits rule
// (AccelerationRegulator).
std::vector<double> SpeedProfile(std::span<const TrackPoint> track,
                                 double end_mps, const core::RobotModel& robot,
                                 const SpeedProfileOptions& options);

// The same for one more point, which nothing follows: 2. alone. For the arc
// onto a track.
double SpeedOnArc_mps(double speed_mps, double curvature_per_m,
                      const core::RobotModel& robot,
                      const SpeedProfileOptions& options);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SPEED_PROFILE_H_
