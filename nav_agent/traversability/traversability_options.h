// What a robot may drive on, in numbers.
#ifndef NAV_AGENT_TRAVERSABILITY_TRAVERSABILITY_OPTIONS_H_
#define NAV_AGENT_TRAVERSABILITY_TRAVERSABILITY_OPTIONS_H_

#include "absl/status/status.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::traversability {

struct TraversabilityOptions {
  // Eq. 6.1's theta: ground from this slope on is untraversable (rad), in
  // (0, pi/4].
  double max_slope_rad = 0.28;
  // The highest step that may be driven over (m), in [0, 0.3]. A voxel map
  // cannot tell a step from the rounding of a height below two voxels: rises of
  // one voxel are always let pass (see docs/explanation/traversability.md).
  double max_step_m = 0.02;
  // The robot's height (m), in [0.1, 5]: lower room is occupied.
  double robot_height_m = 1.25;
  // Ground between two steps is no ground if it is narrower (m), in [0, 2]: the
  // treads of stairs, ledges, kerbs.
  double min_ground_width_m = 0.5;
  // A raised surface that nothing joins to the ground is furniture if it is
  // smaller (m^2), and a floor of its own if not; >= 0.
  double min_platform_area_m2 = 4;
  // Steps up to this height belong to stairs and kerbs; what is higher is a
  // wall (m), in [0, 1].
  double max_riser_m = 0.3;
  // Levels that a ramp joins share the ground this far above and below the
  // height where they are cut apart (m), in [0, 0.5].
  double level_overlap_m = 0.25;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;

  static TraversabilityOptions For(const core::RobotModel& robot) {
    TraversabilityOptions options;
    options.max_slope_rad = robot.max_slope_rad;
    options.max_step_m = robot.max_step_m;
    options.robot_height_m = robot.height_m;
    return options;
  }
};

// Eq. 6.2: the gradient alpha (rad) between two layers `layer_distance_m`
// apart (d) whose edges lie `run_voxels` (v) voxels of `resolution_m` (r)
// apart: arctan(d / (r v)). Edges that coincide, v = 0, are a wall or a step:
// 90 degrees.
double LayerGradient_rad(double layer_distance_m, double resolution_m,
                         double run_voxels);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_TRAVERSABILITY_OPTIONS_H_
