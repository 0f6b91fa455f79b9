// Are poses meant as they are read? Of recordings of other programs they may be
// the inverse, of other axes, with other quaternions or units; a scene
// that is learnt with such poses answers nothing, or nonsense.
#ifndef SERVER_CORE_TRAINING_POSE_CONVENTION_H_
#define SERVER_CORE_TRAINING_POSE_CONVENTION_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/camera/rgbd_calibration.h"
#include "server/core/training/surface_consistency.h"

namespace treeline::training {

// A reading under which poses and depth fit together much better.
struct OtherConvention {
  // "the poses were the inverse ...", for people, and what to do.
  std::string reading;
  std::string remedy;
  // Of the depth that is carried from one frame into another, the share (0 to
  // 1) that meets the depth measured there: as read, and under that reading.
  double agreement_as_read = 0;
  double agreement = 0;
};

// None: the poses fit as they are read, or under no other reading either
// (frames that see nothing in common, poses that are plainly wrong). `frames`
// are in the order of the recording.
std::optional<OtherConvention> FindOtherConvention(
    const std::vector<PosedDepth>& frames,
    const camera::RgbdCalibration& calibration, int threads);

// FAILED_PRECONDITION with both shares, the reading and what to do, for frames
// of `name`.
absl::Status ConventionError(const std::string& name,
                             const OtherConvention& other);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_POSE_CONVENTION_H_
