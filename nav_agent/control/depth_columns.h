// What a depth picture shows of columns above the ground.
#ifndef NAV_AGENT_CONTROL_DEPTH_COLUMNS_H_
#define NAV_AGENT_CONTROL_DEPTH_COLUMNS_H_

#include "common/geometry/rigid3.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/thing_column.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// Of one frame, which must outlive it and have passed DepthObserver::Check.
class DepthColumns {
 public:
  DepthColumns(const ControlPose& pose, const core::RgbdFrame& frame,
               const core::RobotModel& robot);

  // kThrough: every row of pixels from the column's foot to the robot's height
  // was measured beyond it, and its foot shows the ground at its own height,
  // neither higher nor lower. Rows above the laser's plane may lack where the
  // laser says that what is behind is too far for a depth camera: beyond_m.
  ColumnSight Look(const ThingColumn& column, double beyond_m) const;

 private:
  // Where a point is in the picture.
  struct Place {
    double u_px = 0;
    double v_px = 0;
    double z_m = 0;
    bool is_inside = false;
  };
  Place PlaceOf(const ThingColumn& column, double above_ground_m) const;
  // The row of pixels about a place that the column is wide.
  struct Row {
    bool is_measured = false;
    bool is_nearer = false;
    bool is_met = false;
    // Of what is beyond, the height above the ground, least and most (m).
    double lowest_m = 0;
    double highest_m = 0;
  };
  Row RowAt(const Place& place, const ThingColumn& column) const;
  ColumnSight LookAtFoot(const ThingColumn& column) const;

  const core::RgbdFrame& frame_;
  geometry::Rigid3 depth_from_map_;
  double camera_height_m_ = 0;
  double laser_height_m_ = 0;
  double robot_height_m_ = 0;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_DEPTH_COLUMNS_H_
