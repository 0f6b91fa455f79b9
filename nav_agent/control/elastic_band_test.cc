#include "nav_agent/control/elastic_band.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/control/footprint.h"

namespace treeline::control {
namespace {

const Footprint kBody = {.front_m = 0.3, .rear_m = 0.3, .half_width_m = 0.31};

// Posts without width, exactly.
class Posts final : public BandSpace {
 public:
  explicit Posts(std::vector<geometry::Vec2> posts, Footprint body = kBody)
      : posts_(std::move(posts)), body_(body) {}
  double FreeDistance_m(const geometry::Rigid2& map_from_base,
                        double max_distance_m) const override {
    const geometry::Rigid2 base_from_map = map_from_base.Inverse();
    double min_distance_m = max_distance_m;
    for (const geometry::Vec2& post : posts_) {
      min_distance_m =
          std::min(min_distance_m, body_.DistanceTo_m(base_from_map * post));
    }
    return min_distance_m;
  }
  geometry::Vec2 Away(geometry::Vec2 point) const override {
    geometry::Vec2 nearest = {1e9, 1e9};
    for (const geometry::Vec2& post : posts_) {
      if (geometry::Norm(point - post) < geometry::Norm(point - nearest))
        nearest = post;
    }
    const geometry::Vec2 off = point - nearest;
    return geometry::Norm(off) < 1e-9 ? geometry::Vec2{0, 1}
                                      : (1 / geometry::Norm(off)) * off;
  }

 private:
  std::vector<geometry::Vec2> posts_;
  Footprint body_;
};

std::vector<geometry::Rigid2> Line(geometry::Vec2 from, geometry::Vec2 to,
                                   int points) {
  std::vector<geometry::Rigid2> line;
  const geometry::Vec2 way = to - from;
  for (int i = 0; i < points; ++i) {
    line.push_back({.translation = from + (1.0 * i / (points - 1)) * way,
                    .yaw_rad = std::atan2(way.y, way.x)});
  }
  return line;
}

void Settle(ElasticBand& band, const BandSpace& space, int times = 100) {
  for (int i = 0; i < times; ++i) band.Relax(space);
}

double LengthOf(const ElasticBand& band) {
  double length_m = 0;
  for (size_t i = 1; i < band.bubbles().size(); ++i) {
    length_m += geometry::Norm(band.bubbles()[i].map_from_base.translation -
                               band.bubbles()[i - 1].map_from_base.translation);
  }
  return length_m;
}

TEST(ElasticBand, ContractsToAStraightLine) {
  std::vector<geometry::Rigid2> corner = Line({0, 0}, {1, 1}, 6);
  const std::vector<geometry::Rigid2> rest = Line({1.2, 0.8}, {2, 0}, 5);
  corner.insert(corner.end(), rest.begin(), rest.end());
  ElasticBand band({});
  band.Set(corner);
  Settle(band, Posts({}), 300);
  EXPECT_NEAR(LengthOf(band), 2.0, 0.02);
  EXPECT_FALSE(band.FirstBreak(Posts({})).has_value());
}

TEST(ElasticBand, KeepsItsDistanceWhereThereIsRoom) {
  // A post 0.4 m beside the line would leave 9 cm.
  const Posts space({{1.5, 0.4}});
  ElasticBand band({});
  band.Set(Line({0, 0}, {3, 0}, 16));
  Settle(band, space);
  EXPECT_FALSE(band.FirstBreak(space).has_value());
  double min_distance_m = 1;
  for (const BandBubble& bubble : band.bubbles()) {
    min_distance_m = std::min(min_distance_m, bubble.radius_m);
  }
  EXPECT_GT(min_distance_m, 0.2);
  EXPECT_LT(LengthOf(band), 3.15);
}

TEST(ElasticBand, IsCentredInADoor) {
  // 0.8 m wide; the path leads through it 6 cm off its middle.
  const Posts space({{1.5, 0.46}, {1.5, -0.34}});
  ElasticBand band({});
  band.Set(Line({0, 0}, {3, 0}, 31));
  Settle(band, space);
  EXPECT_FALSE(band.FirstBreak(space).has_value());
  for (const BandBubble& bubble : band.bubbles()) {
    const geometry::Vec2 at = bubble.map_from_base.translation;
    if (std::abs(at.x - 1.5) < 0.2) {
      EXPECT_NEAR(at.y, 0.06, 0.025) << at.x;
    }
  }
}

// eband: a typo used the force's x for both components.
TEST(ElasticBand, ForcesPushAlongBothAxesAlike) {
  ElasticBand along_x({});
  along_x.Set(Line({0, 0}, {3, 0}, 16));
  Settle(along_x, Posts({{1.5, 0.4}}), 20);
  ElasticBand along_y({});
  along_y.Set(Line({0, 0}, {0, 3}, 16));
  Settle(along_y, Posts({{-0.4, 1.5}}), 20);
  ASSERT_EQ(along_x.bubbles().size(), along_y.bubbles().size());
  double pushed_m = 0;
  for (size_t i = 0; i < along_x.bubbles().size(); ++i) {
    const geometry::Vec2 a = along_x.bubbles()[i].map_from_base.translation;
    const geometry::Vec2 b = along_y.bubbles()[i].map_from_base.translation;
    EXPECT_NEAR(a.x, b.y, 1e-6);
    EXPECT_NEAR(a.y, -b.x, 1e-6);
    pushed_m = std::max(pushed_m, std::abs(a.y));
  }
  EXPECT_GT(pushed_m, 0.1);
}

// eband: division by the distance of neighbours that all but coincide.
TEST(ElasticBand, CoincidentNeighboursDoNoHarm) {
  std::vector<geometry::Rigid2> line = Line({0, 0}, {2, 0}, 11);
  line.insert(line.begin() + 5, 4, line[5]);
  line.insert(line.begin(), 2, line[0]);
  line.push_back(line.back());
  ElasticBand band({});
  band.Set(line);
  const Posts space({{1, 0.45}});
  Settle(band, space);
  for (const BandBubble& bubble : band.bubbles()) {
    EXPECT_TRUE(std::isfinite(bubble.map_from_base.translation.x));
    EXPECT_TRUE(std::isfinite(bubble.map_from_base.translation.y));
    EXPECT_LT(std::abs(bubble.map_from_base.translation.y), 0.6);
  }
  EXPECT_FALSE(band.FirstBreak(space).has_value());
}

// eband: one bubble in collision failed all of the band.
TEST(ElasticBand, ABubbleInCollisionGetsOut) {
  const Posts space({{1.5, 0.15}});
  ElasticBand band({});
  band.Set(Line({0, 0}, {3, 0}, 16));
  Settle(band, space, 1);
  ASSERT_TRUE(band.FirstBreak(space).has_value());
  Settle(band, space, 60);
  EXPECT_FALSE(band.FirstBreak(space).has_value());
}

// eband: clearance was that of a circle, whatever the heading.
TEST(ElasticBand, BubblesKnowTheirHeading) {
  const Footprint rod = {.front_m = 0.8, .rear_m = 0.8, .half_width_m = 0.2};
  const Posts corridor(
      {{0.5, 0.3}, {1, 0.3}, {1.5, 0.3}, {0.5, -0.3}, {1, -0.3}, {1.5, -0.3}},
      rod);
  ElasticBand along({});
  along.Set(Line({0, 0}, {2, 0}, 21));
  along.Relax(corridor);
  EXPECT_FALSE(along.FirstBreak(corridor).has_value());
  EXPECT_NEAR(along.bubbles()[along.bubbles().size() / 2].radius_m, 0.1, 0.02);
  // At right angles to it the rod is stuck.
  EXPECT_LT(corridor.FreeDistance_m(
                {.translation = {1, 0}, .yaw_rad = std::numbers::pi / 2}, 1),
            0);
}

TEST(ElasticBand, AClosedWayIsBroken) {
  std::vector<geometry::Vec2> wall;
  for (int i = -20; i <= 20; ++i) wall.push_back({1.5, 0.1 * i});
  const Posts space(wall);
  ElasticBand band({});
  band.Set(Line({0, 0}, {3, 0}, 16));
  Settle(band, space, 60);
  const auto broken = band.FirstBreak(space);
  ASSERT_TRUE(broken.has_value());
  EXPECT_LT(band.bubbles()[*broken - 1].map_from_base.translation.x, 1.25);
}

TEST(ElasticBand, WhatLiesBehindTheRobotIsCutOff) {
  ElasticBand band({});
  band.Set(Line({0, 0}, {3, 0}, 16));
  band.Relax(Posts({}));
  EXPECT_NEAR(band.BeginAt({.translation = {0.7, 0.05}}), 0.05, 1e-9);
  EXPECT_EQ(band.bubbles()[0].map_from_base.translation.x, 0.7);
  EXPECT_GT(band.bubbles()[1].map_from_base.translation.x, 0.7);
  // 5 cm aside.
  EXPECT_NEAR(LengthOf(band), 2.3, 0.02);
  EXPECT_GT(band.BeginAt({.translation = {1, 2}}), 1.5);
}

TEST(ElasticBand, OptionsAreChecked) {
  EXPECT_TRUE(ElasticBandOptions().Validate().ok());
  ElasticBandOptions options;
  options.min_spacing_m = 0.4;
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace treeline::control
