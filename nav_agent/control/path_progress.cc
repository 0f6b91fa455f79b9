#include "nav_agent/control/path_progress.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "nav_agent/control/driving_parameters.h"

namespace treeline::control {
void PathProgress::SetPath(const std::vector<core::LevelPose>& path) {
  path_ = path;
  starts_m_.assign(path.size(), 0);
  for (size_t i = 1; i < path.size(); ++i) {
    starts_m_[i] = starts_m_[i - 1] +
                   geometry::Norm(path[i].map_from_base.translation -
                                  path[i - 1].map_from_base.translation);
  }
  along_m_ = 0;
  off_m_ = 0;
  is_fresh_ = true;
}

void PathProgress::Follow(const core::LevelPose& pose) {
  if (path_.size() < 2) {
    if (!path_.empty()) {
      off_m_ = geometry::Norm(pose.map_from_base.translation -
                              path_[0].map_from_base.translation);
    }
    return;
  }
  const double from_m = std::max(0.0, along_m_ - kPathBack_m);
  const double until_m = along_m_ + (is_fresh_ ? 2 : 1) * kPathAhead_m;
  const geometry::Vec2 at = pose.map_from_base.translation;
  double best = std::numeric_limits<double>::infinity();
  double best_along_m = along_m_;
  for (size_t i = 1; i < path_.size(); ++i) {
    if (starts_m_[i] < from_m || starts_m_[i - 1] > until_m) continue;
    if (std::abs(path_[i].place.height_m - pose.place.height_m) >
        kStoreyHeight_m) {
      continue;
    }
    const geometry::Vec2 begin = path_[i - 1].map_from_base.translation;
    const geometry::Vec2 way = path_[i].map_from_base.translation - begin;
    const double square = geometry::Dot(way, way);
    const double part =
        square > 1e-12
            ? std::clamp(geometry::Dot(at - begin, way) / square, 0.0, 1.0)
            : 1.0;
    const double along_m =
        std::clamp(starts_m_[i - 1] + part * (starts_m_[i] - starts_m_[i - 1]),
                   from_m, until_m);
    const double off_m = geometry::Norm(begin + part * way - at);
    const double score = off_m + kSkipCost * std::max(0.0, along_m - along_m_);
    if (score < best) {
      best = score;
      best_along_m = along_m;
      off_m_ = off_m;
    }
  }
  along_m_ = best_along_m;
  is_fresh_ = false;
}

void PathProgress::JumpTo(double along_m) {
  along_m_ = std::clamp(along_m, 0.0, length_m());
}

core::LevelPose PathProgress::At(double along_m) const {
  if (path_.size() < 2 || along_m >= length_m()) return path_.back();
  const auto next = std::ranges::upper_bound(starts_m_, along_m);
  const auto i = static_cast<size_t>(
      std::max<std::ptrdiff_t>(1, next - starts_m_.begin()));
  const core::LevelPose& a = path_[i - 1];
  const core::LevelPose& b = path_[i];
  const double piece_m = starts_m_[i] - starts_m_[i - 1];
  const double part =
      piece_m > 1e-9
          ? std::clamp((along_m - starts_m_[i - 1]) / piece_m, 0.0, 1.0)
          : 0.0;
  const geometry::Vec2 way =
      b.map_from_base.translation - a.map_from_base.translation;
  core::LevelPose at = part < 0.5 ? a : b;
  at.map_from_base.translation = a.map_from_base.translation + part * way;
  if (piece_m > 1e-6) at.map_from_base.yaw_rad = std::atan2(way.y, way.x);
  at.place.height_m = (1 - part) * a.place.height_m + part * b.place.height_m;
  return at;
}

}  // namespace treeline::control
