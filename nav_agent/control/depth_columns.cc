#include "nav_agent/control/depth_columns.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {
namespace {

// Between heights that are projected, what lies between is interpolated (m).
constexpr double kHeightStep_m = 0.1;

}  // namespace

DepthColumns::DepthColumns(const ControlPose& pose,
                           const core::RgbdFrame& frame,
                           const core::RobotModel& robot)
    : frame_(frame),
      laser_height_m_(robot.base_from_laser.translation.z),
      robot_height_m_(robot.height_m) {
  const camera::RgbdCalibration& calibration = *frame.frame.calibration;
  const geometry::Rigid3 map_from_depth =
      MapFromBase3(pose) *
      camera::PoseOfSensor(robot.base_from_camera, calibration.pose_sensor,
                           camera::RgbdSensor::kDepth, calibration);
  depth_from_map_ = map_from_depth.Inverse();
  camera_height_m_ = map_from_depth.translation.z;
}

DepthColumns::Place DepthColumns::PlaceOf(const ThingColumn& column,
                                          double above_ground_m) const {
  const image::DepthImage& depth = *frame_.frame.depth;
  const geometry::Vec3 point =
      depth_from_map_ * geometry::Vec3{column.center_in_map.x,
                                       column.center_in_map.y,
                                       column.ground_m + above_ground_m};
  if (point.z < kGroundTolerance_m || point.z > kDepthRange_m) return {};
  const camera::Pixel pixel = frame_.frame.calibration->depth.Project(point);
  const bool is_inside = pixel.x >= 0 && pixel.y >= 0 &&
                         pixel.x <= depth.width - 1 &&
                         pixel.y <= depth.height - 1;
  return {
      .u_px = pixel.x, .v_px = pixel.y, .z_m = point.z, .is_inside = is_inside};
}

DepthColumns::Row DepthColumns::RowAt(const Place& place,
                                      const ThingColumn& column) const {
  const image::DepthImage& depth = *frame_.frame.depth;
  const camera::RgbdCalibration& calibration = *frame_.frame.calibration;
  const double half_px =
      column.half_width_m * calibration.depth.fx() / place.z_m;
  const int begin = std::max(0, static_cast<int>(place.u_px - half_px));
  const int end =
      std::min(depth.width - 1, static_cast<int>(place.u_px + half_px) + 1);
  const auto row = static_cast<size_t>(std::lround(place.v_px)) *
                   static_cast<size_t>(depth.width);
  Row seen = {.lowest_m = std::numeric_limits<double>::infinity(),
              .highest_m = -std::numeric_limits<double>::infinity()};
  for (int x = begin; x <= end; ++x) {
    const uint16_t value = depth.values[row + static_cast<size_t>(x)];
    if (!image::IsMeasured(value)) continue;
    const double z_m = value * depth.unit_m * calibration.depth_scale;
    seen.is_measured = true;
    seen.is_nearer = seen.is_nearer || z_m < place.z_m - kThingDepth_m;
    seen.is_met =
        seen.is_met || std::abs(z_m - place.z_m) <= kThingDepth_m.value;
    // Of a place on the ground: along its ray.
    const double above_m =
        (camera_height_m_ - column.ground_m) * (1 - z_m / place.z_m);
    seen.lowest_m = std::min(seen.lowest_m, above_m);
    seen.highest_m = std::max(seen.highest_m, above_m);
  }
  return seen;
}

ColumnSight DepthColumns::LookAtFoot(const ThingColumn& column) const {
  const Place foot = PlaceOf(column, 0);
  if (!foot.is_inside) return ColumnSight::kUnknown;
  const Row row = RowAt(foot, column);
  if (!row.is_measured || row.is_nearer) return ColumnSight::kUnknown;
  return row.lowest_m >= -kFloorScatter_m && row.highest_m <= kFloorScatter_m
             ? ColumnSight::kThrough
             : ColumnSight::kMet;
}

ColumnSight DepthColumns::Look(const ThingColumn& column,
                               double beyond_m) const {
  ColumnSight sight = LookAtFoot(column);
  if (sight == ColumnSight::kMet) return sight;
  Place below = PlaceOf(column, kGroundTolerance_m);
  double height_m = kGroundTolerance_m;
  while (height_m < robot_height_m_) {
    const double next_m = std::min(height_m + kHeightStep_m, robot_height_m_);
    const Place above = PlaceOf(column, next_m);
    const bool may_lack =
        height_m >= laser_height_m_ && beyond_m > kDepthHoles_m;
    height_m = next_m;
    if (!below.is_inside || !above.is_inside) {
      sight = ColumnSight::kUnknown;
      below = above;
      continue;
    }
    const int rows =
        1 + static_cast<int>(std::abs(above.v_px - below.v_px) + 0.5);
    for (int i = 0; i <= rows; ++i) {
      const double part = static_cast<double>(i) / rows;
      const Place place = {
          .u_px = below.u_px + part * (above.u_px - below.u_px),
          .v_px = below.v_px + part * (above.v_px - below.v_px),
          .z_m = below.z_m + part * (above.z_m - below.z_m),
          .is_inside = true};
      const Row row = RowAt(place, column);
      if (row.is_met) return ColumnSight::kMet;
      if (row.is_nearer || (!row.is_measured && !may_lack)) {
        sight = ColumnSight::kUnknown;
      }
    }
    below = above;
  }
  return sight;
}

}  // namespace treeline::control
