#include "common/base/parameter.h"

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

constexpr Parameter<double> kStep{"step", 0.05, "m", ParameterOrigin::kTuned,
                                  "half a cell"};
constexpr Parameter<int> kTries{"tries", 40, "", ParameterOrigin::kTuned, ""};
constexpr Parameter<double> kTiny{"tiny", 1e-14, "", ParameterOrigin::kPhysics,
                                  ""};

TEST(Parameter, ReadsLikeItsValue) {
  EXPECT_EQ(2 * kStep, 0.1);
  EXPECT_EQ(kTries + 1, 41);
}

TEST(Parameter, PrintsItsValueShortAndWhole) {
  EXPECT_EQ(RowOf(kStep).value, "0.05");
  EXPECT_EQ(RowOf(kTries).value, "40");
  EXPECT_EQ(RowOf(kTiny).value, "1e-14");
  EXPECT_EQ(RowOf(kStep).unit, "m");
}

}  // namespace
}  // namespace treeline::base
