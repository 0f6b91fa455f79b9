#include "nav_agent/control/parameters.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {
namespace {

TEST(ControlParameters, HaveANameOfTheirOwnAndSayWhy) {
  std::set<std::string> seen;
  for (const base::ParameterRow& row : ControlParameters()) {
    // One name may be of several units: a limit of a way, and of a turn.
    const std::string key = std::string(row.name) + " " + std::string(row.unit);
    EXPECT_TRUE(seen.insert(key).second) << key;
    EXPECT_FALSE(row.why.empty()) << key;
    EXPECT_FALSE(row.value.empty()) << key;
  }
}

// More than this is not wanted: what follows from the robot's measures or from
// another constant is derived.
TEST(ControlParameters, FewAreTuned) {
  const std::vector<base::ParameterRow> rows = ControlParameters();
  EXPECT_LE(std::ranges::count(rows, base::ParameterOrigin::kTuned,
                               &base::ParameterRow::origin),
            64);
}

// What follows from others keeps to them.
TEST(ControlParameters, DerivedOnesAreWhatTheyFollowTo) {
  EXPECT_EQ(kGroundTolerance_m, 0.1);
  EXPECT_EQ(Milliseconds(kSeenNow_s), 150);
  EXPECT_EQ(kLately_s, 0.3);
  EXPECT_EQ(kDepthLifetime_s, 0.5);
  EXPECT_EQ(kCutAtEdge_m, 0.2);
  EXPECT_EQ(kMovingMargin_m, 0.2);
  EXPECT_EQ(kInFront_m, 0.25);
  EXPECT_EQ(kMinSpeed_mps, 0.01);
  EXPECT_NEAR(kStandingTurn_radps, 0.0465, 1e-4);
  EXPECT_NEAR(kMinTurn_radps, 0.0233, 1e-4);
  EXPECT_EQ(kMinInterval_s, 0.005);
  EXPECT_EQ(kGoalGain_hz, 2);
  EXPECT_EQ(kMaxHits, 8);
  EXPECT_EQ(kDepthColumns, 120);
  EXPECT_EQ(kRestSteps, 4);
  EXPECT_EQ(kMaxBubbles, 60);
  EXPECT_EQ(kMarginPerSpeed_s, 0.05);
  EXPECT_EQ(kMaxApproach_m, 0.005);
  EXPECT_DOUBLE_EQ(kManoeuvreRoom_m, 0.06);
  EXPECT_EQ(kCreep_mps, 0.075);
  EXPECT_NEAR(kSlowTurn_radps, 0.349, 1e-3);
  EXPECT_NEAR(kGoalTurn_radps, 0.581, 1e-3);
  EXPECT_NEAR(kTurned_rad, 0.0116, 1e-4);
  EXPECT_NEAR(kProgressAngle_rad, 0.116, 1e-3);
}

TEST(ControlParameters, TheCornerIsThatOfTheRobot) {
  EXPECT_NEAR(kCorner_m, core::RobotModel().Circumradius_m(), 0.005);
}

}  // namespace
}  // namespace treeline::control
