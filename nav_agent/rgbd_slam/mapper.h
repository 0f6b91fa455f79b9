// What becomes of a tracked frame: keyframes, fused landmarks, closed loops.
#ifndef NAV_AGENT_RGBD_SLAM_MAPPER_H_
#define NAV_AGENT_RGBD_SLAM_MAPPER_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "nav_agent/rgbd_slam/bundle_adjustment.h"
#include "nav_agent/rgbd_slam/rgbd_slam.h"
#include "nav_agent/rgbd_slam/slam_map.h"
#include "nav_agent/rgbd_slam/tracker.h"
#include "nav_agent/rgbd_slam/word_index.h"

namespace treeline::rgbd_slam {

class Mapper {
 public:
  // All must outlive it. The tracker is asked to find keyframes from others.
  Mapper(const RgbdSlamOptions& options, const Tracker* tracker, SlamMap* map);

  const WordIndex& index() const { return index_; }
  int loops() const { return loops_; }
  int joined_submaps() const { return joined_submaps_; }

  // Adds a keyframe, adjusts what is about it and looks whether it was there
  // before. Returns its index. All poses may change.
  int Insert(MapKeyframe keyframe);

  // New landmarks are no longer followed: the camera was lost.
  void SetLost() { recent_.clear(); }

  // Tries once more to connect other submaps with `submap`.
  void Connect(int submap);

 private:
  // A place of a keyframe that was found from another one, far along the way.
  struct Meeting {
    int from = 0;
    TrackedFrame place;
  };

  void CullRecent(int keyframe);
  void FuseNeighbours(int keyframe);
  // Candidates by looks that are no neighbours; from other submaps alone if
  // wanted, then without comparing their looks with the neighbours'.
  std::vector<int> CandidatesFor(int keyframe, bool in_other_submaps) const;
  std::optional<Meeting> Meet(int keyframe, bool in_other_submaps) const;
  void Close(int keyframe, const Meeting& meeting);
  // The landmarks that both sides of a meeting see become one.
  void FuseMeeting(int keyframe, const Meeting& meeting);

  const RgbdSlamOptions& options_;
  const Tracker& tracker_;
  SlamMap& map_;
  WordIndex index_;
  BundleOptions local_;
  std::vector<KeyframeEdge> loop_edges_;
  // Landmarks that have yet to prove themselves.
  std::vector<int> recent_;
  int loops_ = 0;
  int joined_submaps_ = 0;
};

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_MAPPER_H_
