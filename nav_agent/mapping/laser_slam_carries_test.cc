// A robot that is carried off while it maps, in a hall in which no two places
// are alike.
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapping/laser_slam.h"
#include "nav_agent/mapping/seen_place.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

constexpr double kStep_m = 0.05;
constexpr double kTurn_rad = 0.05;
constexpr int kScan_ms = 100;
// Of maps of 30 m of way, where scans scatter by 1 cm.
constexpr double kRight_m = 0.1;

// Two rooms of 10 x 8 m, and a door between them.
std::vector<TestWall> Rooms() {
  std::vector<TestWall> walls;
  AddBox({0, 0}, {20, 8}, &walls);
  AddBox({9.9, 0}, {10.1, 3}, &walls);
  AddBox({9.9, 5}, {10.1, 8}, &walls);
  AddBox({3, 3}, {4.2, 4}, &walls);
  AddBox({0, 6.5}, {1.5, 8}, &walls);
  AddBox({7.5, 0}, {8.1, 1.1}, &walls);
  AddBox({6.0, 6.8}, {7.7, 8}, &walls);
  AddBox({14, 4.2}, {14.6, 6.1}, &walls);
  AddBox({18.2, 0}, {20, 0.9}, &walls);
  AddBox({12.0, 7.2}, {12.5, 8}, &walls);
  AddBox({16.4, 0}, {16.9, 0.6}, &walls);
  return walls;
}

// Drives to each corner, turning on the spot.
void DriveTo(const std::vector<geometry::Vec2>& corners,
             std::vector<geometry::Rigid2>* way) {
  for (const geometry::Vec2 corner : corners) {
    geometry::Rigid2 pose = way->back();
    const geometry::Vec2 ahead = corner - pose.translation;
    const double turn_rad = geometry::NormalizedAngle_rad(
        std::atan2(ahead.y, ahead.x) - pose.yaw_rad);
    const int turns = static_cast<int>(std::abs(turn_rad) / kTurn_rad) + 1;
    for (int i = 0; i < turns; ++i) {
      pose.yaw_rad += turn_rad / turns;
      way->push_back(pose);
    }
    const double length_m = geometry::Norm(ahead);
    const int steps = static_cast<int>(length_m / kStep_m) + 1;
    for (int i = 0; i < steps; ++i) {
      pose = pose * geometry::Rigid2{{length_m / steps, 0}, 0};
      way->push_back(pose);
    }
  }
}

std::vector<geometry::Rigid2> RoundOfTheFirstRoom() {
  std::vector<geometry::Rigid2> way = {{{1.5, 1.5}, 0}};
  DriveTo({{6.5, 1.8}, {8.5, 4}, {6.0, 5.8}, {2.2, 5.2}, {1.5, 1.6}}, &way);
  return way;
}

struct Drive {
  std::vector<geometry::Rigid2> truth;
  std::vector<TrajectoryPose> found;
  LaserSlamStatistics statistics;
  bool is_lost_at_end = false;

  geometry::Rigid2 WorldFromMap() const {
    return truth.front() * found.front().map_from_base.Inverse();
  }
  // Of the scans whose place is known: the furthest off.
  double WorstError_m() const {
    const geometry::Rigid2 world_from_map = WorldFromMap();
    double worst_m = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
      if (!found[i].is_known) continue;
      const geometry::Rigid2 here = world_from_map * found[i].map_from_base;
      worst_m = std::max(
          worst_m, geometry::Norm(here.translation - truth[i].translation));
    }
    return worst_m;
  }
  int Known(size_t begin, size_t end) const {
    int known = 0;
    for (size_t i = begin; i < end; ++i) known += found[i].is_known ? 1 : 0;
    return known;
  }
  double Seconds() const {
    const Carry& carry = statistics.carries.front();
    return recording::SecondsBetween(carry.at, *carry.found);
  }
};

using EachScan = std::function<void(LaserSlam&, recording::RecordingTime,
                                    const geometry::Rigid2& truth)>;

// Each piece is driven; the robot is carried from one to the next.
Drive Map(const std::vector<std::vector<geometry::Rigid2>>& pieces,
          const EachScan& each = {}, bool notices = true) {
  const std::vector<TestWall> walls = Rooms();
  const core::RangeSensorInfo laser = TestLaser(20);
  LaserSlamOptions options;
  options.synchronous = true;
  options.odometry = OdometryNoise::WithGyroscope();
  options.notices_carries = notices;
  const std::unique_ptr<LaserSlam> slam =
      *LaserSlam::Create(laser, {}, options);
  Drive drive;
  geometry::Rigid2 odom_from_base;
  for (const std::vector<geometry::Rigid2>& piece : pieces) {
    for (size_t i = 0; i < piece.size(); ++i) {
      if (i > 0) {
        odom_from_base = odom_from_base * (piece[i - 1].Inverse() * piece[i]);
      }
      const size_t number = drive.truth.size();
      const recording::RecordingTime stamp(
          std::chrono::milliseconds(kScan_ms * static_cast<int64_t>(number)));
      const std::vector<float> ranges_m =
          CastScan(walls, piece[i], laser, 0.01, 500 + number);
      EXPECT_TRUE(slam->AddScan({.stamp = stamp,
                                 .odom_from_base = odom_from_base,
                                 .ranges_m = ranges_m})
                      .ok());
      drive.truth.push_back(piece[i]);
      if (each) each(*slam, stamp, piece[i]);
    }
  }
  drive.is_lost_at_end = slam->IsLost();
  slam->Finish();
  drive.found = slam->Trajectory();
  drive.statistics = slam->Statistics();
  return drive;
}

// Put down where it has been, turned aside; then the same way again.
std::vector<geometry::Rigid2> Again() {
  std::vector<geometry::Rigid2> way = {{{5.0, 2.0}, 0.6}};
  DriveTo({{6.5, 1.8}, {8.5, 4}, {6.0, 5.8}, {2.2, 5.2}, {1.5, 1.6}}, &way);
  return way;
}

// The server's answer, of the scan before the last.
EachScan SayingThat(const geometry::Rigid2& seen_from_truth) {
  return [seen_from_truth, previous = std::make_shared<geometry::Rigid2>(),
          start = std::make_shared<std::vector<geometry::Rigid2>>()](
             LaserSlam& slam, recording::RecordingTime stamp,
             const geometry::Rigid2& truth) {
    if (start->empty()) start->push_back(truth);
    // About every second.
    if (slam.IsLost() && stamp.time_since_epoch() % std::chrono::seconds(1) ==
                             std::chrono::seconds(0)) {
      slam.SuggestPlace(stamp - std::chrono::milliseconds(kScan_ms),
                        start->front().Inverse() * seen_from_truth * *previous,
                        0);
    }
    *previous = truth;
  };
}

TEST(LaserSlamCarries, WithoutOneNothingIsDifferent) {
  const std::vector<std::vector<geometry::Rigid2>> way = {
      RoundOfTheFirstRoom()};
  const Drive with = Map(way);
  const Drive without = Map(way, {}, /*notices=*/false);
  EXPECT_TRUE(with.statistics.carries.empty());
  EXPECT_LT(with.WorstError_m(), kRight_m);
  ASSERT_EQ(with.found.size(), without.found.size());
  for (size_t i = 0; i < with.found.size(); ++i) {
    ASSERT_TRUE(with.found[i].is_known);
    ASSERT_EQ(with.found[i].map_from_base, without.found[i].map_from_base) << i;
  }
}

TEST(LaserSlamCarries, ScansFindTheRobotAgain) {
  const std::vector<std::vector<geometry::Rigid2>> ways = {
      RoundOfTheFirstRoom(), Again()};
  const Drive drive = Map(ways);
  ASSERT_EQ(drive.statistics.carries.size(), 1U);
  EXPECT_TRUE(drive.statistics.carries[0].found.has_value());
  EXPECT_EQ(drive.statistics.carries[0].who, SegmentWitness::kScans);
  EXPECT_FALSE(drive.is_lost_at_end);
  EXPECT_LT(drive.WorstError_m(), kRight_m);
  // What was driven before it was found is in the map, too, but for the moment
  // of the carry.
  const size_t begin = ways[0].size();
  EXPECT_GE(drive.Known(begin, drive.truth.size()),
            static_cast<int>(ways[1].size()) - 12);
  // It is what bends the map if nobody notices.
  EXPECT_GT(Map(ways, {}, /*notices=*/false).WorstError_m(), 1);
}

TEST(LaserSlamCarries, WhatTheServerSaysFindsItSooner) {
  const std::vector<std::vector<geometry::Rigid2>> ways = {
      RoundOfTheFirstRoom(), Again()};
  // It is some centimetres off.
  const Drive drive = Map(ways, SayingThat({{0.1, -0.08}, 0.01}));
  ASSERT_EQ(drive.statistics.carries.size(), 1U);
  ASSERT_TRUE(drive.statistics.carries[0].found.has_value());
  EXPECT_EQ(drive.statistics.carries[0].who, SegmentWitness::kServer);
  EXPECT_LT(drive.WorstError_m(), kRight_m);
  EXPECT_LT(drive.Seconds(), Map(ways).Seconds());
}

// Of the wrong place again and again: a server that has half a map.
TEST(LaserSlamCarries, WrongAnswersBendNothing) {
  const std::vector<std::vector<geometry::Rigid2>> ways = {
      RoundOfTheFirstRoom(), Again()};
  for (const geometry::Rigid2& off :
       {geometry::Rigid2{{1, 0}, 0},
        geometry::Rigid2{{8, 8}, std::numbers::pi}}) {
    const Drive drive = Map(ways, SayingThat(off));
    EXPECT_LT(drive.WorstError_m(), kRight_m) << off.translation.x;
    for (const Carry& carry : drive.statistics.carries) {
      EXPECT_NE(carry.who, SegmentWitness::kServer) << off.translation.x;
    }
  }
}

TEST(LaserSlamCarries, WhereNobodyHasBeenNothingIsDrawnUntilItComesBack) {
  std::vector<geometry::Rigid2> beyond = {{{16, 2.0}, 0.3}};
  DriveTo({{18, 3}, {17.5, 6.5}, {13, 2.5}}, &beyond);
  const std::vector<geometry::Rigid2> round = RoundOfTheFirstRoom();
  const Drive away = Map({round, beyond});
  ASSERT_EQ(away.statistics.carries.size(), 1U);
  EXPECT_TRUE(away.is_lost_at_end);
  EXPECT_FALSE(away.statistics.carries[0].found.has_value());
  EXPECT_EQ(away.Known(round.size(), away.truth.size()), 0);
  EXPECT_LT(away.WorstError_m(), kRight_m);

  // Through the door, and on through the first room.
  DriveTo({{9.3, 4.2}, {6.5, 5.5}, {2.2, 5.2}, {1.5, 1.6}}, &beyond);
  const Drive back = Map({round, beyond});
  ASSERT_EQ(back.statistics.carries.size(), 1U);
  ASSERT_TRUE(back.statistics.carries[0].found.has_value());
  EXPECT_FALSE(back.is_lost_at_end);
  // The second room is in the map now.
  EXPECT_GE(back.Known(round.size(), back.truth.size()),
            static_cast<int>(beyond.size()) - 12);
  EXPECT_LT(back.WorstError_m(), 2 * kRight_m);
}

TEST(LaserSlamCarries, TwiceInARow) {
  std::vector<geometry::Rigid2> once = {{{16, 2.0}, 0.3}};
  DriveTo({{17, 2.4}}, &once);
  const std::vector<std::vector<geometry::Rigid2>> ways = {
      RoundOfTheFirstRoom(), once, Again()};
  const Drive drive = Map(ways);
  // What came between the two hangs on nothing.
  ASSERT_EQ(drive.statistics.carries.size(), 1U);
  EXPECT_TRUE(drive.statistics.carries[0].found.has_value());
  EXPECT_EQ(drive.Known(ways[0].size(), ways[0].size() + ways[1].size()), 0);
  EXPECT_LT(drive.WorstError_m(), kRight_m);
}

TEST(CarryWatch, TakesSomeScansAndSomeTime) {
  CarryWatch watch({});
  const auto at = [](int milliseconds) {
    return recording::RecordingTime(std::chrono::milliseconds(milliseconds));
  };
  for (int i = 0; i < 12; ++i) EXPECT_FALSE(watch.Add(true, at(25 * i))) << i;
  EXPECT_TRUE(watch.Add(true, at(300)));
  EXPECT_EQ(watch.since(), at(0));
  EXPECT_FALSE(watch.Add(false, at(325)));
  EXPECT_FALSE(watch.in_doubt());
  EXPECT_FALSE(watch.Add(true, at(1000)));
  EXPECT_FALSE(watch.Add(true, at(3000)));
}

TEST(CarryWatch, SeesThatSurroundingsHaveChanged) {
  CarryWatch watch({});
  std::vector<float> ranges_m(400, 3.0F);
  EXPECT_FALSE(watch.HasChanged(ranges_m));
  watch.Note(ranges_m);
  EXPECT_FALSE(watch.HasChanged(ranges_m));
  // A person stands before it.
  std::fill(ranges_m.begin(), ranges_m.begin() + 150, 1.0F);
  EXPECT_FALSE(watch.HasChanged(ranges_m));
  std::fill(ranges_m.begin(), ranges_m.end(), 5.0F);
  EXPECT_TRUE(watch.HasChanged(ranges_m));
}

TEST(SeenPlace, ComesBackFromItsText) {
  const geometry::Rigid3 seen = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, 2.5}),
      .translation = {1.25, -3.5, 0.125}};
  const auto read = ParseSeenPlace(SeenPlaceText(seen));
  ASSERT_TRUE(read.has_value());
  EXPECT_LT(geometry::Norm(read->translation - seen.translation), 1e-4);
  EXPECT_LT(geometry::ErrorBetween(*read, seen).rotation_rad, 1e-5);
  EXPECT_FALSE(ParseSeenPlace("robot started").has_value());
  EXPECT_FALSE(ParseSeenPlace("seen at 1 2 3").has_value());
  EXPECT_FALSE(ParseSeenPlace("seen at 1 2 nan 0 0 0 1").has_value());
  EXPECT_FALSE(ParseSeenPlace("seen at 1 2 3 0 0 0 0").has_value());
}

}  // namespace
}  // namespace treeline::mapping
