// A whole recording through laser SLAM.
#ifndef NAV_AGENT_MAPPING_RUN_LASER_SLAM_H_
#define NAV_AGENT_MAPPING_RUN_LASER_SLAM_H_

#include <functional>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/mapping/grid_mapping.h"
#include "nav_agent/mapping/laser_slam.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::mapping {

struct RunLaserSlamOptions {
  LaserSlamOptions slam;
  GridMappingOptions grid;
  // Called after each scan with how many are done; may be empty.
  std::function<void(size_t)> progress;
  // Ends the run with CANCELLED.
  std::stop_token stop;
};

struct LaserSlamResult {
  // One pose for each scan of the log.
  std::vector<TrajectoryPose> trajectory;
  core::OccupancyGrid grid;
  LaserSlamStatistics statistics;
  // Of the front end's time for each scan (ms), and of all (s).
  double p50_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
  double total_s = 0;
};

// With slam.synchronous, the result is a function of the log and the options:
// the same in every run and for any number of threads.
absl::StatusOr<LaserSlamResult> RunLaserSlam(
    const recording::LaserLog& log, const RunLaserSlamOptions& options);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_RUN_LASER_SLAM_H_
