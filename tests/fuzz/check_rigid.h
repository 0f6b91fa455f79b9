// Aborts a fuzzer that got a pose which is none.
#ifndef TESTS_FUZZ_CHECK_RIGID_H_
#define TESTS_FUZZ_CHECK_RIGID_H_

#include <cmath>
#include <cstdlib>

#include "common/geometry/rigid3.h"

namespace treeline {

inline void CheckRigid(const geometry::Rigid3& pose) {
  const geometry::Rotation3& q = pose.rotation;
  const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (!geometry::IsFinite(pose) || std::abs(norm - 1) > 1e-9) std::abort();
}

}  // namespace treeline

#endif  // TESTS_FUZZ_CHECK_RIGID_H_
