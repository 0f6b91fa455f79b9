// Whether a picture of which no camera is stated, or a guess, was taken as is
// assumed: as a whole, through a lens that does not distort. Often it is a
// window of a larger one, as whoever cuts off what does not matter makes it,
// and the principal point is not in the middle; or it is a webcam's, and
// straight lines are bent. A pose that takes it for what it is not is wrong,
// and features agree all the same.
#ifndef SERVER_CORE_LOCALIZER_ASSUMED_LENS_H_
#define SERVER_CORE_LOCALIZER_ASSUMED_LENS_H_

#include <optional>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "server/core/pose/focal_estimate.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::localizer {

struct AssumedLens {
  // As little differs from what is assumed as features allow. If it is as
  // assumed, what it adds to a covariance is a usual lens's share, or any's, by
  // how probable either is.
  pose::LensEstimate found;
  // Nothing does, with the odds that were asked for.
  bool is_as_assumed = false;
};

// By features that support the pose of the colour camera, which is assumed.
// See EstimateLens. With `min_odds` above 1 features have to tell that it is as
// assumed, with less they have to tell that it is not.
std::optional<AssumedLens> FindAssumedLens(
    const pose::RayPredictions& scene,
    const geometry::Rigid3& world_from_camera, double robust_scale,
    const camera::Camera& assumed, double min_odds);

// `assumed` with the focal length, the principal point and the distortion that
// were found. INVALID_ARGUMENT unless that makes a camera, and for fisheyes.
absl::StatusOr<camera::Camera> WithLens(const camera::Camera& assumed,
                                        const pose::LensEstimate& found);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_ASSUMED_LENS_H_
