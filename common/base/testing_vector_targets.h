// For tests of what is written for several kinds of vector instructions.
#ifndef COMMON_BASE_TESTING_VECTOR_TARGETS_H_
#define COMMON_BASE_TESTING_VECTOR_TARGETS_H_

#include <cstdint>

// As the kernels that ask for it: without, it would be left out here.
#ifndef HWY_WANT_AVX3_DL
#define HWY_WANT_AVX3_DL 1
#endif
#include "gtest/gtest.h"
#include "hwy/targets.h"

namespace treeline::base {

// Runs `check` as on a machine of each kind that this one contains, and names
// it in failures. Kernels that were not compiled for a kind use their next
// lesser one, as they would there.
template <typename Check>
void WithEachVectorTarget(const Check& check) {
  const int64_t all = hwy::SupportedTargets();
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    // Better ones have lower bits.
    hwy::SetSupportedTargetsForTest(all & ~(target - 1));
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace treeline::base

#endif  // COMMON_BASE_TESTING_VECTOR_TARGETS_H_
