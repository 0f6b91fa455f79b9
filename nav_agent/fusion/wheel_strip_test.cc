#include "nav_agent/fusion/wheel_strip.h"

#include <cstdlib>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::fusion {
namespace {

constexpr double kResolution_m = 0.05;
constexpr double kHalfWidth_m = 0.2;
constexpr double kSlope = 1.0 / 12;

// 4 x 2 m of which all is free.
octree::VoxelMap FreeSpace() {
  octree::VoxelMap map = *octree::VoxelMap::Make(kResolution_m, {0, -20, -4},
                                                 {.x = 80, .y = 40, .z = 40});
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 0; x < map.size().x; ++x) {
      map.SetRun(x, y, 0, map.size().z, octree::Voxel::kFree);
    }
  }
  return map;
}

// The way along the x axis, `height(x)` above it.
template <typename Height>
std::vector<geometry::Rigid3> Way(Height height) {
  std::vector<geometry::Rigid3> poses;
  for (double x = 0.01; x < 4; x += 0.02) {
    geometry::Rigid3 pose;
    pose.translation = {x, 0, height(x)};
    poses.push_back(pose);
  }
  return poses;
}

double RampHeight(double x) { return 0.01 + kSlope * x; }

void PutRamp(octree::VoxelMap& map) {
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 0; x < map.size().x; ++x) {
      const geometry::Vec3 middle = map.CenterOf({x, y, 0});
      const octree::VoxelIndex ground =
          map.IndexOf({middle.x, middle.y, RampHeight(middle.x)});
      map.Set(ground, octree::Voxel::kOccupied);
    }
  }
}

// The highest occupied voxel of a column, or -1.
int TopOf(const octree::VoxelMap& map, int x, int y) {
  int top = map.size().z - 1;
  while (top >= 0 && map.At({x, y, top}) != octree::Voxel::kOccupied) --top;
  return top;
}

TEST(DrivenStripTest, WhatWasSeenStays) {
  octree::VoxelMap map = FreeSpace();
  PutRamp(map);
  const octree::VoxelMap seen = map;
  EXPECT_EQ(FillWheelStrip(Way(RampHeight), kHalfWidth_m, map), 0);
  EXPECT_EQ(map, seen);
  // Wheels a voxel above or below what was seen prove nothing.
  for (const double off_m : {-0.04, 0.04}) {
    const auto height = [off_m](double x) { return RampHeight(x) + off_m; };
    EXPECT_EQ(FillWheelStrip(Way(height), kHalfWidth_m, map), 0) << off_m;
  }
  EXPECT_EQ(map, seen);
}

TEST(DrivenStripTest, AHoleInARampIsClosedWithoutAStep) {
  octree::VoxelMap map = FreeSpace();
  PutRamp(map);
  const octree::VoxelMap whole = map;
  // Columns 40 to 43 were cleared, and those before them were seen too low,
  // those behind too high.
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 36; x < 48; ++x) {
      const int top = TopOf(map, x, y);
      map.Set({x, y, top}, octree::Voxel::kFree);
      if (x < 40) map.Set({x, y, top - 1}, octree::Voxel::kOccupied);
      if (x > 43) map.Set({x, y, top + 1}, octree::Voxel::kOccupied);
    }
  }
  const int holes = FillWheelStrip(Way(RampHeight), kHalfWidth_m, map);
  const octree::VoxelIndex left = map.IndexOf({0, kHalfWidth_m, 0});
  const octree::VoxelIndex right = map.IndexOf({0, -kHalfWidth_m, 0});
  EXPECT_EQ(holes, 4 * (left.y - right.y + 1));
  for (int y = right.y; y <= left.y; ++y) {
    for (int x = 36; x < 48; ++x) {
      EXPECT_NEAR(TopOf(map, x, y), TopOf(whole, x, y), 1) << x << " " << y;
      EXPECT_LE(std::abs(TopOf(map, x, y) - TopOf(map, x - 1, y)), 1);
    }
  }
  // Nobody drove beside it.
  EXPECT_EQ(TopOf(map, 41, left.y + 1), -1);
  EXPECT_EQ(TopOf(map, 41, right.y - 1), -1);
}

TEST(DrivenStripTest, GroundThatNobodySawIsThatOfEachStorey) {
  octree::VoxelMap map = FreeSpace();
  std::vector<geometry::Rigid3> way = Way([](double /*x*/) { return 0.01; });
  const std::vector<geometry::Rigid3> above =
      Way([](double /*x*/) { return 1.26; });
  way.insert(way.end(), above.begin(), above.end());
  EXPECT_GT(FillWheelStrip(way, kHalfWidth_m, map), 0);
  const octree::VoxelIndex lower = map.IndexOf({2, 0, 0.01});
  const octree::VoxelIndex upper = map.IndexOf({2, 0, 1.26});
  EXPECT_EQ(map.At(lower), octree::Voxel::kOccupied);
  EXPECT_EQ(map.At(upper), octree::Voxel::kOccupied);
  EXPECT_EQ(map.At({lower.x, lower.y, lower.z + 1}), octree::Voxel::kFree);
  // One voxel of each column on each storey, and nothing else.
  const octree::VoxelIndex left = map.IndexOf({2, kHalfWidth_m, 0.01});
  const octree::VoxelIndex right = map.IndexOf({2, -kHalfWidth_m, 0.01});
  EXPECT_EQ(map.CountOccupied(), 2 * map.size().x * (left.y - right.y + 1));
}

TEST(DrivenStripTest, WaysOutsideOfTheMapAreNoMatter) {
  octree::VoxelMap map = FreeSpace();
  const octree::VoxelMap before = map;
  geometry::Rigid3 far;
  far.translation = {1e12, -1e12, 5};
  geometry::Rigid3 high;
  high.translation = {1, 0, 100};
  const std::vector<geometry::Rigid3> way = {far, high};
  EXPECT_EQ(FillWheelStrip(way, kHalfWidth_m, map), 0);
  EXPECT_EQ(FillWheelStrip({}, kHalfWidth_m, map), 0);
  EXPECT_EQ(map, before);
}

}  // namespace
}  // namespace treeline::fusion
