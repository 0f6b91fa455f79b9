#include "evaluation/missions/mission_suite.h"

#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/missions/mission_report.h"
#include "evaluation/suites/suite_jobs.h"
#include "evaluation/suites/suite_maps.h"
#include "evaluation/suites/suite_report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::missions {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::shared_ptr<const suites::SuitePlace> MakeCafe(bool people) {
  auto world = worlds::MakeWorld(
      "cafe", {.with_people = people, .threads = 1, .paint = false});
  EXPECT_TRUE(world.ok()) << world.status();
  auto place = suites::SuitePlace::MakePerfect(*std::move(world));
  EXPECT_TRUE(place.ok()) << place.status();
  return *std::move(place);
}

// Made once: it takes a second.
std::shared_ptr<const suites::SuitePlace> Cafe(bool people) {
  static const auto* const kCafes =
      new std::vector({MakeCafe(false), MakeCafe(true)});
  return (*kCafes)[people ? 1 : 0];
}

TEST(SuitePlaceTest, KnowsWaysOverTheSlopeAndAroundBarriers) {
  const auto place = Cafe(false);
  EXPECT_TRUE(place->HasSeveralHeights());
  const simulator::RobotPlacement below = {.position = {1.6, 3.8}};
  const simulator::RobotPlacement above = {.position = {10.4, 1.4},
                                           .height_m = 0.51};
  const auto way_m = place->PathLength_m(below, above);
  ASSERT_TRUE(way_m.has_value());
  // Down to the slope's foot at (2.9, 0.8) and up to the terrace.
  EXPECT_GT(*way_m, 10.0);
  EXPECT_LT(*way_m, 13.0);
  // The slope is 1.5 m wide: a crate in its middle leaves no room.
  EXPECT_FALSE(place
                   ->PathLength_m(below, above,
                                  {{.center = {5, 0.8, 0.2}, .radius_m = 0.3}})
                   .has_value());
  const auto pose = place->InMap(above);
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_NEAR(pose->place.height_m, 0.51, 0.06);
  EXPECT_FALSE(place->InMap({.position = {40, 1}}).ok());
}

TEST(SuitePlaceTest, ASmallerRobotGetsToMorePlaces) {
  EXPECT_EQ(suites::PlaceRadius_m(core::RobotModel()),
            suites::kDefaultRobotRadius_m);
  const core::RobotDescription small = *core::ReadRobot("turtlebot3");
  const double radius_m = suites::PlaceRadius_m(small.model);
  EXPECT_GE(radius_m, small.model.Circumradius_m());
  EXPECT_LT(radius_m, 0.2);
  // 0.35 m from a wall.
  const simulator::RobotPlacement middle = {.position = {1.6, 3.8}};
  const simulator::RobotPlacement beside = {.position = {0.35, 3.8}};
  EXPECT_FALSE(Cafe(false)->PathLength_m(middle, beside).has_value());
  const auto place = suites::SuitePlace::MakePerfect(
      *worlds::MakeWorld("cafe",
                         {.with_people = false, .threads = 1, .paint = false}),
      radius_m);
  ASSERT_TRUE(place.ok()) << place.status();
  EXPECT_TRUE((*place)->PathLength_m(middle, beside).has_value());
}

// One laser, which turns five times a second and reaches 3.5 m.
TEST(MissionSuite, ASmallRobotWithASlowLaserArrives) {
  MissionOptions options;
  options.seed = 2;
  options.robot = *core::ReadRobot("turtlebot3");
  const auto run = RunMission(*Cafe(false), options, {});
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_TRUE(run->IsGood()) << run->why;
  // It stands for a moment at most: turns at both ends, and ways on.
  EXPECT_GT(run->record.final_state.distance_m / run->simulated_s,
            0.5 * options.robot->model.max_forward_mps);
}

TEST(SuitePlaceTest, KeepsThePerfectMapOfWhatWasThere) {
  const auto moved = suites::PlaceForSuite(
      {.world = "cafe", .rearranged = {.seed = 1, .share = 0.6}}, {});
  ASSERT_TRUE(moved.ok()) << moved.status();
  const auto before = Cafe(false);
  EXPECT_EQ((*moved)->map().voxels, before->map().voxels);
  EXPECT_LT((*moved)->world().surfaces.size(), before->world().surfaces.size());
  // Robots are sent to where there is room in both.
  EXPECT_GT((*moved)->MappedShare(), 0.5);
  EXPECT_LT((*moved)->MappedShare(), 1);
  base::Random random(1, 1);
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE((*moved)->InMap((*moved)->AnyPlace(random)).ok());
  }
}

TEST(SuitePlaceTest, ScoresInTheFrameOfADrivenMap) {
  auto world = worlds::MakeWorld(
      "cafe", {.with_people = false, .threads = 1, .paint = false});
  ASSERT_TRUE(world.ok());
  const auto perfect = Cafe(false);
  // As if the drive had begun at (2, 3), looking along +y.
  const geometry::Rigid3 world_from_map = {
      .rotation =
          geometry::Rotation3::FromAxisAngle({0, 0, 1.5707963267948966}),
      .translation = {2, 3, 0}};
  auto place = suites::SuitePlace::Make(*std::move(world), perfect->map(),
                                        world_from_map.Inverse());
  ASSERT_TRUE(place.ok()) << place.status();
  // A metre ahead of the map's origin, looking along its x.
  const core::LevelPose estimate = {{{1, 0}, 0}, {0, 0}};
  const geometry::Rigid3 world_from_base = {
      .rotation =
          geometry::Rotation3::FromAxisAngle({0, 0, 1.5707963267948966}),
      .translation = {2, 4, 0}};
  const suites::PoseMiss right = (*place)->ErrorOf(estimate, world_from_base);
  EXPECT_NEAR(right.distance_m, 0, 1e-9);
  EXPECT_NEAR(right.turn_deg, 0, 1e-9);
  EXPECT_TRUE(right.IsRight());
  const suites::PoseMiss wrong =
      (*place)->ErrorOf({{{1, 0.6}, 0}, {0, 0}}, world_from_base);
  EXPECT_NEAR(wrong.distance_m, 0.6, 1e-9);
  EXPECT_FALSE(wrong.IsRight());
}

TEST(MakeMissionTest, IsAFunctionOfTheSeedAndChangesHeights) {
  const auto place = Cafe(false);
  MissionOptions options;
  options.seed = 1002;  // a third one: over the slope
  const auto first = MakeMission(*place, options);
  const auto again = MakeMission(*place, options);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->route.start.position, again->route.start.position);
  EXPECT_EQ(first->route.goal.yaw_rad, again->route.goal.yaw_rad);
  EXPECT_GT(std::abs(first->route.start.height_m - first->route.goal.height_m),
            0.25);
  EXPECT_GE(first->route.way_m, options.min_way_m);
  options.seed = 1003;
  EXPECT_FALSE(MakeMission(*place, options)->route.start.position ==
               first->route.start.position);
  options.scene = "moon";
  EXPECT_THAT(std::string(MakeMission(*place, options).status().message()),
              HasSubstr("slope, blocked, person"));
}

TEST(RunMissionTest, TheThesisScenesEndWhereTheyShould) {
  const auto place = Cafe(true);
  for (const std::string& scene : MissionScenes()) {
    SCOPED_TRACE(scene);
    MissionOptions options;
    options.seed = 1000;
    options.scene = scene;
    const auto run = RunMission(*place, options, std::stop_token());
    ASSERT_TRUE(run.ok()) << run.status();
    EXPECT_EQ(run->outcome, MissionOutcome::kArrived) << run->why;
    EXPECT_TRUE(run->goal_error.IsRight());
    for (const simulator::SimEvent& event : run->record.events) {
      if (event.kind != simulator::SimEventKind::kCollision ||
          !event.caused_by_robot) {
        continue;
      }
      // The cafe's waiter minds nobody, and walks into a robot that has all but
      // stopped. docs/reference/suites.md counts that against the robot, too.
      EXPECT_EQ(event.what, "waiter");
      EXPECT_LT(event.robot_approach_mps, 0.05);
    }
    EXPECT_EQ(run->stair_entries + run->edge_entries, 0);
    // Something stood in the way, in two of them.
    EXPECT_EQ(run->surprise.empty(), scene == "slope") << run->surprise;
  }
}

TEST(RunMissionTest, TwoRunsAreTheSame) {
  const auto place = Cafe(false);
  MissionOptions options;
  options.seed = 1001;
  const auto first = RunMission(*place, options, std::stop_token());
  const auto second = RunMission(*place, options, std::stop_token());
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(first->record.final_state.world_from_base.translation,
            second->record.final_state.world_from_base.translation);
  EXPECT_EQ(first->simulated_s, second->simulated_s);
  EXPECT_EQ(first->driven_m, second->driven_m);
}

TEST(RunMissionTest, AnInterruptEndsIt) {
  const auto place = Cafe(false);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(RunMission(*place, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(SuiteJobsTest, KeepsTheOrderAndWhatIsDone) {
  std::stop_source stop;
  const auto results =
      suites::RunJobs<int>(20, 3, "jobs", true, stop.get_token(),
                           [&](size_t i) -> absl::StatusOr<int> {
                             if (i == 7) return absl::InternalError("seven");
                             return static_cast<int>(i);
                           });
  ASSERT_EQ(results.done.size(), 19u);
  EXPECT_EQ(results.errors, 1);
  EXPECT_EQ(results.done[6], 6);
  EXPECT_EQ(results.done[7], 8);
  EXPECT_THAT(std::string(results.first_error.message()), HasSubstr("seven"));
  const auto interrupted =
      suites::RunJobs<int>(20, 1, "jobs", true, stop.get_token(),
                           [&](size_t i) -> absl::StatusOr<int> {
                             if (i == 2) stop.request_stop();
                             if (stop.stop_requested())
                               return absl::CancelledError();
                             return static_cast<int>(i);
                           });
  EXPECT_THAT(interrupted.done, ElementsAre(0, 1));
  EXPECT_EQ(
      suites::SuiteStatus(2, 20, 1, 0, 0, absl::OkStatus(), stop.get_token())
          .code(),
      absl::StatusCode::kCancelled);
  EXPECT_EQ(suites::SuiteStatus(20, 20, 0.95, 0.99, 0, absl::OkStatus(),
                                std::stop_token())
                .code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(suites::SuiteStatus(20, 20, 0.95, 0, 0, absl::OkStatus(),
                                  std::stop_token())
                  .ok());
}

TEST(SuiteJobsTest, ReadsSeeds) {
  EXPECT_THAT(*suites::ParseSeedList("3-5,9"), ElementsAre(3u, 4u, 5u, 9u));
  for (const char* text : {"", "x", "5-3", "1-99999", "1-2-3", "1,"}) {
    EXPECT_FALSE(suites::ParseSeedList(text).ok()) << text;
  }
}

TEST(MissionReportTest, SaysWhatFailedWithItsSeed) {
  MissionRun good;
  good.world = "cafe";
  good.seed = 1;
  good.outcome = MissionOutcome::kArrived;
  good.mission.route.way_m = 5;
  MissionRun hit = good;
  hit.seed = 2;
  hit.collisions_of_robot = 1;
  hit.collisions = 2;
  MissionRun lost = good;
  lost.seed = 3;
  lost.outcome = MissionOutcome::kFailed;
  lost.cause = core::NavigationCause::kNoPath;
  lost.why = "no \"way\"";
  const std::vector<MissionRun> runs = {good, hit, lost};
  EXPECT_NEAR(suites::GoodShare(runs), 1.0 / 3, 1e-12);
  const std::string text = MissionSummary(runs, 4);
  EXPECT_THAT(text, HasSubstr("cafe seed 2: arrived"));
  EXPECT_THAT(text, HasSubstr("cafe seed 3: failed (no_path)"));
  EXPECT_THAT(text, HasSubstr("1 of 4 missions were not run"));
  const std::string json = MissionJson(runs, 4, true, {});
  EXPECT_THAT(json, HasSubstr("\"good\": 1,"));
  EXPECT_THAT(json, HasSubstr("\"collisions_by_robot\": 1,"));
  EXPECT_THAT(json, HasSubstr("no \\\"way\\\""));
}

}  // namespace
}  // namespace treeline::missions
