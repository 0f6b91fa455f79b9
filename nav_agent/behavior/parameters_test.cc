#include "nav_agent/behavior/parameters.h"

#include <set>
#include <string>

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

// What follows from others keeps to them.
TEST(BehaviorParameters, DerivedOnesAreAsTheyWereTuned) {
  EXPECT_EQ(kStandstillSpeed_mps, 0.01);
  EXPECT_EQ(kStandstillYawRate_radps, 0.025);
  EXPECT_EQ(kFixSearch_m, 0.15);
  EXPECT_EQ(kFixSearch_rad, 0.06);
  EXPECT_EQ(kMinFixStd_rad, 0.04);
  EXPECT_EQ(kMaxFixStd_rad, 0.15);
  EXPECT_EQ(kSecondView_rad, 0.6);
  EXPECT_EQ(kSecondViewWidth_rad, 0.3);
  EXPECT_EQ(kRecoveryMove_mps, 0.15);
  EXPECT_EQ(kTurnGain_per_s, 2);
  EXPECT_EQ(kTurnTolerance_rad, 0.1);
  EXPECT_EQ(kViewEdgeSlack_rad, 0.1);
  EXPECT_EQ(kConfirmNoRoom_s, 4);
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
  EXPECT_EQ(kBackUp_mps, 0.12);
  EXPECT_EQ(kLookAround_radps, 0.6);
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
  EXPECT_EQ(kCheckAgree_rad, 0.12);
  EXPECT_EQ(kMaxDrift_rad, 0.35);
  EXPECT_EQ(kWaitForMoving_s, 8);
  EXPECT_EQ(kLongestWait_s, 24);
  EXPECT_EQ(kMaxBlockageMemory_s, 240);
  EXPECT_EQ(kAllWell_s, 0.3);
  EXPECT_EQ(kTiltMargin_rad, 0.06);
  EXPECT_EQ(kLevelGround_rad, 0.06);
}

}  // namespace
}  // namespace treeline::behavior
