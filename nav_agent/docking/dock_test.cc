#include "nav_agent/docking/dock.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "absl/strings/str_split.h"
#include "common/base/checked_lines.h"
#include "gmock/gmock.h"
#include "nav_agent/docking/dock_drive.h"
#include "nav_agent/docking/dock_file.h"
#include "nav_agent/docking/parameters.h"

namespace treeline::docking {
namespace {

using ::testing::HasSubstr;

// 10 x 10 m, free; a wall of a cell's width at x = 6 m; nothing is known beyond
// y = 8 m.
traversability::TraversableMap WalledMap() {
  traversability::TraversableLevel level;
  level.grid =
      core::OccupancyGrid::Filled(100, 100, 0.1, {}, core::Occupancy::kFree);
  for (int i = 0; i < 100; ++i) {
    level.grid.Set({60, i}, core::Occupancy::kOccupied);
    for (int y = 80; y < 100; ++y) {
      level.grid.Set({i, y}, core::Occupancy::kUnknown);
    }
  }
  traversability::TraversableMap map;
  map.levels.push_back(std::move(level));
  return map;
}

Dock Charger() {
  return {.name = "charger", .map_from_docked = {{5, 5}, 0}, .staging_m = 0.8};
}

std::string Wrong(const Dock& dock) {
  const absl::Status checked = CheckDock(dock, WalledMap());
  return std::string(checked.message());
}

TEST(Dock, WhatMeansNothingIsRefusedByName) {
  EXPECT_EQ(Wrong(Charger()), "");
  Dock dock = Charger();
  dock.name = "";
  EXPECT_THAT(Wrong(dock), HasSubstr("name"));
  dock.name = "two\nlines";
  EXPECT_THAT(Wrong(dock), HasSubstr("name"));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), 1e9}) {
    dock = Charger();
    dock.map_from_docked.translation.y = bad;
    EXPECT_THAT(Wrong(dock), HasSubstr("dock 'charger': is at"));
    dock = Charger();
    dock.map_from_docked.yaw_rad = bad;
    EXPECT_THAT(Wrong(dock), HasSubstr("no heading"));
    dock = Charger();
    dock.staging_m = bad;
    EXPECT_THAT(Wrong(dock), HasSubstr("must be 0.2..5"));
  }
  dock = Charger();
  dock.level = 1;
  EXPECT_THAT(Wrong(dock), HasSubstr("the map has 0..0"));
  dock = Charger();
  dock.map_from_docked.translation = {6.05, 5};
  EXPECT_THAT(Wrong(dock), HasSubstr("docked pose (6.05, 5.00) lies in"));
  dock.map_from_docked.translation = {6.8, 5};
  EXPECT_THAT(Wrong(dock), HasSubstr("staging pose (6.00, 5.00) lies in"));
  dock.map_from_docked.translation = {3, 9};
  EXPECT_THAT(Wrong(dock), HasSubstr("knows no ground"));
  dock.map_from_docked.translation = {-0.5, 5};
  EXPECT_THAT(Wrong(dock), HasSubstr("outside of the map"));
}

TEST(Dock, TwoOfOneNameAndTooManyAreRefused) {
  std::vector<Dock> docks = {Charger(), Charger()};
  EXPECT_THAT(std::string(CheckDocks(docks, WalledMap()).message()),
              HasSubstr("two docks are called 'charger'"));
  docks.assign(kMaxDocks + 1, Charger());
  EXPECT_THAT(std::string(CheckDocks(docks, WalledMap()).message()),
              HasSubstr("at most 100"));
}

TEST(Dock, IsReadAsItWasWritten) {
  Dock behind = Charger();
  behind.name = "the one behind";
  behind.map_from_docked = {{0.1, -7.0 / 3}, 1e-17};
  behind.level = 2;
  behind.is_backward = true;
  const std::vector<Dock> docks = {Charger(), behind};
  const std::string text = DockFileText(docks);
  const auto read = ParseDockFile(text);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, docks);
  for (size_t length = 0; length < text.size(); ++length) {
    EXPECT_FALSE(ParseDockFile(text.substr(0, length)).ok());
  }
  std::string changed = text;
  changed[changed.find('5')] = '6';
  EXPECT_FALSE(ParseDockFile(changed).ok());
}

TEST(Dock, WhatIsSeenFromItIsKeptInMillimetres) {
  Dock dock = Charger();
  dock.view = {{1.2344, -0.0006}, {-3, 0.25}};
  Dock other = Charger();
  other.name = "seen 1 2";
  const std::string text = DockFileText(std::vector<Dock>{dock, other});
  EXPECT_THAT(text, HasSubstr("\nseen 1234 -1 -3000 250\n"));
  const auto read = ParseDockFile(text);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(read->front().view,
            (std::vector<geometry::Vec2>{{1.234, -0.001}, {-3, 0.25}}));
  EXPECT_TRUE(IsSamePlace(read->front(), dock));
  EXPECT_EQ(read->back(), other);
  EXPECT_EQ(DockFileText(*read), text);
  for (const char* lines : {"seen 1 2", "dock 0 1 2 3 forward 1 a\nseen 1",
                            "dock 0 1 2 3 forward 1 a\nseen 1 x",
                            "dock 0 1 2 3 forward 1 a\nseen 1 2\nseen 3 4"}) {
    EXPECT_FALSE(
        ParseDockFile(base::CheckedLinesText("treeline-docks 2",
                                             absl::StrSplit(lines, '\n')))
            .ok())
        << lines;
  }
  // Of before there were views.
  const auto old = ParseDockFile(base::CheckedLinesText(
      "treeline-docks 1", {"dock 0 5 5 0 forward 0.8 charger"}));
  ASSERT_TRUE(old.ok()) << old.status();
  EXPECT_EQ(old->front(), Charger());
  dock.view.assign(kMaxViewPoints + 1, {});
  EXPECT_THAT(Wrong(dock), HasSubstr("view"));
  dock.view = {{std::numeric_limits<double>::quiet_NaN(), 0}};
  EXPECT_THAT(Wrong(dock), HasSubstr("view"));
}

TEST(Dock, TheRobotIsSeenFromTheWayInWhicheverEndIsAhead) {
  Dock dock = Charger();
  dock.map_from_docked.yaw_rad = std::numbers::pi / 2;
  EXPECT_NEAR(StagingPose(dock).translation.y, 4.2, 1e-9);
  DockOffset off = OffsetFrom(dock, {{4.9, 4.5}, std::numbers::pi / 2 + 0.1});
  EXPECT_NEAR(off.along_m, -0.5, 1e-9);
  EXPECT_NEAR(off.aside_m, 0.1, 1e-9);
  EXPECT_NEAR(off.turned_rad, 0.1, 1e-9);
  dock.is_backward = true;
  EXPECT_NEAR(StagingPose(dock).translation.y, 5.8, 1e-9);
  off = OffsetFrom(dock, {{4.9, 5.5}, std::numbers::pi / 2});
  EXPECT_NEAR(off.along_m, -0.5, 1e-9);
  EXPECT_NEAR(off.aside_m, -0.1, 1e-9);
}

TEST(Dock, OneInItCannotTurnAndOneBeforeItCan) {
  const core::RobotModel robot;
  const Dock dock = Charger();
  const auto at = [](double x_m, double y_m, double yaw_rad) {
    return core::LevelPose{.map_from_base = {{x_m, y_m}, yaw_rad}, .place = {}};
  };
  EXPECT_TRUE(IsAt(dock, at(4.95, 5.02, 0.05)));
  EXPECT_FALSE(IsAt(dock, at(4.8, 5, 0)));
  EXPECT_FALSE(IsAt(dock, at(5, 5, 0.3)));
  core::LevelPose above = at(5, 5, 0);
  above.place.level = 1;
  EXPECT_FALSE(IsAt(dock, above));
  EXPECT_TRUE(IsInside(dock, at(4.8, 5, 0), robot));
  EXPECT_FALSE(IsInside(dock, at(4.5, 5, 0), robot));
  EXPECT_FALSE(IsInside(dock, at(4.8, 5, 3), robot));
  EXPECT_FALSE(IsInside(dock, above, robot));
  EXPECT_FALSE(IsInside(dock, at(4.2, 5, 0), robot));
}

// From where a goal's tolerances leave the robot, either way round: it comes
// onto the line by the pull alone.
TEST(DockDrive, ComesOntoTheLineFromTheToleranceOfAGoal) {
  const core::RobotModel robot;
  for (const bool is_backward : {false, true}) {
    for (const double aside_m : {-0.1, 0.0, 0.1}) {
      for (const double turned_rad :
           {-kTolerance_rad.value, kTolerance_rad.value}) {
        Dock dock = Charger();
        dock.staging_m = DefaultStaging_m(robot);
        dock.is_backward = is_backward;
        geometry::Rigid2 at =
            StagingPose(dock) * geometry::Rigid2{{0.02, aside_m}, turned_rad};
        DockOffset off = OffsetFrom(dock, at);
        for (int i = 0; i < 2000 && off.along_m < -kTolerance_m / 4; ++i) {
          const core::VelocityCommand command = DriveIn(dock, off, robot);
          EXPECT_LE(std::abs(command.forward_mps), kDockSpeed_mps);
          at = at * geometry::Rigid2{{0.025 * command.forward_mps, 0},
                                     0.025 * command.yaw_rate_radps};
          off = OffsetFrom(dock, at);
        }
        EXPECT_NEAR(off.along_m, 0, kTolerance_m / 4);
        EXPECT_NEAR(off.aside_m, 0, kTolerance_m / 2);
        EXPECT_NEAR(off.turned_rad, 0, kTolerance_rad);
        // And out again.
        for (int i = 0; i < 2000 && off.along_m > -0.7; ++i) {
          const core::VelocityCommand command = DriveOut(dock, off, robot);
          at = at * geometry::Rigid2{{0.025 * command.forward_mps, 0},
                                     0.025 * command.yaw_rate_radps};
          off = OffsetFrom(dock, at);
        }
        EXPECT_LE(off.along_m, -0.7);
        EXPECT_NEAR(off.aside_m, 0, kTolerance_m);
      }
    }
  }
}

}  // namespace
}  // namespace treeline::docking
