#include "nav_agent/app/zones/zones_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace treeline::zones_app {
namespace {

using ::testing::HasSubstr;

v1::Zone Triangle(const std::string& name, v1::ZoneKind kind) {
  v1::Zone zone;
  zone.set_name(name);
  zone.set_kind(kind);
  for (const auto& [x_m, y_m] :
       {std::pair{0.0, 0.5}, {-2.25, 0.0}, {3.0, 4.0}}) {
    v1::ZoneCorner& corner = *zone.add_corners();
    corner.set_x_m(x_m);
    corner.set_y_m(y_m);
  }
  return zone;
}

TEST(ZonesYamlTest, WhatIsWrittenIsRead) {
  std::vector<v1::Zone> zones = {
      Triangle("stairs: \"up\"", v1::ZONE_KIND_KEEP_OUT),
      Triangle("slow", v1::ZONE_KIND_SPEED),
      Triangle("this way", v1::ZONE_KIND_ONE_WAY)};
  zones[0].set_level(1);
  zones[1].set_max_mps(0.3);
  zones[2].set_direction_rad(-1.5);
  const auto read = ParseZones(ZonesText(zones), "a.yaml");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), zones.size());
  for (size_t i = 0; i < zones.size(); ++i) {
    EXPECT_EQ((*read)[i].ShortDebugString(), zones[i].ShortDebugString());
  }
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
