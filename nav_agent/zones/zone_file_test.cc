#include "nav_agent/zones/zone_file.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::zones {
namespace {

using testing::HasSubstr;

std::vector<Zone> SomeZones() {
  return {{.name = "the stairs, by the lift",
           .kind = ZoneKind::kKeepOut,
           .level = 1,
           .corners_in_map = {{0.1, -1e-9}, {2.0 / 3, 0}, {2, 1e5}}},
          {.name = "café",
           .kind = ZoneKind::kSpeed,
           .level = 0,
           .corners_in_map = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
           .max_mps = 0.3},
          {.name = "door",
           .kind = ZoneKind::kOneWay,
           .level = 0,
           .corners_in_map = {{0, 0}, {1, 0}, {1, 1}},
           .direction_rad = -3.0}};
}

TEST(ZoneFileTest, ReadsWhatItWritesBitForBit) {
  EXPECT_EQ(*ParseZoneFile(ZoneFileText(SomeZones())), SomeZones());
  EXPECT_TRUE(ParseZoneFile(ZoneFileText({}))->empty());
}

TEST(ZoneFileTest, WhateverIsCutOffOrChangedIsNoticed) {
  const std::string text = ZoneFileText(SomeZones());
  for (size_t bytes = 0; bytes < text.size(); ++bytes) {
    EXPECT_FALSE(ParseZoneFile(text.substr(0, bytes)).ok()) << bytes;
  }
  for (size_t i = 0; i < text.size(); ++i) {
    for (const char with : {'0', '7', ' ', '\n', 'x'}) {
      std::string changed = text;
      if (changed[i] == with) continue;
      changed[i] = with;
      EXPECT_FALSE(ParseZoneFile(changed).ok()) << i << " " << with;
    }
  }
  EXPECT_FALSE(ParseZoneFile(text + "x").ok());
  EXPECT_THAT(std::string(ParseZoneFile(text.substr(0, 40)).status().message()),
              HasSubstr("not all of one"));
}

TEST(ZoneFileTest, SomethingElseIsNone) {
  for (const char* other :
       {"", "\n", "treeline-stop 1\nreleased\n\nend\n",
        "treeline-zones 2\nend 0 0\n", "treeline-zones 1\n\n"}) {
    EXPECT_EQ(ParseZoneFile(other).status().code(),
              absl::StatusCode::kInvalidArgument)
        << other;
  }
}

}  // namespace
}  // namespace treeline::zones
