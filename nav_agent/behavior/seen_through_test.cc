#include "nav_agent/behavior/seen_through.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

constexpr geometry::Vec2 kAt = {3, 3};

class SeenThroughTest : public testing::Test {
 protected:
  // Cells of the map, from and up to which.
  void Block(core::CellIndex from, core::CellIndex to) {
    for (int y = from.y; y < to.y; ++y) {
      for (int x = from.x; x < to.x; ++x) {
        map_.levels[0].grid.Set({x, y}, core::Occupancy::kOccupied);
      }
    }
  }
  // Beams to all sides; `range_m` of an angle.
  template <typename Range>
  void Measure(const Range& range_m) {
    for (int degree = -135; degree <= 135; ++degree) {
      const double angle_rad = degree * 0.0174533;
      ends_.push_back({range_m(angle_rad) * std::cos(angle_rad),
                       range_m(angle_rad) * std::sin(angle_rad)});
    }
  }
  bool IsSeen(double within_m = 0.15) const {
    return IsSeenThrough(*traversability::NavigationMap::Make(map_), 0,
                         {.map_from_base = {kAt, 0},
                          .laser_in_base = {0, 0},
                          .ends_in_base = ends_},
                         within_m, core::RobotModel());
  }

  traversability::TraversableMap map_ = TwoRooms();
  std::vector<geometry::Vec2> ends_;
};

TEST_F(SeenThroughTest, ATrolleysTrackThatBeamsPass) {
  Block({48, 58}, {74, 59});
  Measure([](double) { return 2.5; });
  EXPECT_TRUE(IsSeen());
}

TEST_F(SeenThroughTest, NotWithoutBeams) {
  Block({48, 58}, {74, 59});
  EXPECT_FALSE(IsSeen());
}

TEST_F(SeenThroughTest, NotWhereNothingIsInTheWay) {
  Measure([](double) { return 2.5; });
  EXPECT_FALSE(IsSeen());
}

TEST_F(SeenThroughTest, NotAThingThatBeamsEndOn) {
  Block({62, 52}, {74, 68});
  Measure([](double angle_rad) {
    // Its near side is at 0.1 m ahead.
    return std::abs(angle_rad) < 1.3 ? 0.125 / std::cos(angle_rad) : 2.5;
  });
  EXPECT_FALSE(IsSeen());
}

// Half of a cluster is still there: a chair beside which somebody stood.
TEST_F(SeenThroughTest, NotWhereBeamsEndOnAPartOfIt) {
  Block({48, 58}, {74, 59});
  Measure([](double angle_rad) { return std::abs(angle_rad) < 1 ? 2.5 : 0.5; });
  ASSERT_TRUE(IsSeen());
  Block({70, 52}, {74, 60});
  ends_.clear();
  Measure([](double angle_rad) {
    return std::abs(angle_rad) < 0.6 ? 0.53 / std::cos(angle_rad) : 2.5;
  });
  EXPECT_FALSE(IsSeen());
}

TEST_F(SeenThroughTest, NotAWallThatABeamWouldPass) {
  Block({0, 58}, {120, 59});
  Measure([](double) { return 2.5; });
  EXPECT_FALSE(IsSeen());
}

TEST_F(SeenThroughTest, NotWhatIsWhollyUnderTheRobot) {
  Block({59, 59}, {61, 61});
  Measure([](double) { return 2.5; });
  EXPECT_FALSE(IsSeen());
}

}  // namespace
}  // namespace treeline::behavior
