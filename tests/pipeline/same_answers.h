// For tests: one localizer's answers with all kinds of vector instructions.
#ifndef TESTS_PIPELINE_SAME_ANSWERS_H_
#define TESTS_PIPELINE_SAME_ANSWERS_H_

#include <algorithm>
#include <span>
#include <vector>

#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"
#include "server/core/localizer/localizer.h"

namespace treeline {

// Sums of floats round in another order and with or without fused products.
// Measured: 4e-7 m. Where a sample changed sides, it would be more.
inline constexpr double kRoundingOfPose_m = 1e-5;
inline constexpr double kRoundingOfPose_rad = 1e-5;

// Expects that all kinds of vector instructions that this machine has give each
// frame the same outcome and, but for rounding, the same pose; and that most
// frames are localized. How far poses were apart is in the test's XML.
inline void ExpectSameAnswers(const localizer::Localizer& localizer,
                              std::span<const image::Frame> frames) {
  std::vector<localizer::PoseEstimate> expected;
  size_t localized = 0;
  geometry::PoseError most;
  base::WithEachVectorTarget([&] {
    for (size_t i = 0; i < frames.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "frame " << i);
      const auto answer = localizer.Localize(frames[i], {});
      ASSERT_TRUE(answer.ok()) << answer.status();
      if (expected.size() == i) {
        expected.push_back(*answer);
        localized += answer->outcome == localizer::Outcome::kLocalized;
        continue;
      }
      EXPECT_EQ(answer->outcome, expected[i].outcome);
      const geometry::PoseError difference = geometry::ErrorBetween(
          answer->world_from_camera, expected[i].world_from_camera);
      EXPECT_LT(difference.translation_m, kRoundingOfPose_m);
      EXPECT_LT(difference.rotation_rad, kRoundingOfPose_rad);
      most = {std::max(most.translation_m, difference.translation_m),
              std::max(most.rotation_rad, difference.rotation_rad)};
    }
  });
  testing::Test::RecordProperty("most_apart_m",
                                testing::PrintToString(most.translation_m));
  testing::Test::RecordProperty("most_apart_rad",
                                testing::PrintToString(most.rotation_rad));
  EXPECT_GE(10 * localized, 8 * frames.size());
}

}  // namespace treeline

#endif  // TESTS_PIPELINE_SAME_ANSWERS_H_
