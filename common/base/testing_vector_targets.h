// For tests of what is written for several kinds of vector instructions.
#ifndef COMMON_BASE_TESTING_VECTOR_TARGETS_H_
#define COMMON_BASE_TESTING_VECTOR_TARGETS_H_

#include <cstdint>

#include "gtest/gtest.h"
#include "hwy/targets.h"

namespace treeline::base {

// Runs `check` with each kind that this machine has, and names it in failures.
template <typename Check>
void WithEachVectorTarget(const Check& check) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace treeline::base

#endif  // COMMON_BASE_TESTING_VECTOR_TARGETS_H_
