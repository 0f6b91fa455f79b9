#include "nav_agent/zones/zone.h"

#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::zones {
namespace {

using testing::HasSubstr;

Zone Square() {
  return {.name = "stairs",
          .kind = ZoneKind::kKeepOut,
          .level = 0,
          .corners_in_map = {{0, 0}, {2, 0}, {2, 2}, {0, 2}}};
}

void ExpectRefused(const Zone& zone, const std::string& why) {
  const absl::Status status = CheckZone(zone, 2);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(why));
}

TEST(ZoneTest, ASquareEitherWayRoundIsOne) {
  Zone zone = Square();
  EXPECT_TRUE(CheckZone(zone, 1).ok());
  std::ranges::reverse(zone.corners_in_map);
  EXPECT_TRUE(CheckZone(zone, 1).ok());
  EXPECT_TRUE(Contains(zone, {1, 1}));
  EXPECT_FALSE(Contains(zone, {3, 1}));
  EXPECT_FALSE(Contains(zone, {1, -0.1}));
}

TEST(ZoneTest, CornersMustBeNumbersOnAMap) {
  for (const double bad :
       {std::nan(""), std::numeric_limits<double>::infinity(), 1e6, -1e300}) {
    Zone zone = Square();
    zone.corners_in_map[2].y = bad;
    ExpectRefused(zone, "zone 'stairs' has corner 3");
  }
  Zone zone = Square();
  zone.corners_in_map.resize(2);
  ExpectRefused(zone, "2 corners");
  zone.corners_in_map.assign(101, {});
  ExpectRefused(zone, "101 corners");
  zone = Square();
  zone.corners_in_map.insert(zone.corners_in_map.begin(), {0, 0});
  ExpectRefused(zone, "corners 1 and 2 at the same place");
}

TEST(ZoneTest, APolygonThatCrossesOrTouchesItselfIsRefused) {
  Zone zone = Square();
  std::swap(zone.corners_in_map[1], zone.corners_in_map[2]);
  ExpectRefused(zone, "crosses itself: the sides from corners");
  // There and back along one line.
  zone.corners_in_map = {{0, 0}, {2, 0}, {1, 0}};
  ExpectRefused(zone, "crosses itself");
  // A corner on the side opposite.
  zone.corners_in_map = {{0, 0}, {4, 0}, {4, 2}, {2, 0}, {0, 2}};
  ExpectRefused(zone, "crosses itself");
  // A bay is none of these.
  zone.corners_in_map = {{0, 0}, {4, 0}, {4, 2}, {2, 0.5}, {0, 2}};
  EXPECT_TRUE(CheckZone(zone, 1).ok());
  // A corner on a straight side is no fault, either.
  zone.corners_in_map = {{0, 0}, {1, 0}, {2, 0}, {2, 2}};
  EXPECT_TRUE(CheckZone(zone, 1).ok());
}

TEST(ZoneTest, NamesLevelsSpeedsAndDirectionsMustMeanSomething) {
  Zone zone = Square();
  zone.name = "";
  ExpectRefused(zone, "0 bytes");
  zone.name = "a\nb";
  ExpectRefused(zone, "control characters");
  zone.name = std::string(65, 'x');
  ExpectRefused(zone, "65 bytes");
  zone = Square();
  zone.level = 2;
  ExpectRefused(zone, "is on level 2; the map has 0..1");
  zone = Square();
  zone.kind = ZoneKind::kSpeed;
  for (const double bad : {0.0, -1.0, 0.01, 6.0, std::nan("")}) {
    zone.max_mps = bad;
    ExpectRefused(zone, "m/s; a speed zone allows");
  }
  zone = Square();
  zone.kind = ZoneKind::kOneWay;
  zone.direction_rad = std::nan("");
  ExpectRefused(zone, "direction");
}

TEST(ZoneTest, TooManyAndTwoOfOneNameAreRefused) {
  std::vector<Zone> zones(10000, Square());
  EXPECT_THAT(std::string(CheckZones(zones, 1).message()),
              HasSubstr("10000 zones; at most 1000"));
  zones.resize(2);
  EXPECT_THAT(std::string(CheckZones(zones, 1).message()),
              HasSubstr("two zones are called 'stairs'"));
}

TEST(ZoneTest, KindsHaveNames) {
  for (const ZoneKind kind :
       {ZoneKind::kKeepOut, ZoneKind::kSpeed, ZoneKind::kOneWay}) {
    EXPECT_EQ(*ParseZoneKind(ZoneKindName(kind)), kind);
  }
  EXPECT_THAT(std::string(ParseZoneKind("keepout").status().message()),
              HasSubstr("there are keep-out, speed, one-way"));
}

}  // namespace
}  // namespace treeline::zones
