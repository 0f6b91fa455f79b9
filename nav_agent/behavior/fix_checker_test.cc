#include "nav_agent/behavior/fix_checker.h"

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization_behavior.h"

namespace treeline::behavior {
namespace {

class FixCheckerTest : public testing::Test {
 protected:
  FixCheckerTest() { tracker_.now = At(100); }

  GatedFix Check(const geometry::Rigid3& map_from_base) const {
    core::RelocalizationAnswer answer;
    answer.localized = true;
    answer.confidence = 0.97;
    answer.map_from_camera = map_from_base * robot_.base_from_camera;
    return checker_.Check(answer, *tracker_.Motion(), tracker_);
  }

  core::RobotModel robot_;
  ScriptedTracker tracker_;
  FixChecker checker_{std::make_shared<const traversability::NavigationMap>(
                          *traversability::NavigationMap::Make(TwoRooms())),
                      robot_, FixGateOptions()};
};

TEST_F(FixCheckerTest, TakesAFixWhereTheRobotIs) {
  const GatedFix fix = Check(Lift(tracker_.truth, 0.02));
  EXPECT_EQ(fix.verdict, FixVerdict::kSure) << fix.why;
  EXPECT_TRUE(fix.is_server_sure);
  EXPECT_LT(geometry::Norm(fix.pose.map_from_base.translation -
                           tracker_.truth.translation),
            1e-6);
}

TEST_F(FixCheckerTest, MovesAFixToWhereTheScanFitsBest) {
  const geometry::Rigid2 off =
      tracker_.truth * geometry::Rigid2{{0.1, 0}, 0.04};
  const GatedFix fix = Check(Lift(off, 0.02));
  EXPECT_EQ(fix.verdict, FixVerdict::kSure) << fix.why;
  const auto error_m = [this](const geometry::Rigid2& pose) {
    return geometry::Norm(pose.translation - tracker_.truth.translation);
  };
  EXPECT_LT(error_m(fix.pose.map_from_base), 0.5 * error_m(off));
}

TEST_F(FixCheckerTest, CarriesTheScanBackToTheFramesMoment) {
  // The robot has driven on since the frame; the tracker's scan is of now.
  core::RelocalizationAnswer answer;
  answer.localized = true;
  answer.confidence = 0.97;
  const geometry::Rigid2 then = tracker_.truth;
  const localization::TrackedMotion motion = *tracker_.Motion();
  tracker_.Move(1, {.forward_mps = 0.5, .yaw_rate_radps = 0.3});
  answer.map_from_camera = Lift(then, 0.02) * robot_.base_from_camera;
  const GatedFix fix = checker_.Check(answer, motion, tracker_);
  EXPECT_EQ(fix.verdict, FixVerdict::kSure) << fix.why;
  EXPECT_LT(
      geometry::Norm(fix.pose.map_from_base.translation - then.translation),
      1e-6);
}

TEST_F(FixCheckerTest, AsksTheMapForRoom) {
  EXPECT_EQ(Check(Lift({{6.5, 3}, 0}, 0)).verdict, FixVerdict::kNotOnGround);
  EXPECT_EQ(Check(Lift({{0.2, 3}, 0}, 0)).verdict, FixVerdict::kNotOnGround);
  EXPECT_EQ(Check(Lift(tracker_.truth, 0.8)).verdict, FixVerdict::kNotOnGround);
}

// What a trolley left on the map, beside where the robot is: no room for it,
// and no beam ends there.
TEST_F(FixCheckerTest, IsNotKeptFromWhereTheScanSeesThroughTheMap) {
  traversability::TraversableMap map = TwoRooms();
  for (int x = 26; x < 56; ++x) {
    map.levels[0].grid.Set({x, 58}, core::Occupancy::kOccupied);
  }
  const FixChecker checker(
      std::make_shared<const traversability::NavigationMap>(
          *traversability::NavigationMap::Make(map)),
      robot_, FixGateOptions());
  core::RelocalizationAnswer answer;
  answer.localized = true;
  answer.confidence = 0.97;
  answer.map_from_camera = Lift(tracker_.truth, 0.02) * robot_.base_from_camera;
  const GatedFix fix = checker.Check(answer, *tracker_.Motion(), tracker_);
  EXPECT_EQ(fix.verdict, FixVerdict::kWeak) << fix.why;
  EXPECT_EQ(fix.pose.place.level, 0);
  // Somewhere else the same beams would pass, but they would not fit.
  tracker_.best_fit = 0.7;
  EXPECT_EQ(checker.Check(answer, *tracker_.Motion(), tracker_).verdict,
            FixVerdict::kNotOnGround);
}

TEST_F(FixCheckerTest, AsksTheInertialSensor) {
  EXPECT_EQ(Check({.rotation = geometry::Rotation3::FromAxisAngle({0.2, 0, 0}),
                   .translation = {2, 3, 0}})
                .verdict,
            FixVerdict::kAgainstGravity);
}

TEST_F(FixCheckerTest, DoesNotTakeAWorsePlaceThanWhereItThoughtItWas) {
  // So far off the map explains what may pass, but the belief is right.
  const geometry::Rigid3 off =
      Lift(tracker_.truth * geometry::Rigid2{{0.75, 0}, 0}, 0.02);
  EXPECT_EQ(Check(off).verdict, FixVerdict::kWeak);
  tracker_.believed =
      core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
  EXPECT_EQ(Check(off).verdict, FixVerdict::kAgainstScan);
}

}  // namespace
}  // namespace treeline::behavior
