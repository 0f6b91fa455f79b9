#include "nav_agent/app/zones/zones_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace treeline::zones_app {
namespace {

using ::testing::HasSubstr;

zones::Zone Triangle(const std::string& name, zones::ZoneKind kind) {
  return {.name = name,
          .kind = kind,
          .level = 0,
          .corners_in_map = {{0, 0.5}, {-2.25, 0}, {3, 4}}};
}

TEST(ZonesYamlTest, WhatIsWrittenIsRead) {
  std::vector<zones::Zone> zones = {
      Triangle("stairs: \"up\"", zones::ZoneKind::kKeepOut),
      Triangle("slow", zones::ZoneKind::kSpeed),
      Triangle("this way", zones::ZoneKind::kOneWay)};
  zones[0].level = 1;
  zones[1].max_mps = 0.3;
  zones[2].direction_rad = -1.5;
  const auto read = ParseZones(ZonesText(zones), "a.yaml");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, zones);
}

TEST(ZonesYamlTest, MistakesAreNamedWithTheirLine) {
  const auto why = [](const std::string& text) {
    return std::string(ParseZones(text, "a.yaml").status().message());
  };
  const std::string corners = "    corners: [[0, 0], [1, 0], [1, 1]]\n";
  EXPECT_THAT(why("zones:\n  - name: a\n    kind: keepout\n" + corners),
              HasSubstr("keep-out"));
  EXPECT_THAT(why("zones:\n  - name: a\n    kind: speed\n" + corners),
              HasSubstr("max_mps"));
  EXPECT_THAT(why("zones:\n  - name: a\n    kind: one-way\n" + corners),
              HasSubstr("direction"));
  EXPECT_THAT(why("zones:\n  - name: a\n    kind: keep-out\n"),
              HasSubstr("a.yaml:2: a zone needs 3 corners"));
  EXPECT_THAT(why("zones:\n  - name: a\n    kind: keep-out\n"
                  "    corners: [[0, 0], [1], [1, 1]]\n"),
              HasSubstr("a.yaml:4"));
  EXPECT_THAT(why("zones: []\n"), HasSubstr("no zones"));
  EXPECT_THAT(why("masks: []\n"), HasSubstr("unknown key 'masks'"));
}

}  // namespace
}  // namespace treeline::zones_app
