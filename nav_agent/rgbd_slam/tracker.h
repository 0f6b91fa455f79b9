// Where the camera is in a map, frame after frame.
#ifndef NAV_AGENT_RGBD_SLAM_TRACKER_H_
#define NAV_AGENT_RGBD_SLAM_TRACKER_H_

#include <optional>
#include <vector>

#include "nav_agent/rgbd_slam/feature_matching.h"
#include "nav_agent/rgbd_slam/rgbd_slam.h"
#include "nav_agent/rgbd_slam/slam_map.h"
#include "nav_agent/rgbd_slam/word_index.h"

namespace treeline::rgbd_slam {

// A frame's place in the map.
struct TrackedFrame {
  geometry::Rigid3 camera_from_map;
  // Landmarks that agree, each with its feature.
  std::vector<FeatureMatch> matches;
  bool is_relocalized = false;
};

class Tracker {
 public:
  // Both must outlive it.
  Tracker(const RgbdSlamOptions& options, SlamMap* map);

  // Predicts by constant velocity and looks for the landmarks about there; if
  // that fails, wider, and then for those of the latest keyframe by their
  // looks. nullopt: lost.
  std::optional<TrackedFrame> Track(const FeatureSet& features);

  // Looks for the frame in all keyframes of the index, nearest in looks first.
  std::optional<TrackedFrame> Relocalize(const FeatureSet& features,
                                         const WordIndex& index,
                                         uint64_t stream);

  // The pose of `features` from the landmarks of one keyframe and its
  // neighbours; nullopt if fewer than min_inliers agree.
  std::optional<TrackedFrame> FindFrom(int keyframe, const FeatureSet& features,
                                       int min_inliers, uint64_t stream) const;

  // Tells that the frame is at this place now, seen from `keyframe`.
  void SetPlace(const TrackedFrame& place, int keyframe);
  void SetKeyframe(int keyframe) { keyframe_ = keyframe; }
  void SetLost();
  // Follows the map: its poses changed as keyframe `keyframe`'s did.
  void Correct(const geometry::Rigid3& new_from_old);

  int keyframe() const { return keyframe_; }

 private:
  // Solves for the pose from landmarks near where they are expected at
  // `camera_from_map`.
  std::optional<TrackedFrame> Refine(std::span<const int> landmarks,
                                     const FeatureSet& features,
                                     const geometry::Rigid3& camera_from_map,
                                     double radius_px, double ratio,
                                     int min_inliers) const;
  // The landmarks about a frame that sees these.
  std::vector<int> LocalLandmarks(const std::vector<FeatureMatch>& seen) const;

  const RgbdSlamOptions& options_;
  SlamMap& map_;
  int keyframe_ = -1;
  std::vector<FeatureMatch> last_matches_;
  geometry::Rigid3 camera_from_map_;
  std::optional<geometry::Rigid3> velocity_;
};

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_TRACKER_H_
