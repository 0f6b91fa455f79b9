// The depth views of a recorded agent log.
#ifndef TESTS_FUSION_FUSION_LOG_H_
#define TESTS_FUSION_FUSION_LOG_H_

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"

namespace treeline {

struct StampedPose {
  base::MonotonicTime stamp;
  geometry::Rigid3 world_from_base;
};

// Between two of `poses`, which are ordered by time; the nearest outside.
geometry::Rigid3 PoseAt(const std::vector<StampedPose>& poses,
                        base::MonotonicTime stamp);

// All true poses of a log.
absl::StatusOr<std::vector<StampedPose>> ReadTruePoses(const std::string& path);

// A depth image with the camera that took it.
struct LoggedView {
  base::MonotonicTime stamp;
  image::DepthImage depth;
  camera::Camera camera;
  geometry::Rigid3 base_from_camera;
};

// Calls `visit` for every `every`-th frame with depth, until it fails.
absl::Status ForEachView(
    const std::string& path, int every,
    const std::function<absl::Status(const LoggedView&)>& visit);

}  // namespace treeline

#endif  // TESTS_FUSION_FUSION_LOG_H_
