// From a recorded drive to a map bundle: laser SLAM says where the robot was,
// its frames and scans what was there (thesis 6.3.1).
#ifndef NAV_AGENT_APP_MAP_MAP_FROM_LOG_H_
#define NAV_AGENT_APP_MAP_MAP_FROM_LOG_H_

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/app/map/map_assembly.h"
#include "nav_agent/mapping/recording_mapper.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::map_app {

// Called now and then with what is being done and how much of it is, 0 to 1.
using PhaseProgress = std::function<void(const char* phase, double part)>;

struct MapLogOptions {
  MapOptions map;
  mapping::RecordingMapOptions drive;
  // Added to the trajectory's times if there are no frames: of a log whose
  // scans are stamped anew, they are then those of the recording.
  recording::RecordingTime::duration scan_delay{};
  PhaseProgress progress;
  std::stop_token stop;
};

struct MapLogResult {
  mapping::RecordingMap drive;
  MapSummary summary;
  // Frames and scans that lie outside of the trajectory, or do not decode.
  int64_t frames_left_out = 0;
  std::vector<std::string> warnings;
  // Root mean square distance of positions from the truth that a simulator
  // wrote, where both begin in the same place (m).
  std::optional<double> rmse_m;
};

// Reads the log twice: for the trajectory, then, if it is an agent log, for
// frames and scans. Without frames the map is planar: what the laser saw. The
// errors of MapRecording and MapAssembly.
absl::StatusOr<MapLogResult> MapLog(const std::string& log,
                                    const MapLogOptions& options);

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_MAP_FROM_LOG_H_
