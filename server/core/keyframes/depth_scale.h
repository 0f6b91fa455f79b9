// Whether a depth image's unit is what the frame says it is.
#ifndef SERVER_CORE_KEYFRAMES_DEPTH_SCALE_H_
#define SERVER_CORE_KEYFRAMES_DEPTH_SCALE_H_

#include <array>
#include <optional>

#include "server/core/keyframes/alignment_kernels.h"

namespace treeline::keyframes {

// Depth is true if it is taken `scale` times.
struct DepthScale {
  double scale = 1;
  // Standard deviation of log(scale).
  double sigma = 0;
  // Measured points that were looked at, and the share of them that lie on the
  // keyframes' surfaces once they are scaled.
  int points = 0;
  double agreement = 0;
};

// How well a step (v, w) of the camera's frame is known: see NormalSums. Row by
// row, and symmetric.
using PoseInformation = std::array<double, 36>;

// Minimises, over the scale s and a step of the camera,
//   step^T information step
//     + robust sum of (n . (s * measured point - X))^2 / depth noise^2,
// where `information` is what the picture alone says of the pose, which is that
// of `view`. The picture says how far away what it shows is, and the surfaces'
// scatter how well depth tells so. nullopt: too few points, or the scale is
// beyond kMaxLogDepthScale.
std::optional<DepthScale> EstimateDepthScale(
    const SurfacePoints& points, const PinholeView& view,
    const PoseInformation& information);

// The first step of the same from a pose that depth has already pulled at:
// `information` is what picture and surfaces say together. Enough to see that
// a scale is wrong, not to correct it. Agreement is not filled.
std::optional<DepthScale> DepthScaleStep(const SurfacePoints& points,
                                         const PinholeView& view,
                                         const PoseInformation& information);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_DEPTH_SCALE_H_
