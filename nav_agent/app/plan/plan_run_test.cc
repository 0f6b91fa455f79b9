#include "nav_agent/app/plan/plan_run.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::plan_app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(PlanRunTest, ReadsPosesWithAndWithoutALevel) {
  const auto pose = ParsePlanPose("1.5,-2,0.25", "--start");
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->map_from_base,
            (geometry::Rigid2{.translation = {1.5, -2}, .yaw_rad = 0.25}));
  EXPECT_EQ(pose->place.level, 0);
  const auto upstairs = ParsePlanPose(" 1e1, 0 ,0,2", "--goal");
  ASSERT_TRUE(upstairs.ok()) << upstairs.status();
  EXPECT_EQ(upstairs->map_from_base.translation.x, 10);
  EXPECT_EQ(upstairs->place.level, 2);
  // Headings are kept within half a turn.
  const auto turned = ParsePlanPose("0,0,6.28", "--goal");
  ASSERT_TRUE(turned.ok()) << turned.status();
  EXPECT_LE(std::abs(turned->map_from_base.yaw_rad), std::numbers::pi);
}

TEST(PlanRunTest, RefusesDegrees) {
  const absl::Status status = ParsePlanPose("1,2,90", "--goal").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("90 degrees are 1.57"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("--goal"));
}

TEST(PlanRunTest, RefusesWhatIsNoPoseAndNamesTheOption) {
  for (const char* text : {"",          ",",         ",,",
                           "1,2",       "1,2,",      "1,2,3,",
                           "1,2,3,4,5", "a,b,c",     "1;2;3",
                           "nan,0,0",   "0,inf,0",   "0,0,-inf",
                           "1e999,0,0", "0,0,1e400", "1,2,3,x",
                           "1,2,3,1.5", "1,2,3,-1",  "1,2,3,99999999999",
                           "1 2,3,4",   "--goal,1,2"}) {
    const absl::Status status = ParsePlanPose(text, "--start").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("--start is '"));
    EXPECT_THAT(std::string(status.message()), HasSubstr("X,Y,YAW,LEVEL"));
  }
}

TEST(PlanRunTest, MessagesAreShortAndHarmless) {
  const std::string evil = "1,2,\x1b[2J" + std::string(100000, 'x');
  const absl::Status status = ParsePlanPose(evil, "--goal").status();
  EXPECT_LT(status.message().size(), 300U);
  EXPECT_THAT(std::string(status.message()), Not(HasSubstr("\x1b")));
  EXPECT_THAT(std::string(status.message()), HasSubstr("..."));
  EXPECT_FALSE(ParsePlanPose(std::string("1,2,3\0", 6), "--goal").ok());
}

TEST(PlanRunTest, AnythingElseIsAFinitePoseOrRefused) {
  const std::string alphabet = std::string("0123456789,.-+eEnaif x") + '\0';
  for (uint64_t i = 0; i < 20000; ++i) {
    base::Random random(7, i);
    std::string text;
    for (uint32_t left = random.NextBelow(24); left > 0; --left) {
      text +=
          alphabet[random.NextBelow(static_cast<uint32_t>(alphabet.size()))];
    }
    const auto pose = ParsePlanPose(text, "--start");
    if (!pose.ok()) continue;
    EXPECT_TRUE(std::isfinite(pose->map_from_base.translation.x) &&
                std::isfinite(pose->map_from_base.translation.y) &&
                std::abs(pose->map_from_base.yaw_rad) <= std::numbers::pi &&
                pose->place.level >= 0)
        << text;
  }
}

TEST(PlanRunTest, ReadsBlockagesAndRefusesRadiiBelowZero) {
  const auto blockage = ParseBlockage("1,2,0.5,1");
  ASSERT_TRUE(blockage.ok()) << blockage.status();
  EXPECT_EQ(blockage->center, (geometry::Vec2{1, 2}));
  EXPECT_EQ(blockage->radius_m, 0.5);
  EXPECT_EQ(blockage->level, 1);
  for (const char* text : {"1,2", "1,2,-0.1", "1,2,nan", "1,2,0.5,-1", "x"}) {
    const absl::Status status = ParseBlockage(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("--block is '"));
  }
}

TEST(PlanRunTest, MapsThatThereAreNotAreNamed) {
  for (const char* path : {"", "/nowhere.yaml", "/nowhere", "/dev/null"}) {
    const auto map = LoadNavigationMap(path, false);
    EXPECT_FALSE(map.ok()) << path;
    EXPECT_FALSE(map.status().message().empty());
  }
  EXPECT_FALSE(NavigationMapOfWorld("atlantis", false).ok());
}

TEST(PlanRunTest, WritesFailuresWithTheirCauseAsJson) {
  PlanReport report;
  report.map_name = "a \"house\"";
  report.result.failure = core::NavigationCause::kGoalOutside;
  report.result.why = "the goal is not on the map";
  const auto json = nlohmann::json::parse(PlanJson(report));
  EXPECT_EQ(json["map"], "a \"house\"");
  EXPECT_EQ(json["found"], false);
  EXPECT_EQ(json["cause"], "goal_outside");
  EXPECT_TRUE(json["path"].empty());
  EXPECT_THAT(PlanSummary(report), HasSubstr("goal_outside"));
}

}  // namespace
}  // namespace treeline::plan_app
