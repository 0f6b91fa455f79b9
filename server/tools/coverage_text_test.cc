#include "server/tools/coverage_text.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::tools {
namespace {

using testing::Contains;
using testing::Pair;

// Two open places of four, with two of four headings good, and one weak.
keyframes::CoverageMap SmallCoverage() {
  return {.min_x_m = -1,
          .min_y_m = 2,
          .cell_m = 0.5,
          .columns = 2,
          .rows = 2,
          .headings = 4,
          .height_m = 1.5,
          .ground_m = 0.25,
          .places = {{.is_open = true, .good = 0b0011, .weak = 0b0100},
                     {},
                     {.is_open = true},
                     {}}};
}

TEST(CoverageTextTest, JsonHasTheGridRowByRow) {
  const auto json = nlohmann::json::parse(CoverageJson(SmallCoverage()));
  EXPECT_EQ(json["min_x_m"], -1);
  EXPECT_EQ(json["cell_m"], 0.5);
  EXPECT_EQ(json["plan_from_world"]["qw"], 1);
  EXPECT_EQ(json["headings_deg"], (nlohmann::json{0.0, 90.0, 180.0, 270.0}));
  EXPECT_EQ(json["open"], nlohmann::json::parse("[[1, 0], [1, 0]]"));
  EXPECT_EQ(json["good"], nlohmann::json::parse("[[3, 0], [0, 0]]"));
  EXPECT_EQ(json["weak"], nlohmann::json::parse("[[4, 0], [0, 0]]"));
  EXPECT_EQ(json["summary"]["open_m2"], 0.5);
  EXPECT_EQ(json["summary"]["good_share"], 0.25);
  EXPECT_EQ(json["summary"]["weak_share"], 0.125);
  EXPECT_EQ(json["summary"]["any_heading_share"], 0.5);
  EXPECT_EQ(json["summary"]["all_headings_share"], 0);
}

TEST(CoverageTextTest, WordsSayHowMuchIsAnswered) {
  const DescriptionSection section = DescribeCoverage(SmallCoverage());
  EXPECT_THAT(section.rows,
              Contains(Pair("views answered", "25 % good, 12 % perhaps")));
  EXPECT_THAT(
      section.rows,
      Contains(Pair("of cameras", "1.25 m above the ground, tilted +0 deg")));
}

}  // namespace
}  // namespace treeline::tools
