// How far along a path a robot has come.
#ifndef NAV_AGENT_CONTROL_PATH_PROGRESS_H_
#define NAV_AGENT_CONTROL_PATH_PROGRESS_H_

#include <vector>

#include "nav_agent/core/level_pose.h"

namespace treeline::control {

// Not thread-safe.
class PathProgress {
 public:
  // Empty: none. The robot may be anywhere near the path's first metres.
  void SetPath(const std::vector<core::LevelPose>& path);
  bool has_path() const { return !path_.empty(); }
  const core::LevelPose& goal() const { return path_.back(); }

  // Goes on to the nearest point a little behind and ahead of where it was:
  // not to a later part of the path that comes by here again, nor to one on
  // another floor.
  void Follow(const core::LevelPose& pose);
  // The point at along_m is reached, however far away the robot is.
  void JumpTo(double along_m);

  double along_m() const { return along_m_; }
  double length_m() const { return starts_m_.empty() ? 0 : starts_m_.back(); }
  double left_m() const { return length_m() - along_m_; }
  // From the robot to the path when it was followed last (m).
  double off_m() const { return off_m_; }
  // The path's pose so far along it; headings along it between its poses.
  core::LevelPose At(double along_m) const;

 private:
  std::vector<core::LevelPose> path_;
  std::vector<double> starts_m_;
  double along_m_ = 0;
  double off_m_ = 0;
  bool is_fresh_ = true;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_PATH_PROGRESS_H_
