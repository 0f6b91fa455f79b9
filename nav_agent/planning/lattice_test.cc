#include "nav_agent/planning/lattice.h"

#include <functional>
#include <memory>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

constexpr double kPi = std::numbers::pi;

ConfigurationSpace SpaceOf(const std::vector<std::string>& rows,
                           int scale = 2) {
  return {std::make_shared<const GroundIndex>(DrawnMap(rows, scale)),
          Footprint::Of(core::RobotModel(), 0.0),
          {}};
}

Stand At(double x, double y, double yaw_rad) {
  return {.spot = {{x, y}, 0}, .yaw_rad = yaw_rad};
}

bool Never() { return false; }

Polyline Search(const ConfigurationSpace& space, const Stand& start,
                const Stand& goal, const std::function<bool()>& is_over) {
  return SearchLattice(space, Regions(space), start, goal, is_over);
}

// A room of 6 x 4 m with a niche of 0.7 m x 1 m in its right wall: no room to
// turn in.
std::vector<std::string> NicheRows() {
  std::vector<std::string> rows = RoomRows(120, 80);
  Fill(rows, 90, 119, 1, 79, '#');
  Fill(rows, 90, 110, 33, 47, '.');
  return rows;
}

TEST(LatticeTest, FindsAWayThroughADoorThatItJustFits) {
  std::vector<std::string> rows = RoomRows(160, 100);
  Fill(rows, 80, 84, 1, 99, '#');
  Fill(rows, 80, 84, 40, 53, '.');
  const ConfigurationSpace space = SpaceOf(rows, 1);
  const Stand start = At(1.01, 4.02, 2.0);
  const Stand goal = At(7.03, 3.98, -1.0);
  const Polyline way = Search(space, start, goal, Never);
  ASSERT_GE(way.size(), 3U);
  EXPECT_EQ(way.front(), start.spot);
  EXPECT_EQ(way.back(), goal.spot);
  EXPECT_TRUE(CanBeDriven(space, start.yaw_rad, goal.yaw_rad, way));
  // Straight lines over the door's middle are 7.0 m.
  EXPECT_LT(PathLength_m(way), 8.0);
}

TEST(LatticeTest, DrivesIntoANicheAhead) {
  const ConfigurationSpace space = SpaceOf(NicheRows(), 1);
  const Stand start = At(1, 1, kPi);
  const Stand goal = At(5.1, 2.0, 0);
  const Polyline way = Search(space, start, goal, Never);
  ASSERT_FALSE(way.empty());
  EXPECT_TRUE(CanBeDriven(space, start.yaw_rad, goal.yaw_rad, way));
}

TEST(LatticeTest, KnowsSoonThatANicheCannotBeBackedInto) {
  int asked = 0;
  const Polyline way =
      Search(SpaceOf(NicheRows(), 1), At(1, 1, kPi), At(5.1, 2.0, kPi),
             [&asked] { return ++asked < 0; });
  EXPECT_TRUE(way.empty());
  // It has not begun to search the room.
  EXPECT_EQ(asked, 0);
}

TEST(LatticeTest, FindsNothingThroughADoorThatIsNarrowerThanTheRobot) {
  EXPECT_TRUE(Search(SpaceOf(TwoRoomsRows(6)), At(1, 4, 0), At(7, 4, 0), Never)
                  .empty());
}

TEST(LatticeTest, EndsWhenItIsOver) {
  const ConfigurationSpace space = SpaceOf(TwoRoomsRows(9));
  const Stand start = At(1, 4, 0);
  const Stand goal = At(7, 4, 0);
  int asked = 0;
  ASSERT_FALSE(
      Search(space, start, goal, [&asked] { return ++asked < 0; }).empty());
  // Whenever that is.
  for (const int last : {1, asked / 2, asked}) {
    int now = 0;
    EXPECT_TRUE(Search(space, start, goal, [&now, last] {
                  return ++now >= last;
                }).empty());
    EXPECT_EQ(now, last);
  }
}

TEST(LatticeTest, IsAtTheGoalAlready) {
  const ConfigurationSpace space = SpaceOf(RoomRows(60, 40));
  const Stand start = At(2, 2, 0);
  const Polyline way = Search(space, start, At(2, 2, kPi), Never);
  EXPECT_TRUE(CanBeDriven(space, 0, kPi, way));
  EXPECT_EQ(PathLength_m(way), 0);
  EXPECT_FALSE(way.empty());
}

}  // namespace
}  // namespace treeline::planning
