// The place's scene, learnt by `treeline learn --live` while the robot maps.
#ifndef NAV_AGENT_APP_MAP_LIVE_SCENE_H_
#define NAV_AGENT_APP_MAP_LIVE_SCENE_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/child_process.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/text_formats.h"
#include "nav_agent/app/map/map_assembly.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {

struct LiveSceneOptions {
  // `treeline`; empty: beside this program, or as the shell finds it.
  std::string learner;
  // The server's folder of models, and the scene in it.
  std::string repository;
  std::string scene;
  // Made for pictures that wait to be learnt, and removed; without blanks.
  std::string folder;
  // What the learner says.
  std::string log;
  // Seconds between two models (s).
  double publish_every_s = 2;
  // Frames are learnt that differ from the one before: as keyframes of maps.
  double keyframe_m = 0.05;
  double keyframe_rad = 0.04;
  // SLAM has changed its mind: the learner is told once a frame has moved so
  // far, and at the end.
  double moved_m = 0.05;
  double moved_rad = 0.02;
  // How long a learner is waited for at the end that does not read, or does not
  // end: so long, and longer the more frames it has.
  std::chrono::milliseconds patience = std::chrono::seconds(20);
  // Told once when learning ends early, and what the learner said at the end.
  std::function<void(const std::string& line)> say = [](const std::string&) {};

  // INVALID_ARGUMENT: a folder with blanks. NOT_FOUND: there is no learner.
  absl::Status Validate() const;
};

struct LiveSceneStatus {
  // Handed over; left out because SLAM never said where they were; and because
  // the disk took no pictures.
  int64_t frames = 0;
  int64_t without_place = 0;
  int64_t not_handed_over = 0;
  // Times that frames had moved too far.
  int64_t corrections = 0;
  // The furthest that a frame was moved by the last ones (m).
  double moved_m = 0;
};

// Hands frames and where they were to a learner in a process of its own, of
// lower priority. Whatever becomes of that, mapping goes on. Not thread-safe.
class LiveScene {
 public:
  // Starts nothing yet. The errors of Validate.
  static absl::StatusOr<std::unique_ptr<LiveScene>> Create(
      const LiveSceneOptions& options);
  ~LiveScene();
  LiveScene(const LiveScene&) = delete;
  LiveScene& operator=(const LiveScene&) = delete;

  // A frame, of which SLAM may not know yet where it was. Its stamp is SLAM's
  // time.
  void Add(recording::LogFrame frame,
           const camera::RgbdCalibration& calibration);

  // Where the robot was, with all that is known now: hands over the frames that
  // have got a place, and says which have moved. base_from_camera: of the
  // calibration's pose sensor.
  void Follow(std::span<const dataset::TimedPose> map_from_base,
              const geometry::Rigid3& base_from_camera);

  // The drive is over: as Follow, and no more frames will come. The learner
  // makes the complete model, in a second or two.
  void End(std::span<const dataset::TimedPose> map_from_base,
           const geometry::Rigid3& base_from_camera);

  // The map's own poses are there. Waits until the learner has written the
  // model with them; `stop` or `patience` ends it, and the model so far stays.
  void Finish(std::span<const dataset::TimedPose> map_from_base,
              const geometry::Rigid3& base_from_camera,
              const std::stop_token& stop);

  LiveSceneStatus status() const { return status_; }

 private:
  struct HandedOver {
    dataset::Time_ns time = 0;
    std::string color_path;
    std::string depth_path;
    geometry::Rigid3 map_from_camera;  // as the learner has it
  };

  explicit LiveScene(const LiveSceneOptions& options);
  absl::Status Start(const recording::LogFrame& frame);
  void HandOver(const recording::LogFrame& frame,
                const geometry::Rigid3& map_from_camera);
  void Place(std::span<const dataset::TimedPose> map_from_base,
             const geometry::Rigid3& base_from_camera);
  void CorrectBeyond(double distance_m, double turn_rad,
                     std::span<const dataset::TimedPose> map_from_base,
                     const geometry::Rigid3& base_from_camera);
  void Send();
  void SendAll(std::chrono::milliseconds patience);
  // Whether it has ended.
  bool AwaitLearner(std::chrono::milliseconds patience,
                    const std::stop_token& stop);
  void GiveUp(const absl::Status& why);

  const LiveSceneOptions options_;
  MotionGate gate_;
  std::optional<camera::RgbdCalibration> calibration_;
  std::unique_ptr<base::ChildProcess> learner_;
  bool has_given_up_ = false;
  std::deque<recording::LogFrame> waiting_;
  std::vector<HandedOver> frames_;
  std::string unsent_;
  LiveSceneStatus status_;
};

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_LIVE_SCENE_H_
