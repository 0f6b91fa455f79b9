// Simultaneous localization and mapping from an RGB-D camera alone: the job of
// ORB-SLAM in the thesis (section 6.3.1; Mur-Artal, Tardos, "ORB-SLAM2",
// IEEE T-RO 2017). See docs/explanation/rgbd-slam.md.
#ifndef NAV_AGENT_RGBD_SLAM_RGBD_SLAM_H_
#define NAV_AGENT_RGBD_SLAM_RGBD_SLAM_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/text_formats.h"
#include "common/image/frame.h"

namespace treeline::rgbd_slam {

struct RgbdSlamOptions {
  // Features of a picture, in [50, 5000].
  int features = 1000;
  // Least contrast of a corner (grey levels), in [1, 100].
  int contrast = 10;
  // Depth beyond is left out (m), in [0.5, 50].
  double max_depth_m = 6;
  // A frame is tracked if this many landmarks agree with its pose; in
  // [6, 1000]. A lost one is found again by twice as many.
  int min_inliers = 20;
  // A keyframe is made when the camera moved so far from the last one (m; rad),
  // or after so many frames, or when it sees less than this share of the
  // landmarks that the last one saw. Keyframes are training data: there are
  // many, and none is dropped.
  double keyframe_distance_m = 0.08;
  double keyframe_angle_rad = 0.12;
  int keyframe_frames = 15;
  double keyframe_share = 0.6;
  // Keyframes are covisible if they share at least this many landmarks; all
  // such pairs are edges of the pose graph. In [5, 1000].
  int min_shared = 15;
  // Bounds of the local bundle adjustment, which runs with each keyframe.
  int local_keyframes = 8;
  int local_landmarks = 800;
  int local_iterations = 4;
  // A new submap begins after so many lost frames in a row, in [1, 10000].
  int lost_frames = 3;
  bool closes_loops = true;
  // Bundle adjustment of everything in Finish, over at most so many landmarks;
  // 0 iterations: none.
  int final_iterations = 8;
  int final_landmarks = 6000;
  // Of hypotheses and words.
  uint64_t seed = 0;

  absl::Status Validate() const;
};

enum class RgbdTracking {
  kTracked,
  // Tracked after it was lost, by what places look like.
  kRelocalized,
  // The first frame of a map that is not connected with others yet.
  kNewSubmap,
  kLostFewFeatures,
  kLostNoMatch,
};
// Whether the frame has a pose, in one submap or another.
inline bool HasPose(RgbdTracking tracking) {
  return tracking <= RgbdTracking::kNewSubmap;
}
const char* RgbdTrackingName(RgbdTracking tracking);

struct RgbdTrackResult {
  RgbdTracking tracking = RgbdTracking::kLostNoMatch;
  // Landmarks that agree with the pose.
  int inliers = 0;
  bool is_keyframe = false;
  // In the submap's frame as it is now; Trajectory() has the corrected ones.
  // nullopt if lost.
  std::optional<geometry::Rigid3> map_from_camera;
};

struct RgbdKeyframe {
  // As counted by AddFrame, from 0.
  int frame = 0;
  dataset::Time_ns time = 0;
  geometry::Rigid3 map_from_camera;
};

struct RgbdSlamStatistics {
  int frames = 0;
  int tracked = 0;
  int lost = 0;
  int relocalized = 0;
  // All that were begun, and how many of them were joined to others.
  int submaps = 0;
  int joined_submaps = 0;
  int loops = 0;
  int keyframes = 0;
  int landmarks = 0;
  // Of each frame: features and tracking; and of each keyframe: mapping, local
  // bundle adjustment and loop closing (ms of wall time).
  std::vector<double> tracking_ms;
  std::vector<double> mapping_ms;
};

// The streaming interface. All work is done in the calling thread; results are
// a function of frames, options and calibration. Not thread-safe.
//
// Poses are those of the calibration's pose sensor, in metres, in the frame
// `map` of the largest connected submap: the pose of that submap's first frame
// is the identity. Unless the camera was lost early on, that is the first
// frame of all.
class RgbdSlam {
 public:
  // INVALID_ARGUMENT for options out of range.
  static absl::StatusOr<std::unique_ptr<RgbdSlam>> Create(
      const RgbdSlamOptions& options,
      const camera::RgbdCalibration& calibration);
  ~RgbdSlam();
  RgbdSlam(const RgbdSlam&) = delete;
  RgbdSlam& operator=(const RgbdSlam&) = delete;

  // INVALID_ARGUMENT for a frame without depth, of another size than the
  // calibration's, or that is not later than the last one; it is then as if it
  // had not been added. FAILED_PRECONDITION after Finish. A lost camera is a
  // result, not an error.
  absl::StatusOr<RgbdTrackResult> AddFrame(const image::Frame& frame,
                                           dataset::Time_ns time);

  // Adjusts the whole map. AddFrame must not be called afterwards.
  void Finish();

  // For each frame that was added its pose with all corrections made since;
  // nullopt for lost ones and those of submaps that are not connected to the
  // largest.
  std::vector<std::optional<geometry::Rigid3>> Trajectory() const;

  // The keyframes of the largest connected submap, in order of time.
  std::vector<RgbdKeyframe> Keyframes() const;

  RgbdSlamStatistics Statistics() const;

 private:
  struct State;
  explicit RgbdSlam(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_RGBD_SLAM_H_
