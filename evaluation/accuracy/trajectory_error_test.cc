#include "evaluation/accuracy/trajectory_error.h"

#include <vector>

#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

TEST(PosePairs, LeaveOutFramesThatWereNotLocalizedOrHaveNoTruth) {
  FrameResult localized;
  localized.estimate = tools::LocalizedAt({{}, {1, 2, 3}});
  localized.true_world_from_camera = geometry::Rigid3{{}, {1, 2, 4}};
  localized.error = geometry::PoseError{1, 0};
  FrameResult lost;
  lost.true_world_from_camera = geometry::Rigid3{{}, {100, 100, 100}};
  FrameResult unknown;
  unknown.estimate = tools::LocalizedAt({{}, {100, 100, 100}});
  const std::vector<dataset::PosePair> pairs =
      PosePairs({lost, localized, unknown});
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].estimate.translation.z, 3);
  EXPECT_EQ(pairs[0].reference.translation.z, 4);
}

}  // namespace
}  // namespace treeline::accuracy
