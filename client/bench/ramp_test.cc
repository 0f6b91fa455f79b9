#include "client/bench/ramp.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(ParseRamp, GrowsToItsEnd) {
  EXPECT_THAT(ParseRamp("10:50:+20").value(), ElementsAre(10, 30, 50));
  EXPECT_THAT(ParseRamp("1:10:x2").value(), ElementsAre(1, 2, 4, 8, 10));
  EXPECT_THAT(ParseRamp("5:5:+1").value(), ElementsAre(5));
  EXPECT_THAT(ParseRamp("5,20,80").value(), ElementsAre(5, 20, 80));
  EXPECT_THAT(ParseRamp("7").value(), ElementsAre(7));
  // Three tenths are no thirty steps and one.
  EXPECT_THAT(ParseRamp("0.1:0.3:+0.1").value(),
              ElementsAre(DoubleEq(0.1), DoubleEq(0.2), DoubleEq(0.3)));
}

TEST(ParseRamp, SaysWhatIsWrong) {
  for (const char* text :
       {"", "a", "0", "-5", "10:50", "10:50:20", "10:50:*2", "50:10:+5",
        "1:10:x1", "1:10:+0", "5,5", "9,3", "1:10:+1:2", "nan", "1:inf:+1"}) {
    const absl::Status status = ParseRamp(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("FROM:TO:+STEP"));
  }
  EXPECT_THAT(std::string(ParseRamp("1:1000:+1").status().message()),
              HasSubstr("200"));
  EXPECT_THAT(ParseRamp("1:200:+1").value(), SizeIs(200));
}

}  // namespace
}  // namespace treeline::bench
