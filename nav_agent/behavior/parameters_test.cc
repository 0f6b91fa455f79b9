#include "nav_agent/behavior/parameters.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

TEST(BehaviorParameters, HaveANameOfTheirOwnAndSayWhy) {
  std::set<std::string> seen;
  for (const base::ParameterRow& row : BehaviorParameters()) {
    // One name may be of several units: a limit of a way, and of a turn.
    const std::string key = std::string(row.name) + " " + std::string(row.unit);
    EXPECT_TRUE(seen.insert(key).second) << key;
    EXPECT_FALSE(row.why.empty()) << key;
    EXPECT_FALSE(row.value.empty()) << key;
  }
}

TEST(BehaviorParameters, ListWhatTheFolderIsTunedBy) {
  std::set<std::string> names;
  for (const base::ParameterRow& row : BehaviorParameters()) {
    names.insert(std::string(row.name));
  }
  EXPECT_TRUE(names.contains("min_fix_confidence"));
  EXPECT_TRUE(names.contains("settle"));
  EXPECT_TRUE(names.contains("deadline_note"));
}

// More than this is not wanted: what follows from the robot's measures or from
// another constant is derived.
TEST(BehaviorParameters, FewAreTuned) {
  const std::vector<base::ParameterRow> rows = BehaviorParameters();
  EXPECT_LE(std::ranges::count(rows, base::ParameterOrigin::kTuned,
                               &base::ParameterRow::origin),
            90);
}

// What follows from others keeps to them.
TEST(BehaviorParameters, DerivedOnesAreWhatTheyFollowTo) {
  EXPECT_EQ(kStandstillSpeed_mps, 0.01);
  EXPECT_NEAR(kStandstillYawRate_radps, 0.0233, 1e-4);
  EXPECT_EQ(kFixSearch_m, 0.15);
  EXPECT_EQ(kPairAngle_rad, 0.15);
  EXPECT_EQ(kFixSearch_rad, 0.075);
  EXPECT_EQ(kMinFixStd_rad, 0.04);
  EXPECT_EQ(kMaxFixStd_rad, 0.15);
  EXPECT_EQ(kSecondView_rad, 0.6);
  EXPECT_EQ(kSecondViewWidth_rad, 0.3);
  EXPECT_EQ(kRecoveryMove_mps, 0.15);
  EXPECT_EQ(kTurnGain_per_s, 2);
  EXPECT_EQ(kTurnTolerance_rad, 0.1);
  EXPECT_EQ(kViewEdgeSlack_rad, 0.1);
  EXPECT_NEAR(kConfirmNoRoom_s, 3.9, 0.05);
  EXPECT_EQ(kMaxBadScans, 12);
  EXPECT_EQ(kRestoredVariance, 0.01);
  EXPECT_EQ(kMaxPictureAge_s, 0.2);
  EXPECT_EQ(kMaxServerSearch_s, 90);
  EXPECT_EQ(kMaxWaitingFixes, 8u);
  EXPECT_EQ(kControlRate_hz, 40);
  EXPECT_EQ(kMaxFutureStamp_s, 0.05);
  EXPECT_EQ(kOdometryTimeout_s, 0.2);
  EXPECT_EQ(kBackUpTolerance_m, 0.02);
  EXPECT_EQ(kLaserTimeout_s, 0.3);
  EXPECT_EQ(kPlanIterations, 20000);
  EXPECT_EQ(kFirstPlanIterations, 2000);
  EXPECT_EQ(kMinSeeThroughHeight_m, 0.1);
  EXPECT_EQ(kMaxSeeThroughHeight_m, 0.6);
  EXPECT_EQ(kMaxPlan_s, 10);
  EXPECT_EQ(kGoalWait_s, 10);
  EXPECT_EQ(kMinProgress_m, 0.15);
  EXPECT_EQ(kRerouteRadius_m, 0.3);
  EXPECT_EQ(kBackUp_mps, 0.15);
  EXPECT_NEAR(kLookAround_radps, 0.58, 0.005);
  EXPECT_EQ(kMaxGivenBack, 30);
  EXPECT_EQ(kNobodyMovedFor_s, 8);
  EXPECT_EQ(kQuietMoment_s, 1.5);
  EXPECT_EQ(kBlockageMargin_m, 0.15);
  EXPECT_EQ(kMinBlockageRadius_m, 0.1);
  EXPECT_EQ(kObstacleNear_m, 0.6);
  EXPECT_EQ(kMaxConfirmStd_m, 0.3);
  EXPECT_EQ(kMaxConfirmDrift_m, 0.6);
  EXPECT_EQ(kMaxSearchLostProbability, 0.2);
  EXPECT_EQ(kSearchShare, 0.95);
  EXPECT_EQ(kPictureSettle_s, 0.3);
  EXPECT_EQ(kMinPromise, 0.06);
  EXPECT_EQ(kCheckAgree_m, 0.3);
  EXPECT_EQ(kCheckAgree_rad, 0.15);
  EXPECT_EQ(kCheckInTrouble_s, 5);
  EXPECT_EQ(kMaxDrift_m, 0.7);
  EXPECT_EQ(kMaxDrift_rad, 0.35);
  EXPECT_EQ(kWaitForMoving_s, 8);
  EXPECT_EQ(kLongestWait_s, 24);
  EXPECT_EQ(kMaxBlockageMemory_s, 240);
  EXPECT_EQ(kAllWell_s, 0.3);
  EXPECT_EQ(kTiltMargin_rad, 0.06);
  EXPECT_EQ(kLevelGround_rad, 0.06);
  EXPECT_EQ(kMaxFixHeight_m, 0.3);
  EXPECT_EQ(kFitTurnCost_per_rad, 0.4);
  EXPECT_EQ(kConfirmExplained, 0.625);
  EXPECT_EQ(kConfirmContradicted, 0.165);
  EXPECT_NEAR(kMaxTurning_s, 11.8, 0.05);
  EXPECT_NEAR(kMaxConfirming_s, 7.9, 0.05);
  EXPECT_NEAR(kMaxSearchLeg_s, 15.7, 0.05);
  EXPECT_NEAR(kHeldMargin_rad, 0.116, 1e-3);
  EXPECT_EQ(kAskInterval_s, 4);
  EXPECT_EQ(kSearchStd_m, 0.3);
  EXPECT_EQ(kKnownShare, 0.8);
  EXPECT_DOUBLE_EQ(kMaxBackUp_s, 6);
  EXPECT_NEAR(kMaxLookAround_s, 16.2, 0.05);
  EXPECT_EQ(kMaxEstimateAge_s, 0.5);
  EXPECT_EQ(kRerouteAhead_m, 0.6);
  EXPECT_EQ(kDiscSpacing_m, 0.2);
}

}  // namespace
}  // namespace treeline::behavior
