#include "nav_agent/localization/parameters.h"

#include <set>
#include <string>

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

TEST(LocalizationParameters, DerivedOnesAreAsTheyWereTuned) {
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
  EXPECT_EQ(kIdentityAge_s, 0.95);
  EXPECT_EQ(LaserViewOptions().laser_height_m, 0.35);
}

}  // namespace
}  // namespace treeline::localization
