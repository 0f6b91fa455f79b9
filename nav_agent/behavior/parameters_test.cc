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
  EXPECT_TRUE(names.contains("standstill_speed"));
  EXPECT_TRUE(names.contains("deadline_note"));
}

// What follows from others keeps to them.
TEST(BehaviorParameters, DerivedOnesAreAsTheyWereTuned) {
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
