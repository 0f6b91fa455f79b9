#include "evaluation/fields/field_suite.h"

#include "evaluation/fields/field_report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::fields {
namespace {

using ::testing::HasSubstr;

FieldRun DriveThrough(const std::string& world, uint64_t seed) {
  FieldOptions options;
  options.world = world;
  options.seed = seed;
  options.robot = *core::ReadRobot("jackal");
  options.with_movers = true;
  const auto run = RunField(options, {});
  EXPECT_TRUE(run.ok()) << run.status();
  return run.ok() ? *run : FieldRun();
}

TEST(FieldSuite, AJackalGetsThroughFieldsThatItKnowsNothingOf) {
  // One of each density, the densest last.
  for (const char* world : {"field:1", "field:6", "field:11"}) {
    const FieldRun run = DriveThrough(world, 1);
    EXPECT_EQ(run.outcome, FieldOutcome::kReached) << world << ": " << run.why;
    EXPECT_EQ(run.collisions_of_robot, 0) << world;
    EXPECT_GT(run.Score(), 0.3) << world;
    EXPECT_LE(run.Score(), 0.5) << world;
    EXPECT_GE(run.best_way.length_m, 10) << world;
  }
}

TEST(FieldSuite, AJackalCrossesFieldsThatMove) {
  // An easy one and a hard one.
  for (const char* world : {"moving-field:1", "moving-field:3"}) {
    const FieldRun run = DriveThrough(world, 1);
    EXPECT_EQ(run.outcome, FieldOutcome::kReached) << world << ": " << run.why;
    EXPECT_EQ(run.collisions, 0) << world;
    EXPECT_DOUBLE_EQ(run.best_way.length_m, 20) << world;
  }
}

TEST(FieldSuite, ARunIsAFunctionOfItsSeed) {
  const FieldRun one = DriveThrough("field:2", 7);
  const FieldRun same = DriveThrough("field:2", 7);
  EXPECT_EQ(one.time_s, same.time_s);
  EXPECT_EQ(one.record.track, same.record.track);
}

TEST(FieldSuite, ScoresAsTheChallengeDoes) {
  FieldRun run;
  run.outcome = FieldOutcome::kReached;
  run.best_way.length_m = 10;
  run.time_s = 7;  // below twice the optimal 5 s
  EXPECT_DOUBLE_EQ(run.Score(), 0.5);
  run.time_s = 20;
  EXPECT_DOUBLE_EQ(run.Score(), 0.25);
  run.time_s = 90;  // above eight times
  EXPECT_DOUBLE_EQ(run.Score(), 0.125);
  run.collisions_of_robot = 1;
  EXPECT_DOUBLE_EQ(run.Score(), 0);
  run.collisions_of_robot = 0;
  run.outcome = FieldOutcome::kTimeout;
  EXPECT_DOUBLE_EQ(run.Score(), 0);
  EXPECT_DOUBLE_EQ(MeanScore({}), 0);
}

TEST(FieldSuite, AWorldWithoutAGoalIsRefused) {
  FieldOptions options;
  options.world = "cafe";
  options.robot = *core::ReadRobot("jackal");
  const auto run = RunField(options, {});
  EXPECT_THAT(run.status().message(), HasSubstr("has no place '"));
}

}  // namespace
}  // namespace treeline::fields
