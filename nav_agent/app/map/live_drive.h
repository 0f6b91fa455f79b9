// treeline-agent map --live: which sensors, and until when.
#ifndef NAV_AGENT_APP_MAP_LIVE_DRIVE_H_
#define NAV_AGENT_APP_MAP_LIVE_DRIVE_H_

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "nav_agent/app/map/live_mapper.h"

namespace treeline::map_app {

struct LiveMappingOptions {
  // A world for a simulated robot that drives its tour by itself; empty: real
  // sensors.
  std::string simulate;
  // What happens to it meanwhile (simulator::ReadScenario), but for the world
  // and the seed; empty: nothing.
  std::string scenario;
  double speed_mps = 0.5;
  // Simulated seconds in a real one; infinity: as many as can be.
  double pace = 1;
  uint64_t seed = 0;
  // Where real devices are (ParseStreamAddress). camera: "openni" or "none".
  std::string laser;
  std::string base;
  std::string camera = "none";
  // Or a file that names them (ReadHardwareConfig).
  std::string hardware;
  // Or a robot that speaks ROS 2 (ReadRosRobotConfig); its camera is that of
  // this file.
  std::string ros2;
  core::RobotModel robot;
  // Ends the drive; 0: at the end of the tour, or when a stop is requested.
  double seconds = 0;
  LiveMapOptions map;
  // Called about once a second.
  std::function<void(const LiveMapStatus&)> status;

  absl::Status Validate() const;
};

// Records a drive until it ends or `stop` is requested, which is no error.
// INVALID_ARGUMENT for options; FAILED_PRECONDITION for worlds without a tour;
// the errors of the devices and of LiveMapper.
absl::Status RecordLiveDrive(const LiveMappingOptions& options,
                             const std::stop_token& stop);

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_LIVE_DRIVE_H_
