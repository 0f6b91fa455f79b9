#include "nav_agent/localization/parameters.h"

#include <set>
#include <string>

#include "gtest/gtest.h"

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
}

}  // namespace
}  // namespace treeline::localization
