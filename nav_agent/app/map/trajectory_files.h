// Trajectories as files, whoever wrote them.
#ifndef NAV_AGENT_APP_MAP_TRAJECTORY_FILES_H_
#define NAV_AGENT_APP_MAP_TRAJECTORY_FILES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/text_formats.h"

namespace treeline::map_app {

// "time tx ty tz qx qy qz qw" (TUM); a map bundle's folder; the poses that
// stand beside the scans of a public laser log (JSON, CARMEN); or those of a
// recording, 7scenes:DIR or tum:DIR, at FrameTimes. pose_file replaces a
// recording's own (DatasetOptions); empty: none. In order of time, at least
// one.
absl::StatusOr<std::vector<dataset::TimedPose>> ReadTrajectory(
    const std::string& path, const std::string& pose_file = "");

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_TRAJECTORY_FILES_H_
