#include "nav_agent/fusion/octomap_builder.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/fusion/testing_views.h"
#include "nav_agent/octomap/octree_file.h"

namespace treeline::fusion {
namespace {

// A quarter of the pixels, the same field of view.
camera::Camera SmallCamera() {
  return *camera::Camera::Parse("SIMPLE_PINHOLE,292.5,159.5,119.5", 320, 240);
}

// Views of the room, turning about once.
std::vector<ViewPose> TurningPoses(int count) {
  std::vector<ViewPose> poses;
  for (int i = 0; i < count; ++i) {
    const double yaw_rad = 2 * std::numbers::pi * i / count;
    poses.push_back({.id = 100 + i,
                     .map_from_sensor = LevelCamera(
                         {0.3 * std::cos(yaw_rad), 0.2, 1.2}, yaw_rad)});
  }
  return poses;
}

OctomapBuilder MakeBuilder(const FusionOptions& options = {}) {
  return *OctomapBuilder::Make(options);
}

// Inserts views that were taken from `taken_from` at `poses`.
void InsertRoom(OctomapBuilder& builder,
                const std::vector<ViewPose>& taken_from,
                const std::vector<ViewPose>& poses) {
  const camera::Camera camera = SmallCamera();
  for (size_t i = 0; i < poses.size(); ++i) {
    const image::DepthImage depth =
        MakeRoomDepth(camera, taken_from[i].map_from_sensor, i);
    const absl::Status status = builder.InsertDepth(poses[i].id, depth, camera,
                                                    poses[i].map_from_sensor);
    ASSERT_TRUE(status.ok()) << status;
  }
}

std::unique_ptr<octomap::OcTree> ReadByLibrary(const std::string& ot) {
  std::stringstream stream(ot);
  std::unique_ptr<octomap::AbstractOcTree> tree(
      octomap::AbstractOcTree::read(stream));
  auto* const occupancy = dynamic_cast<octomap::OcTree*>(tree.get());
  if (occupancy != nullptr) static_cast<void>(tree.release());
  return std::unique_ptr<octomap::OcTree>(occupancy);
}

TEST(OctomapBuilder, LinesThatGrazeASurfaceDoNotClearIt) {
  OctomapBuilder builder = MakeBuilder();
  const std::vector<ViewPose> poses = TurningPoses(12);
  InsertRoom(builder, poses, poses);
  const octree::VoxelMap before = *builder.Map();
  octree::VoxelIndex wall = before.IndexOf({2, 0.5, 1.2});
  while (before.Contains(wall) && before.At(wall) != octree::Voxel::kOccupied)
    ++wall.x;
  ASSERT_TRUE(before.Contains(wall));
  const geometry::Vec3 in_wall = before.CenterOf(wall);
  // A laser's plane along the wall, within that voxel; and what stood in the
  // room once, where no camera has seen it.
  const geometry::Rigid3 map_from_laser = {
      .rotation = {}, .translation = in_wall - geometry::Vec3{0, 1, 0}};
  const geometry::Vec3 stood = {-0.5, -0.5, 0};
  const auto insert = [&](int64_t id, const std::vector<geometry::Vec3>& ends) {
    return builder.InsertPoints(id, ends, map_from_laser).ok();
  };
  const auto at = [&builder](geometry::Vec3 place) {
    const octree::VoxelMap map = *builder.Map();
    return map.At(map.IndexOf(place));
  };
  ASSERT_EQ(at(map_from_laser * stood), octree::Voxel::kFree);
  for (int64_t id = 1; id <= 8; ++id) ASSERT_TRUE(insert(id, {stood}));
  EXPECT_EQ(at(map_from_laser * stood), octree::Voxel::kOccupied);
  for (int64_t id = 21; id <= 40; ++id) {
    ASSERT_TRUE(insert(id, {{0, 2, 0}, 2 * stood}));
  }
  EXPECT_EQ(at(in_wall), octree::Voxel::kOccupied);
  EXPECT_EQ(at(map_from_laser * stood), octree::Voxel::kFree);
}

TEST(OctomapBuilder, ARoomIsOccupiedAtItsWallsAndFreeInside) {
  OctomapBuilder builder = MakeBuilder();
  InsertRoom(builder, TurningPoses(12), TurningPoses(12));
  const octree::VoxelMap map = *builder.Map();
  int64_t beside = 0;
  for (int x = 0; x < map.size().x; ++x) {
    for (int y = 0; y < map.size().y; ++y) {
      for (int z = 0; z < map.size().z; ++z) {
        if (map.At({x, y, z}) != octree::Voxel::kOccupied) continue;
        const geometry::Vec3 p = map.CenterOf({x, y, z});
        const double wall_m = std::min({std::abs(3 - std::abs(p.x)),
                                        std::abs(2.5 - std::abs(p.y)),
                                        std::abs(p.z), std::abs(2.6 - p.z)});
        // One voxel and its half.
        if (wall_m > 0.08) ++beside;
      }
    }
  }
  EXPECT_GT(map.CountOccupied(), 10000);
  EXPECT_LT(beside, map.CountOccupied() / 200);
  // From 1 to 2 m from the middle, at the camera's height, all is free; nearer
  // there is what lies beside the camera in all views.
  for (double x = -2; x <= 2; x += 0.05) {
    for (double y = -2; y <= 2; y += 0.05) {
      if (std::hypot(x, y) < 1 || std::hypot(x, y) > 2) continue;
      EXPECT_EQ(map.At(map.IndexOf({x + 0.02, y + 0.02, 1.22})),
                octree::Voxel::kFree);
    }
  }
}

TEST(OctomapBuilder, NewPosesGiveTheMapOfViewsInsertedThereBitForBit) {
  const std::vector<ViewPose> wrong = TurningPoses(8);
  std::vector<ViewPose> right = TurningPoses(8);
  for (ViewPose& pose : right) {
    pose.map_from_sensor =
        geometry::Rigid3{
            .rotation = geometry::Rotation3::FromAxisAngle({0.01, -0.02, 0.3}),
            .translation = {1.5, -0.7, 0.1}} *
        pose.map_from_sensor;
  }
  OctomapBuilder moved = MakeBuilder();
  InsertRoom(moved, wrong, wrong);
  const std::string before = *moved.FormatOt();
  ASSERT_TRUE(moved.SetPoses(right).ok());
  OctomapBuilder fresh = MakeBuilder();
  InsertRoom(fresh, wrong, right);
  EXPECT_TRUE(*moved.FormatOt() == *fresh.FormatOt());
  EXPECT_TRUE(*moved.Map() == *fresh.Map());
  EXPECT_FALSE(*moved.FormatOt() == before);
  // And back, one pose at a time.
  for (const ViewPose& pose : wrong) {
    ASSERT_TRUE(moved.SetPoses({&pose, 1}).ok());
  }
  EXPECT_TRUE(*moved.FormatOt() == before);
}

TEST(OctomapBuilder, WhatMovesAwayIsClearedByLaterViews) {
  const camera::Camera camera = SmallCamera();
  const geometry::Rigid3 pose = LevelCamera({0, 0, 1.2}, 0);
  const image::DepthImage empty = MakeRoomDepth(camera, pose, 1);
  // Somebody 1.5 m ahead, 0.5 m wide.
  image::DepthImage blocked = empty;
  for (int y = 60; y < 240; ++y) {
    for (int x = 110; x < 210; ++x) {
      blocked.values[static_cast<size_t>(y * 320 + x)] = 1500;
    }
  }
  OctomapBuilder builder = MakeBuilder();
  int64_t id = 0;
  const auto insert = [&](const image::DepthImage& depth) {
    ASSERT_TRUE(builder.InsertDepth(id++, depth, camera, pose).ok());
  };
  const auto is_occupied = [&builder] {
    const octree::VoxelMap map = *builder.Map();
    return map.At(map.IndexOf({1.52, 0.02, 1.22})) == octree::Voxel::kOccupied;
  };
  for (int i = 0; i < 10; ++i) insert(blocked);
  EXPECT_TRUE(is_occupied());
  // Clamped at log-odds 3.51: below 0.85 after seven misses of 0.41.
  for (int i = 0; i < 7; ++i) insert(empty);
  EXPECT_FALSE(is_occupied());
}

TEST(OctomapBuilder, LogOddsAreThoseOfTheOctomapLibrary) {
  base::Random random(3, 0);
  OctomapBuilder builder = MakeBuilder({.resolution_m = 0.1});
  octomap::OcTree tree(0.1);
  for (int view = 0; view < 6; ++view) {
    const geometry::Vec3 origin{0.31 + 0.1 * view, -0.22, 0.53};
    std::vector<geometry::Vec3> points;
    octomap::Pointcloud cloud;
    octomap::KeySet ends;
    for (int i = 0; i < 1500; ++i) {
      // In whole half millimetres, as clouds are kept.
      const auto draw = [&random] {
        return 0.0005 * (random.NextBelow(6000) + 0.0) - 1.5;
      };
      points.push_back({draw(), draw(), draw()});
      const geometry::Vec3 place = origin + points.back();
      const octomap::point3d point(static_cast<float>(place.x),
                                   static_cast<float>(place.y),
                                   static_cast<float>(place.z));
      // Ours casts one ray to each voxel, the first.
      if (ends.insert(tree.coordToKey(point)).second) cloud.push_back(point);
    }
    ASSERT_TRUE(
        builder
            .InsertPoints(view, points, {.rotation = {}, .translation = origin})
            .ok());
    tree.insertPointCloud(cloud,
                          octomap::point3d(static_cast<float>(origin.x),
                                           static_cast<float>(origin.y),
                                           static_cast<float>(origin.z)));
  }
  const auto ours = ReadByLibrary(*builder.FormatOt());
  ASSERT_NE(ours, nullptr);
  tree.expand();
  int64_t same = 0;
  int64_t all = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const octomap::OcTreeNode* const node = ours->search(leaf.getKey());
    ++all;
    if (node != nullptr && node->getLogOdds() == leaf->getLogOdds()) ++same;
  }
  EXPECT_GT(all, 20000);
  // The library casts rays in float: some pass by a corner on its other side.
  EXPECT_GT(same, all * 995 / 1000);
}

TEST(OctomapBuilder, ItsFilesAreReadAsItsMap) {
  OctomapBuilder builder = MakeBuilder();
  InsertRoom(builder, TurningPoses(5), TurningPoses(5));
  const octree::VoxelMap map = *builder.Map();
  const auto read = octree::ParseOctree(*builder.FormatOt(), "map.ot");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->CountOccupied(), map.CountOccupied());
  EXPECT_EQ(read->CountFree(), map.CountFree());
  // The library prunes and sums up just so.
  const auto tree = ReadByLibrary(*builder.FormatOt());
  ASSERT_NE(tree, nullptr);
  octomap::OcTree again(*tree);
  again.expand();
  again.updateInnerOccupancy();
  again.prune();
  EXPECT_TRUE(again == *tree);
}

TEST(OctomapBuilder, ChangesLieWithinTheChangedColumns) {
  OctomapBuilder builder = MakeBuilder();
  InsertRoom(builder, TurningPoses(6), TurningPoses(6));
  EXPECT_TRUE(builder.TakeChangedColumns().has_value());
  EXPECT_FALSE(builder.TakeChangedColumns().has_value());
  const octree::VoxelMap before = *builder.Map(64);
  // A post that was not there.
  const std::vector<geometry::Vec3> post = {{1, 0, 0}, {1, 0.05, 0}};
  const geometry::Rigid3 before_post{.rotation = {},
                                     .translation = {1.02, 0.02, 1.22}};
  for (const int64_t id : {1, 2, 3}) {
    ASSERT_TRUE(builder.InsertPoints(id, post, before_post).ok());
  }
  const octree::VoxelMap after = *builder.Map(64);
  ASSERT_EQ(before.lowest(), after.lowest());
  ASSERT_EQ(before.size(), after.size());
  const auto changed = builder.TakeChangedColumns();
  ASSERT_TRUE(changed.has_value());
  int64_t differences = 0;
  for (int x = 0; x < after.size().x; ++x) {
    for (int y = 0; y < after.size().y; ++y) {
      for (int z = 0; z < after.size().z; ++z) {
        if (before.At({x, y, z}) == after.At({x, y, z})) continue;
        ++differences;
        const int map_x = x + after.lowest().x;
        const int map_y = y + after.lowest().y;
        EXPECT_TRUE(map_x >= changed->begin_x && map_x < changed->end_x &&
                    map_y >= changed->begin_y && map_y < changed->end_y);
      }
    }
  }
  EXPECT_GT(differences, 0);
  EXPECT_LE(changed->end_x - changed->begin_x, 3);
}

TEST(OctomapBuilder, BoxesAreAligned) {
  OctomapBuilder builder = MakeBuilder();
  EXPECT_EQ(builder.Map()->size(), octree::VoxelIndex{});
  InsertRoom(builder, TurningPoses(4), TurningPoses(4));
  const octree::VoxelMap map = *builder.Map(100);
  EXPECT_EQ(map.lowest().x % 100, 0);
  EXPECT_EQ(map.size().y % 100, 0);
  EXPECT_EQ(map.CountOccupied(), builder.Map()->CountOccupied());
  EXPECT_EQ(builder.Map(0).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(OctomapBuilder, BadViewsAreRefusedAndChangeNothing) {
  OctomapBuilder builder = MakeBuilder();
  InsertRoom(builder, TurningPoses(3), TurningPoses(3));
  const std::string before = *builder.FormatOt();
  const camera::Camera camera = SmallCamera();
  const geometry::Rigid3 pose = LevelCamera({0, 0, 1}, 0);
  const image::DepthImage depth = MakeRoomDepth(camera, pose, 1);
  const auto code_of = [&](int64_t id,
                           const geometry::Rigid3& map_from_camera) {
    return builder.InsertDepth(id, depth, camera, map_from_camera).code();
  };
  EXPECT_EQ(code_of(100, pose), absl::StatusCode::kAlreadyExists);
  geometry::Rigid3 bad = pose;
  bad.translation.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code_of(1, bad), absl::StatusCode::kInvalidArgument);
  bad = pose;
  bad.rotation.w *= 1.1;
  EXPECT_EQ(code_of(1, bad), absl::StatusCode::kInvalidArgument);
  bad = pose;
  bad.translation.x = 1e9;
  EXPECT_EQ(code_of(1, bad), absl::StatusCode::kInvalidArgument);
  bad.translation.x = 1640;
  EXPECT_EQ(code_of(1, bad), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(builder.InsertDepth(1, depth, camera::Camera(), pose).code(),
            absl::StatusCode::kInvalidArgument);
  const ViewPose unknown{.id = 5, .map_from_sensor = pose};
  EXPECT_EQ(builder.SetPoses({&unknown, 1}).code(),
            absl::StatusCode::kNotFound);
  const ViewPose far{.id = 101, .map_from_sensor = bad};
  EXPECT_EQ(builder.SetPoses({&far, 1}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(builder.views(), 3);
  EXPECT_TRUE(*builder.FormatOt() == before);
  // Nothing seen is no error.
  image::DepthImage nothing = depth;
  std::fill(nothing.values.begin(), nothing.values.end(), uint16_t{0});
  EXPECT_TRUE(builder.InsertDepth(1, nothing, camera, pose).ok());
  EXPECT_TRUE(*builder.FormatOt() == before);
}

TEST(OctomapBuilder, MemoryIsBounded) {
  OctomapBuilder builder = MakeBuilder({.max_bytes = 4 << 20});
  const camera::Camera camera = SmallCamera();
  absl::Status status;
  std::string before;
  int64_t id = 0;
  while (status.ok() && id < 200) {
    before = *builder.FormatOt();
    const geometry::Rigid3 pose = LevelCamera(
        {0.1 * static_cast<double>(id), 0, 1.2}, 0.4 * static_cast<double>(id));
    status = builder.InsertDepth(
        id++, MakeRoomDepth(camera, LevelCamera({0, 0, 1.2}, 0), 1), camera,
        pose);
    EXPECT_LE(builder.memory().total(), (4 << 20) + (1 << 20));
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_GT(builder.views(), 3);
  EXPECT_TRUE(*builder.FormatOt() == before);
  // Absurd: 60 m of points at 1 cm.
  OctomapBuilder fine =
      MakeBuilder({.resolution_m = 0.01, .max_point_range_m = 60});
  const std::vector<geometry::Vec3> far = {{35, 35, 35}, {-35, -35, -35}};
  EXPECT_EQ(fine.InsertPoints(0, far, {}).code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(OctomapBuilder, OptionsOutOfRangeAreNamed) {
  const auto refused = [](const FusionOptions& options) {
    return OctomapBuilder::Make(options).status().code() ==
           absl::StatusCode::kInvalidArgument;
  };
  EXPECT_FALSE(refused({}));
  EXPECT_TRUE(refused({.resolution_m = 0}));
  EXPECT_TRUE(refused({.resolution_m = std::nan("")}));
  EXPECT_TRUE(refused({.hit_probability = 0.4}));
  EXPECT_TRUE(refused({.miss_probability = 0.6}));
  EXPECT_TRUE(refused({.occupied_threshold = 1}));
  EXPECT_TRUE(refused({.min_depth_m = 5}));
  EXPECT_TRUE(refused({.max_depth_m = 100}));
  EXPECT_TRUE(refused({.pixel_step = -1}));
  EXPECT_TRUE(refused({.outlier_neighbors = 9}));
  EXPECT_TRUE(refused({.clearing_range_m = 0}));
  EXPECT_TRUE(refused({.min_clearing_views = 0}));
  EXPECT_TRUE(refused({.min_clearing_share = std::nan("")}));
  EXPECT_TRUE(refused({.min_clearing_share_beside = -1}));
  EXPECT_TRUE(refused({.max_glimpses = -1}));
  EXPECT_TRUE(refused({.max_bytes = 1000}));
}

}  // namespace
}  // namespace treeline::fusion
