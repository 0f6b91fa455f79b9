// Poses of frames that come one by one, checked against their depth.
#ifndef SERVER_CORE_TRAINING_POSE_WATCH_H_
#define SERVER_CORE_TRAINING_POSE_WATCH_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/camera/rgbd_calibration.h"
#include "server/core/training/surface_consistency.h"

namespace treeline::training {

// Looks at the first twenty frames, and then, as more come, at sixty that are
// spread over all of them, until a thousand have come: the longer the way, the
// more it tells. Not thread-safe.
class PoseWatch {
 public:
  // name: where the frames come from, for the error.
  PoseWatch(std::string name, const camera::RgbdCalibration& calibration,
            int threads);

  // FAILED_PRECONDITION once poses would fit the depth when meant otherwise
  // (pose_convention.h). Depth of another size than the camera's says nothing.
  absl::Status Add(const image::DepthImage& depth,
                   const geometry::Rigid3& world_from_sensor);

 private:
  absl::Status Check() const;

  const std::string name_;
  const camera::RgbdCalibration calibration_;
  const int threads_;
  std::vector<PosedDepth> frames_;  // every stride_-th
  size_t came_ = 0;
  size_t stride_ = 1;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_POSE_WATCH_H_
