// Tells a robot of somebody else's, as Nav2 or RTAB-Map drive it, where it is:
// at its start, when it seems lost, and whenever somebody asks. Messages in,
// an initial pose and diagnostics out; who carries them is not known here.
#ifndef NAV_AGENT_BRIDGE_PLACE_FINDER_PLACE_FINDER_H_
#define NAV_AGENT_BRIDGE_PLACE_FINDER_PLACE_FINDER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid3.h"
#include "common/ros2/conversions/frame_tree.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/behavior/pending_fixes.h"
#include "nav_agent/bridge/place_finder/camera_input.h"
#include "nav_agent/bridge/place_finder/flat_map.h"
#include "nav_agent/bridge/place_finder/odometry_trail.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/localization/lost_detector.h"

namespace treeline::place_finder {

struct PlaceFinderOptions {
  std::string map_frame = "map";
  std::string base_frame = "base_footprint";
  // From the frame of the server's scene to the robot's map.
  geometry::Rigid3 map_from_world = {};
  // nullopt: as /tf_static has it, by the frame of the pictures.
  std::optional<geometry::Rigid3> base_from_camera = std::nullopt;
  CameraInput::Options camera = {};
  // Scans are stamped so much later than odometry of the same moment (s).
  double laser_delay_s = 0;
  behavior::FixGateOptions gate = {};
  // One question takes at most so long (s, 0.1 to 60), and the next one comes
  // so long after an answer (s, 0 to 60).
  double answer_timeout_s = 3;
  double ask_interval_s = 0.5;
  // A turning robot's pictures are blurred (rad/s, above 0).
  double max_turn_radps = 0.5;
  // Without a scan and a map nothing contradicts the server. Then two views
  // must agree that were taken from different places or in different
  // directions; true: one is enough that the server itself is sure of.
  bool is_one_view_enough = false;

  absl::Status Validate() const;
};

// Why the server is asked.
enum class Need : uint8_t { kNone, kNoPlaceYet, kLost, kAsked };
const char* NeedName(Need need);

// Not thread-safe. Times are ROS time (conversions/geometry_values.h).
class PlaceFinder {
 public:
  // The server must outlive it.
  PlaceFinder(core::RelocalizationPort& server,
              const PlaceFinderOptions& options);

  // What comes broken is an error, and changes nothing.
  absl::Status Add(const messages::Odometry& odometry);
  absl::Status Add(const messages::LaserScan& scan);
  absl::Status Add(const messages::OccupancyGrid& map);
  void Add(const messages::TFMessage& transforms) { frames_.Add(transforms); }
  CameraInput& camera() { return camera_; }
  // Somebody wants to know.
  void AskNow() { is_asked_ = true; }

  struct Output {
    // For /initialpose: the place at the newest odometry.
    std::optional<messages::PoseWithCovarianceStamped> initial_pose;
    // What happened, for the log.
    std::vector<std::string> events;
  };
  Output Step(base::MonotonicTime now);

  // ---- what diagnostics tell ----
  struct State {
    Need need = Need::kNone;
    // Of the place that others believe in (map_frame to the odometry's frame
    // in /tf); nullopt without map, scan or such a place.
    std::optional<localization::LostVerdict> verdict;
    // What keeps the server from being asked; OK: nothing.
    absl::Status obstacle;
    // Of the last question; OK before the first one, too.
    absl::Status last_answer;
    double last_round_trip_s = 0;
    // What the gate said last; "": nothing yet.
    std::string last_fix;
    // Where /tf_static has the camera otherwise than who set base_from_camera;
    // "": they agree, or only one of them says so.
    std::string camera_dispute;
    bool is_server_elsewhere = false;
    bool has_map = false;
    bool has_scan = false;
    int64_t questions = 0;
    int64_t answers = 0;
    int64_t refused = 0;
    int64_t places = 0;
  };
  const State& state() const { return state_; }

 private:
  std::optional<geometry::Rigid2> BelievedAt(base::MonotonicTime stamp) const;
  void WatchForLoss();
  // Drops what was seen before the clock of the robot began anew.
  void BeginAnew();
  Need NeedNow() const;
  absl::Status AskIfPossible(base::MonotonicTime now);
  absl::Status FindCamera();
  // What base_from_camera and /tf_static say of each other.
  std::string CameraDispute() const;
  void TakeAnswer(base::MonotonicTime now, Output& output);
  behavior::GatedFix Check(const core::RelocalizationAnswer& answer,
                           const localization::TrackedMotion& motion) const;
  // nullopt: it waits for another view, or is refused.
  std::optional<behavior::GatedFix> Decide(const behavior::GatedFix& fix);
  void Publish(const behavior::GatedFix& fix, base::MonotonicTime now,
               Output& output);

  core::RelocalizationPort& server_;
  const PlaceFinderOptions options_;
  CameraInput camera_;
  conversions::FrameTree frames_;
  OdometryTrail odometry_;
  std::optional<FlatMap> map_;
  std::optional<PlacedScan> scan_;
  std::optional<localization::LostDetector> lost_;
  behavior::PendingFixes pending_;
  bool is_asked_ = false;
  // Somebody believes in a place, or was told one.
  bool has_place_ = false;
  int64_t last_asked_picture_ = -1;
  std::optional<base::MonotonicTime> next_question_;
  // Of the question that is open.
  std::optional<localization::TrackedMotion> question_motion_;
  // The clock has begun anew since: its answer is of no use.
  bool is_question_stale_ = false;
  geometry::Rigid3 base_from_camera_;
  State state_;
};

}  // namespace treeline::place_finder

#endif  // NAV_AGENT_BRIDGE_PLACE_FINDER_PLACE_FINDER_H_
