// From a recording of an RGB-D camera alone to a map bundle (thesis 6.3.1).
#ifndef NAV_AGENT_APP_MAP_MAP_FROM_RGBD_H_
#define NAV_AGENT_APP_MAP_MAP_FROM_RGBD_H_

#include <stop_token>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "nav_agent/app/map/map_assembly.h"
#include "nav_agent/app/map/map_from_log.h"
#include "nav_agent/map_bundle/upright.h"
#include "nav_agent/rgbd_slam/run_rgbd_slam.h"

namespace treeline::map_app {

struct MapRgbdOptions {
  MapOptions map;
  rgbd_slam::RunRgbdSlamOptions slam;
  PhaseProgress progress;
  std::stop_token stop;
};

struct MapRgbdResult {
  rgbd_slam::RgbdSlamResult slam;
  // Where the camera was, in the map: z up, the floor at 0.
  std::vector<dataset::TimedPose> map_from_camera;
  map_bundle::UprightMap upright;
  MapSummary summary;
};

// RGB-D SLAM over the recording; its poses, if it has any, are not looked at.
// The frames whose places are known and that MapOptions keeps become keyframes
// and go into the OctoMap. FAILED_PRECONDITION if no frame was tracked.
absl::StatusOr<MapRgbdResult> MapRgbd(const dataset::Dataset& dataset,
                                      const MapRgbdOptions& options);

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_MAP_FROM_RGBD_H_
