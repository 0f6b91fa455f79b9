// The axes along which a recording's cameras are drawn.
#ifndef EVALUATION_REPORT_VIEW_AXES_H_
#define EVALUATION_REPORT_VIEW_AXES_H_

#include <vector>

#include "common/geometry/rigid3.h"

namespace treeline::report {

// Unit vectors expressed in the world frame.
struct ViewAxes {
  geometry::Vec3 right_in_world;
  geometry::Vec3
      forward_in_world;  // horizontal, where the cameras look on average
  geometry::Vec3 up_in_world;
};

// Axes for cameras held upright on average: up is against the mean of their
// y axes, forward the horizontal part of their mean z axis. Falls back on
// other directions where those vanish. The axes are orthonormal and
// right x forward = up.
ViewAxes AxesOfCameras(const std::vector<geometry::Rigid3>& world_from_camera);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_VIEW_AXES_H_
