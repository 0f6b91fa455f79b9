// The inner loop of RefineRays: many rays at once.
#ifndef SERVER_CORE_POSE_RAY_KERNELS_H_
#define SERVER_CORE_POSE_RAY_KERNELS_H_

#include <array>
#include <cstddef>
#include <vector>

#include "common/geometry/rigid3.h"
#include "server/core/pose/robust_refinement.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

// Rays with their best predictions, slot i of each array; up to whole vectors.
struct PackedRays {
  explicit PackedRays(const RayPredictions& scene);

  size_t size = 0;
  std::vector<double> u, v;                       // the ray
  std::vector<double> noise;                      // its variance
  std::vector<double> x, y, z;                    // the mean, in the world
  std::array<std::vector<double>, 6> covariance;  // xx xy xz yy yz zz
};

// Normal equations of the reprojection errors r_i of the rays in the reach of
// the robust loss,
//   sum_i rho(|r_i|) r_i^T (A_i C_i A_i^T + noise_i I)^-1 r_i
// with A_i the derivative of the projection by the point, and rho
// Geman-McClure's weight at `scale`.
RobustSum SumRays(const PackedRays& rays,
                  const geometry::Rigid3& world_from_camera, double scale);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_RAY_KERNELS_H_
