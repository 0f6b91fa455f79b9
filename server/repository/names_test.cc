#include "server/repository/names.h"

#include <algorithm>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Names, OrdinaryNamesAreValid) {
  for (const char* name : {"redkitchen", "7scenes-red_kitchen.v2", "1", "A",
                           "2026-11-21T09.30.00Z", "-", "a..b"}) {
    EXPECT_TRUE(IsValidName(name)) << name;
  }
  EXPECT_TRUE(IsValidName(std::string(128, 'a')));
}

TEST(Names, PathsAndControlCharactersAreNot) {
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."),
        std::string(".hidden"), std::string("a/b"), std::string("../x"),
        std::string("a\\b"), std::string("a b"), std::string("a\n"),
        std::string("a\0b", 3), std::string("caf\xc3\xa9"),
        std::string(129, 'a')}) {
    EXPECT_FALSE(IsValidName(name)) << name;
    EXPECT_EQ(CheckName("scene", name).code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(Names, ErrorsNameTheFieldAndStayPrintableAndShort) {
  const absl::Status status = CheckName("scene", "a\nb" + std::string(99, 'c'));
  EXPECT_THAT(std::string(status.message()), HasSubstr("scene: "));
  EXPECT_THAT(std::string(status.message()), HasSubstr("a\\nb"));
  const absl::Status huge = CheckName("scene", std::string(10 << 20, '\xff'));
  EXPECT_LT(huge.message().size(), 300u);
}

std::vector<std::string> OldestFirst(std::vector<std::string> versions) {
  std::sort(versions.begin(), versions.end(),
            [](const auto& a, const auto& b) { return VersionIsOlder(a, b); });
  return versions;
}

TEST(Versions, NumbersCompareAsNumbers) {
  EXPECT_THAT(OldestFirst({"10", "9", "100", "0", "2"}),
              ElementsAre("0", "2", "9", "10", "100"));
}

TEST(Versions, NumbersMayBeLongerThan64Bits) {
  EXPECT_TRUE(VersionIsOlder("99999999999999999999999999",
                             "100000000000000000000000000"));
  EXPECT_FALSE(VersionIsOlder("100000000000000000000000000",
                              "99999999999999999999999999"));
}

TEST(Versions, LeadingZerosDoNotCountButBreakTies) {
  EXPECT_TRUE(VersionIsOlder("0009", "10"));
  EXPECT_TRUE(VersionIsOlder("07", "7"));
  EXPECT_FALSE(VersionIsOlder("7", "07"));
  EXPECT_FALSE(VersionIsOlder("00", "00"));
}

TEST(Versions, OthersCompareByBytesAndAreNewerThanNumbers) {
  EXPECT_THAT(OldestFirst({"v1", "2026-02-01", "12", "2026-01-31", "beta"}),
              ElementsAre("12", "2026-01-31", "2026-02-01", "beta", "v1"));
}

}  // namespace
}  // namespace treeline::repository
