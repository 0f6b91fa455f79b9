// Poses from three rays.
#ifndef SERVER_CORE_POSE_P3P_H_
#define SERVER_CORE_POSE_P3P_H_

#include <array>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::pose {

// Up to four camera_from_world that see three points on three rays (P3P;
// Grunert 1841, as in Haralick et al. 1994). Points and rays must not be
// collinear.
struct P3pSolutions {
  std::array<geometry::Rigid3, 4> camera_from_world;
  int count = 0;
};
P3pSolutions SolveP3p(const std::array<camera::Pixel, 3>& rays,
                      const std::array<geometry::Vec3, 3>& points_in_world);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_P3P_H_
