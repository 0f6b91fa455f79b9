#include "common/base/checked_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check_name.h"

namespace treeline::base {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kFirst[] = "things 1";

TEST(CheckedLinesTest, ComeBackAsTheyWere) {
  const std::string text = CheckedLinesText(kFirst, {"a b", "", "end 0 0"});
  const auto lines = ParseCheckedLines(kFirst, "a file of things", text);
  ASSERT_TRUE(lines.ok()) << lines.status();
  EXPECT_THAT(*lines, ElementsAre("a b", "", "end 0 0"));
  const std::string none = CheckedLinesText(kFirst, {});
  EXPECT_THAT(*ParseCheckedLines(kFirst, "", none), IsEmpty());
}

TEST(CheckedLinesTest, EveryPartOfATextAndEveryChangedByteIsRefused) {
  const std::string text = CheckedLinesText(kFirst, {"one", "two"});
  for (size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(ParseCheckedLines(kFirst, "x", text.substr(0, size)).ok());
  }
  for (size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    EXPECT_FALSE(ParseCheckedLines(kFirst, "x", changed).ok()) << i;
  }
  const absl::Status other =
      ParseCheckedLines("stuff 1", "a file of stuff", text).status();
  EXPECT_THAT(std::string(other.message()),
              HasSubstr("not a file of stuff, or not all of one"));
}

TEST(CheckedLinesTest, WordsAndNumbersOfALine) {
  LineWords words("7 0.5 x the rest");
  int whole = 0;
  double number = 0;
  ASSERT_TRUE(words.Number(whole));
  ASSERT_TRUE(words.Number(number));
  EXPECT_EQ(whole, 7);
  EXPECT_EQ(number, 0.5);
  EXPECT_FALSE(words.Number(number));
  EXPECT_EQ(words.rest(), "the rest");
  LineWords one("end");
  EXPECT_EQ(one.Next(), "end");
  EXPECT_EQ(one.Next(), "");
}

TEST(CheckNameTest, ANameIsTextWithoutSpacesAtItsEnds) {
  EXPECT_TRUE(CheckName("Tür 2", "a door's", 64).ok());
  for (const char* bad : {"", " a", "a ", "a\nb", "a\x7f"}) {
    EXPECT_EQ(CheckName(bad, "a door's", 64).code(),
              absl::StatusCode::kInvalidArgument);
  }
  EXPECT_THAT(std::string(CheckName("abc", "a door's", 2).message()),
              HasSubstr("a door's name has 3 bytes; it needs 1 to 2"));
}

}  // namespace
}  // namespace treeline::base
