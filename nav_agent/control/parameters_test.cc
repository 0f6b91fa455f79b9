#include "nav_agent/control/parameters.h"

#include <set>
#include <string>

#include "gtest/gtest.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"

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

// What follows from others keeps to them.
TEST(ControlParameters, DerivedOnesAreAsTheyWereTuned) {
  EXPECT_EQ(kGroundTolerance_m, 0.1);
  EXPECT_EQ(Milliseconds(kSeenNow_s), 150);
  EXPECT_EQ(kLately_s, 0.3);
  EXPECT_EQ(kDepthLifetime_s, 0.5);
  EXPECT_EQ(kCutAtEdge_m, 0.2);
  EXPECT_EQ(kMovingMargin_m, 0.2);
  EXPECT_EQ(kInFront_m, 0.25);
  EXPECT_EQ(kMinSpeed_mps, 0.006);
  EXPECT_EQ(kMinTurn_radps, 0.015);
  EXPECT_EQ(kMinInterval_s, 0.005);
  EXPECT_EQ(kGoalGain_hz, 2);
}

}  // namespace
}  // namespace treeline::control
