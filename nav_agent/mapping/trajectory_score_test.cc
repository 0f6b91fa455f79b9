#include "nav_agent/mapping/trajectory_score.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::mapping {
namespace {

recording::RecordingTime At(int time_ms) {
  return recording::RecordingTime(std::chrono::milliseconds(time_ms));
}

// 1 m a second along x, then a quarter turn.
std::vector<TrajectoryPose> Way() {
  return {{At(0), {{0, 0}, 0}},
          {At(1000), {{1, 0}, 0}},
          {At(2000), {{1, 0}, std::numbers::pi / 2}}};
}

TEST(TrajectoryScore, IsTheErrorOfRelativePoses) {
  const std::vector<recording::PoseRelation> relations = {
      {At(0), At(1000), {{1.0, 0.03}, 0.01}},
      {At(1000), At(2000), {{0.04, 0}, std::numbers::pi / 2}}};
  const auto score = ScoreRelations(Way(), relations);
  ASSERT_TRUE(score.ok());
  EXPECT_EQ(score->used, 2);
  EXPECT_NEAR(score->translation_m.mean, 0.035, 1e-9);
  EXPECT_NEAR(score->translation_m.rmse, std::sqrt(0.00125), 1e-9);
  EXPECT_NEAR(score->rotation_rad.mean, 0.005, 1e-9);
  EXPECT_NEAR(score->rotation_rad.max, 0.01, 1e-9);
}

TEST(TrajectoryScore, DoesNotDependOnTheFrame) {
  const std::vector<recording::PoseRelation> relations = {
      {At(0), At(2000), {{1, 0.2}, 1.5}}};
  std::vector<TrajectoryPose> moved = Way();
  for (TrajectoryPose& pose : moved) {
    pose.map_from_base = geometry::Rigid2{{5, -3}, 2.0} * pose.map_from_base;
  }
  EXPECT_NEAR(ScoreRelations(Way(), relations)->translation_m.mean,
              ScoreRelations(moved, relations)->translation_m.mean, 1e-12);
}

TEST(TrajectoryScore, InterpolatesWithinLimits) {
  const auto pose = PoseAt(Way(), At(250));
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->translation.x, 0.25, 1e-12);
  EXPECT_FALSE(PoseAt(Way(), At(250), {.max_gap_s = 0.2}).has_value());
  EXPECT_FALSE(PoseAt(Way(), At(250), {.max_step_m = 0.5}).has_value());
  EXPECT_TRUE(PoseAt(Way(), At(1000), {.max_gap_s = 0}).has_value());
  EXPECT_FALSE(PoseAt(Way(), At(2001)).has_value());
  const std::vector<recording::PoseRelation> relations = {
      {At(0), At(9000), {}}, {At(0), At(1000), {}}};
  EXPECT_EQ(ScoreRelations(Way(), relations)->left_out, 1);
  EXPECT_FALSE(ScoreRelations({}, relations).ok());
}

}  // namespace
}  // namespace treeline::mapping
