#include "client/bench/answer_checker.h"

#include "common/wire/geometry.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using Bits = AnswerChecker::Bits;

v1::LocalizeResponse Answer(const geometry::Rigid3& pose, double total_ms = 1) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  *response.mutable_world_from_camera() = wire::ToProto(pose);
  response.set_scene("room");
  response.set_model_version("1");
  response.mutable_timings()->set_total_ms(total_ms);
  return response;
}

geometry::Rigid3 At(double x_m) { return {{}, {x_m, 0, 0}}; }

TEST(AnswerChecker, TimingsMayDifferAndNothingElse) {
  AnswerChecker checker({std::nullopt, std::nullopt}, {});
  EXPECT_EQ(checker.Check(0, Answer(At(1), 10)).bits, Bits::kNew);
  checker.LoadBegins();
  EXPECT_EQ(checker.Check(0, Answer(At(1), 20)).bits, Bits::kAsBeforeLoad);
  EXPECT_EQ(checker.Check(0, Answer(At(1 + 1e-15), 20)).bits, Bits::kDifferent);
  v1::LocalizeResponse fewer = Answer(At(1));
  fewer.set_inliers(7);
  EXPECT_EQ(checker.Check(0, fewer).bits, Bits::kDifferent);
  // Another query is another answer.
  EXPECT_EQ(checker.Check(1, Answer(At(2))).bits, Bits::kNew);
}

TEST(AnswerChecker, ANewVersionIsComparedWithItself) {
  AnswerChecker checker({std::nullopt}, {});
  EXPECT_EQ(checker.Check(0, Answer(At(1))).bits, Bits::kNew);
  checker.LoadBegins();
  v1::LocalizeResponse second = Answer(At(2));
  second.set_model_version("2");
  EXPECT_EQ(checker.Check(0, second).bits, Bits::kNew);
  EXPECT_EQ(checker.Check(0, second).bits, Bits::kAsFirstUnderLoad);
  EXPECT_EQ(checker.Check(0, Answer(At(1))).bits, Bits::kAsBeforeLoad);
  *second.mutable_world_from_camera() = wire::ToProto(At(3));
  EXPECT_EQ(checker.Check(0, second).bits, Bits::kDifferent);
}

TEST(AnswerChecker, PosesAreComparedWithTheTruth) {
  AnswerChecker checker({At(1), std::nullopt},
                        {.position_m = 0.1, .rotation_rad = 0.1});
  const auto near = checker.Check(0, Answer(At(1.09)));
  EXPECT_EQ(near.within_tolerance, true);
  EXPECT_FALSE(near.wrong_pose);
  const auto far = checker.Check(0, Answer(At(1.11)));
  EXPECT_EQ(far.within_tolerance, false);
  EXPECT_TRUE(far.wrong_pose);
  const auto turned = checker.Check(
      0, Answer({geometry::Rotation3::FromAxisAngle({0, 0.11, 0}), {1, 0, 0}}));
  EXPECT_TRUE(turned.wrong_pose);
  EXPECT_FALSE(checker.Check(1, Answer(At(9))).within_tolerance.has_value());
}

TEST(AnswerChecker, NotLocalizedIsNoWrongPose) {
  AnswerChecker checker({At(1)}, {});
  v1::LocalizeResponse lost;
  lost.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
  const auto verdict = checker.Check(0, lost);
  EXPECT_EQ(verdict.within_tolerance, false);
  EXPECT_FALSE(verdict.wrong_pose);
}

}  // namespace
}  // namespace treeline::bench
