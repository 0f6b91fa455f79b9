// A recorded drive through laser SLAM, whatever format it is in.
#ifndef NAV_AGENT_MAPPING_RECORDING_MAPPER_H_
#define NAV_AGENT_MAPPING_RECORDING_MAPPER_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/text_formats.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/core/slope_odometry.h"
#include "nav_agent/mapping/grid_mapping.h"
#include "nav_agent/mapping/laser_slam.h"

namespace treeline::mapping {

enum class RecordingFormat : uint8_t {
  kAgentLog,  // docs/reference/agent-log.md
  kLaserLog   // a public log: nav_agent/recording/laser_log.h
};

struct RecordingMapProgress {
  int64_t scans = 0;
  // How much of the recording has been read, 0 to 1.
  double part = 0;
};

struct RecordingMapOptions {
  // slam.synchronous: the result is the same in every run.
  // slam.loops.enabled = false: without loop closing.
  LaserSlamOptions slam;
  // In agent logs, this stands for slam.odometry: they have a gyroscope.
  OdometryNoise odometry_noise = OdometryNoise::WithGyroscope();
  // In agent logs, for slam.notices_carries, for the same reason.
  bool notices_carries = true;
  // Of agent logs; the wheel track is that of the log's robot if it names one.
  core::SlopeOdometryOptions odometry;
  // Of agent logs without a robot.
  core::RobotModel robot;
  // Grids of the floors that were driven on, if has_grids.
  GridMappingOptions grid;
  bool has_grids = true;
  // Called now and then, on the caller's thread; may be empty.
  std::function<void(const RecordingMapProgress&)> progress;
  // Ends the run with CANCELLED.
  std::stop_token stop;

  absl::Status Validate() const;
};

// What a horizontal plane through the laser saw on one floor.
struct FloorGrid {
  // Of the ground that the robot stood on, in the map.
  double height_m = 0;
  int64_t scans = 0;
  core::OccupancyGrid grid;
};

struct RecordingMap {
  RecordingFormat format = RecordingFormat::kAgentLog;
  // Where the robot's base was at the first beam of each scan that was used,
  // with all corrections. The map begins at the first of them, level: x ahead,
  // z up, height 0. `world_from_camera` is map_from_base here. Times ascend and
  // are the log's (ns): of the monotonic clock in an agent log.
  std::vector<dataset::TimedPose> map_from_base;
  // The same from odometry alone (odom_from_base), to compare.
  std::vector<dataset::TimedPose> odom_from_base;

  // What the log holds of these.
  std::string information;
  core::RangeSensorInfo laser;
  geometry::Rigid3 base_from_laser;
  std::optional<core::RobotModel> robot;
  std::optional<camera::RgbdCalibration> calibration;
  // world_from_base, if a simulator wrote the log.
  std::vector<dataset::TimedPose> truth;
  int64_t frames = 0;

  // From the lowest floor upwards: only scans that were taken on level ground
  // are in them, since others do not see a horizontal plane. A log without tilt
  // has one floor.
  std::vector<FloorGrid> floors;

  LaserSlamStatistics statistics;
  // Of the front end's time for each scan (ms), and of everything (s).
  double p50_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
  double total_s = 0;

  // What was left out, and why; a sentence for each kind in `warnings`.
  int64_t refused_scans = 0;
  int64_t refused_readings = 0;
  int64_t damaged_bytes = 0;
  std::vector<std::string> warnings;
};

// Reads an agent log, or what ReadLaserLog knows (the format is found from
// what is in the file), in one pass and maps it. Scans with other numbers of
// beams than the laser, measurements whose clock jumps back and what is damaged
// are left out, counted and named in `warnings`; ranges that are not finite are
// no returns.
//
// The errors of ReadFile and ReadLaserLog; INVALID_ARGUMENT for options;
// FAILED_PRECONDITION if an agent log has no laser scanner, no scans or no
// wheel readings that can be used; CANCELLED.
absl::StatusOr<RecordingMap> MapRecording(
    const std::string& path, const RecordingMapOptions& options = {});

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_RECORDING_MAPPER_H_
