#include "server/core/localizer/parameters.h"

#include <set>
#include <string_view>

#include "gtest/gtest.h"
#include "server/core/features/parameters.h"
#include "server/core/keyframes/parameters.h"
#include "server/core/pose/parameters.h"

namespace treeline::localizer {
namespace {

TEST(ParametersTest, EveryOneHasANameOfItsOwnAndSaysWhy) {
  for (const std::vector<base::ParameterRow>& table :
       {features::FeatureParameters(), keyframes::KeyframeParameters(),
        pose::PoseParameters(), LocalizerParameters()}) {
    std::set<std::string_view> names;
    for (const base::ParameterRow& row : table) {
      EXPECT_TRUE(names.insert(row.name).second) << row.name;
      EXPECT_FALSE(row.why.empty()) << row.name;
      EXPECT_FALSE(row.value.empty()) << row.name;
    }
    EXPECT_GE(names.size(), 10u);
  }
}

}  // namespace
}  // namespace treeline::localizer
