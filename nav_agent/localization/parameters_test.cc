#include "nav_agent/localization/parameters.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/localization/laser_views.h"

namespace treeline::localization {
namespace {

TEST(LocalizationParameters, HaveANameOfTheirOwnAndSayWhy) {
  std::set<std::string> seen;
  for (const base::ParameterRow& row : LocalizationParameters()) {
    // One name may be of several units: a limit of a way, and of a turn.
    const std::string key = std::string(row.name) + " " + std::string(row.unit);
    EXPECT_TRUE(seen.insert(key).second) << key;
    EXPECT_FALSE(row.why.empty()) << key;
    EXPECT_FALSE(row.value.empty()) << key;
  }
}

// More than this is not wanted: what follows from the robot's measures or from
// another constant is derived.
TEST(LocalizationParameters, FewAreTuned) {
  const std::vector<base::ParameterRow> rows = LocalizationParameters();
  EXPECT_LE(std::ranges::count(rows, base::ParameterOrigin::kTuned,
                               &base::ParameterRow::origin),
            59);
}

TEST(LocalizationParameters, DerivedOnesAreWhatTheyFollowTo) {
  EXPECT_EQ(kBeamGround_m, 0.1);
  EXPECT_EQ(kViewDirections, 240);
  EXPECT_EQ(kSectors, 120u);
  EXPECT_EQ(kViewOpaqueShare, 0.75);
  EXPECT_EQ(kIndependentBeams, 20);
  EXPECT_EQ(kRegularization_rad, 0.05);
  EXPECT_EQ(kRefineTurnPerStep, 0.5);
  EXPECT_EQ(kParticlesAtOnce, 10000u);
  EXPECT_EQ(kFloorHeight_m, 0.6);
  EXPECT_EQ(kHeightTolerance_m, 0.2);
  EXPECT_EQ(kMaxEvidenceAgainst, 2);
  EXPECT_EQ(kMaxLogOdds, 8);
  EXPECT_EQ(kJumpAge_s, 0.5);
  EXPECT_EQ(kIdentityAge_s, 1);
  EXPECT_DOUBLE_EQ(kScanMemory_s, 1.27);
  EXPECT_DOUBLE_EQ(kSearchingInterval_s, 0.27);
  EXPECT_EQ(kMaxScanAhead_s, 0.045);
  EXPECT_EQ(kWitnessParticles, 250u);
  EXPECT_EQ(kRegularization_m, 0.1);
  EXPECT_EQ(kRangeTolerance_m, 0.2);
  EXPECT_EQ(kMaxResidual_m, 0.25);
  EXPECT_EQ(kFieldReach_m, 0.7);
  EXPECT_DOUBLE_EQ(kGroundEnd_m, 0.15);
  EXPECT_EQ(kCheckedBeams, 120);
  EXPECT_EQ(kSearchHeadings, 50);
  EXPECT_EQ(kRefineStep_m, 0.125);
  EXPECT_EQ(kDeclareLost, 0.95);
  EXPECT_EQ(kViewpoint_m, 0.5);
  EXPECT_EQ(kViewpoint_rad, 0.4);
  EXPECT_EQ(kViewpointEvidence, 2);
  EXPECT_EQ(kExcludePlace, 16);
  EXPECT_EQ(kSearchWithin, 0.5);
  EXPECT_EQ(kMinViewpointBeams, 10u);
  EXPECT_EQ(LaserViewOptions().laser_height_m, 0.35);
}

}  // namespace
}  // namespace treeline::localization
