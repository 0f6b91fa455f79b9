// Where the cameras were: ground truth against estimates, from above and from
// the side, as SVG text for the evaluation's page.
#ifndef EVALUATION_REPORT_REPORT_TRAJECTORY_H_
#define EVALUATION_REPORT_REPORT_TRAJECTORY_H_

#include <string>
#include <vector>

#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/evaluation.h"

namespace treeline::report {

// Unit vectors of a picture plane's axes, expressed in the world frame.
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

// Steps longer than this start a new line: the recording was elsewhere in
// between. `truths` have ground truth.
double LongStep_m(const std::vector<const accuracy::FrameResult*>& truths);

// The drawing; empty if no frame has ground truth. training_poses
// (world_from_camera) are drawn faintly and may be empty. Estimates that lie
// far outside are left out and counted in a note.
std::string TrajectoryChart(
    const std::vector<accuracy::FrameResult>& results,
    const std::vector<geometry::Rigid3>& training_poses);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_TRAJECTORY_H_
