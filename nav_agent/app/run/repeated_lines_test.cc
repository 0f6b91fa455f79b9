#include "nav_agent/app/run/repeated_lines.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::run_app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(RepeatedLines, TheSameIsWrittenOnceAndCountedWhenAnotherComes) {
  RepeatedLines lines;
  const RepeatedLine door = {.kind = "blocked", .text = "a door"};
  EXPECT_THAT(lines.Next("blocked", "a door"), ElementsAre(door));
  EXPECT_THAT(lines.Next("blocked", "a door"), IsEmpty());
  EXPECT_THAT(lines.Next("blocked", "a door"), IsEmpty());
  // The same text of another kind is another line.
  EXPECT_THAT(lines.Next("plan", "a door"),
              ElementsAre(RepeatedLine{.kind = "blocked",
                                       .text = "a door (3 times in all)"},
                          RepeatedLine{.kind = "plan", .text = "a door"}));
  EXPECT_THAT(lines.Next("blocked", "a door"), ElementsAre(door));
  EXPECT_THAT(lines.Finish(), IsEmpty());
  EXPECT_THAT(lines.Next("blocked", "a door"), ElementsAre(door));
  EXPECT_THAT(lines.Next("blocked", "a door"), IsEmpty());
  EXPECT_THAT(lines.Finish(),
              ElementsAre(RepeatedLine{.kind = "blocked",
                                       .text = "a door (2 times in all)"}));
  EXPECT_THAT(lines.Finish(), IsEmpty());
}

TEST(RepeatedLines, AnEmptyFirstLineIsALine) {
  RepeatedLines lines;
  EXPECT_THAT(lines.Next("", ""), ElementsAre(RepeatedLine{}));
}

}  // namespace
}  // namespace treeline::run_app
