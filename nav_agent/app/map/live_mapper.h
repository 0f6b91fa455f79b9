// Mapping while somebody drives: what the sensors say is recorded, followed,
// and drawn.
#ifndef NAV_AGENT_APP_MAP_LIVE_MAPPER_H_
#define NAV_AGENT_APP_MAP_LIVE_MAPPER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/image/image.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/mapping/online_mapper.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {

// The devices must outlive who uses them. camera: null if there is none.
struct LiveSensors {
  core::RangeSensor& laser;
  core::Odometry& odometry;
  core::RgbdCamera* camera = nullptr;
  core::RobotModel robot;
  // Of what is followed; what is recorded is as it comes.
  core::SensorCorrection correction = {};
};

class LiveQuestions;
class LiveScene;

struct LiveMapOptions {
  // Where the agent log is written; there must be none yet.
  std::string log_path;
  // Redrawn now and then; empty: none.
  std::string picture_path;
  double picture_every_s = 2;
  // Frames that are nearer in time to the last one are not recorded (s).
  double frame_interval_s = 0.1;
  int jpeg_quality = 92;
  mapping::RecordingMapOptions drive;
  // Is handed the frames that are recorded; null: nobody.
  LiveScene* scene = nullptr;
  // Asks a server where the robot is when it was carried off; null: nobody.
  LiveQuestions* questions = nullptr;
};

struct LiveMapStatus {
  int64_t scans = 0;
  int64_t frames = 0;
  int64_t log_bytes = 0;
  // Where the robot is; nullopt until a scan has found its place, and while
  // nobody knows.
  std::optional<dataset::TimedPose> map_from_base;
  // It was carried off, and has not been found yet.
  bool is_lost = false;
  // Which sensors are silent, and why; empty: none.
  std::string silent;
};

// Records first, so that nothing that happens afterwards loses anything. Not
// thread-safe.
class LiveMapper {
 public:
  // clock: real time; it says when to flush and to draw. ALREADY_EXISTS: the
  // log.
  static absl::StatusOr<std::unique_ptr<LiveMapper>> Create(
      const LiveSensors& sensors, const LiveMapOptions& options,
      const base::Clock& clock);

  // Takes what has arrived. To be called every 50 ms or so. A sensor that is
  // lost is told by Status(), and is no error; a log that cannot be written is.
  absl::Status Poll();
  LiveMapStatus Status() const;
  // Hands the rest of the log to the system, and draws once more.
  absl::Status Finish();

 private:
  LiveMapper(const LiveSensors& sensors, const LiveMapOptions& options,
             const base::Clock& clock,
             std::unique_ptr<recording::AgentLogWriter> log);
  absl::Status TakeScans();
  absl::Status TakeFrames();
  // Lets a lost robot be asked about.
  void Ask(core::RgbdFrame frame);
  absl::Status Draw();

  const LiveSensors sensors_;
  const LiveMapOptions options_;
  const base::Clock* clock_;
  std::unique_ptr<recording::AgentLogWriter> log_;
  // There is one once the laser has told what it is.
  std::unique_ptr<mapping::OnlineMapper> mapper_;
  std::optional<core::RangeSensorInfo> laser_;
  std::optional<camera::RgbdCalibration> camera_;
  std::optional<base::MonotonicTime> last_frame_;
  base::MonotonicTime next_picture_;
  base::MonotonicTime next_follow_;
  int64_t frames_ = 0;
};

// A plan of the floor that the robot is on, with the robot as a red cross.
// North (+y) is up.
image::ColorImage DrawLiveMap(
    const mapping::FloorGrid& floor,
    const std::optional<dataset::TimedPose>& map_from_base);

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_LIVE_MAPPER_H_
