#include "nav_agent/octomap/octree_file.h"

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <filesystem>
#include <memory>
#include <sstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::octree {
namespace {

using testing::HasSubstr;

// Clumps of both kinds, so that some of the tree is pruned.
VoxelMap RandomMap(uint64_t seed) {
  VoxelMap map =
      *VoxelMap::Make(0.1, {.x = -13, .y = 5, .z = -70}, {21, 30, 130});
  base::Random random(seed, 0);
  for (int i = 0; i < 60; ++i) {
    const auto below = [&random](int bound) {
      return static_cast<int>(random.NextBelow(static_cast<uint32_t>(bound)));
    };
    const int x = below(map.size().x - 8);
    const int y = below(map.size().y - 8);
    const int z = below(map.size().z - 16);
    const Voxel value = i % 2 == 0 ? Voxel::kFree : Voxel::kOccupied;
    const int width = 1 + below(8);
    for (int dy = 0; dy < width; ++dy) {
      for (int dx = 0; dx < width; ++dx) {
        map.SetRun(x + dx, y + dy, z, z + 2 * width, value);
      }
    }
  }
  return map;
}

octomap::point3d PointOf(const VoxelMap& map, VoxelIndex v) {
  const geometry::Vec3 center = map.CenterOf(v);
  return {static_cast<float>(center.x), static_cast<float>(center.y),
          static_cast<float>(center.z)};
}

octomap::OcTree TreeOf(const VoxelMap& map) {
  octomap::OcTree tree(map.resolution_m());
  for (int x = 0; x < map.size().x; ++x) {
    for (int y = 0; y < map.size().y; ++y) {
      for (int z = 0; z < map.size().z; ++z) {
        const Voxel value = map.At({x, y, z});
        if (value == Voxel::kUnknown) continue;
        tree.setNodeValue(PointOf(map, {x, y, z}),
                          value == Voxel::kOccupied ? 3.5F : -2.0F);
      }
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

// How many voxels of `map` (and a border of two around it) differ from `tree`.
int CountDifferences(const VoxelMap& map, const octomap::OcTree& tree) {
  int differences = 0;
  for (int x = -2; x < map.size().x + 2; ++x) {
    for (int y = -2; y < map.size().y + 2; ++y) {
      for (int z = -2; z < map.size().z + 2; ++z) {
        const octomap::OcTreeNode* node = tree.search(PointOf(map, {x, y, z}));
        const Voxel in_tree = node == nullptr             ? Voxel::kUnknown
                              : tree.isNodeOccupied(node) ? Voxel::kOccupied
                                                          : Voxel::kFree;
        if (in_tree != map.At({x, y, z})) ++differences;
      }
    }
  }
  return differences;
}

TEST(OctreeFile, ReadsWhatOctomapWrites) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    octomap::OcTree tree = TreeOf(RandomMap(seed));
    std::stringstream bt;
    std::stringstream ot;
    ASSERT_TRUE(tree.write(ot));
    ASSERT_TRUE(tree.writeBinary(bt));
    const absl::StatusOr<VoxelMap> from_bt = ParseOctree(bt.str(), "m.bt");
    const absl::StatusOr<VoxelMap> from_ot = ParseOctree(ot.str(), "m.ot");
    ASSERT_TRUE(from_bt.ok()) << from_bt.status();
    ASSERT_TRUE(from_ot.ok()) << from_ot.status();
    EXPECT_EQ(CountDifferences(*from_bt, tree), 0);
    EXPECT_TRUE(*from_bt == *from_ot);
    EXPECT_DOUBLE_EQ(from_bt->resolution_m(), 0.1);
  }
}

TEST(OctreeFile, OctomapReadsWhatItWrites) {
  for (const uint64_t seed : {4u, 5u}) {
    const VoxelMap map = RandomMap(seed);
    octomap::OcTree from_bt(0.1);
    std::stringstream bt(*FormatBt(map));
    ASSERT_TRUE(from_bt.readBinary(bt));
    EXPECT_EQ(CountDifferences(map, from_bt), 0);

    std::stringstream ot(*FormatOt(map));
    const std::unique_ptr<octomap::AbstractOcTree> read(
        octomap::AbstractOcTree::read(ot));
    const auto* from_ot = dynamic_cast<octomap::OcTree*>(read.get());
    ASSERT_NE(from_ot, nullptr);
    EXPECT_EQ(CountDifferences(map, *from_ot), 0);
    // The same tree as the library's own, inner nodes included.
    EXPECT_TRUE(*from_ot == TreeOf(map));
  }
}

TEST(OctreeFile, WritesTheSameBytesAsOctomap) {
  const VoxelMap map = RandomMap(6);
  octomap::OcTree tree = TreeOf(map);
  std::stringstream bt;
  ASSERT_TRUE(tree.writeBinary(bt));
  const std::string ours = *FormatBt(map);
  const std::string theirs = bt.str();
  EXPECT_TRUE(ours.substr(ours.find("\ndata\n")) ==
              theirs.substr(theirs.find("\ndata\n")));
}

TEST(OctreeFile, ReadsColouredTreesWithoutTheirColours) {
  octomap::ColorOcTree tree(0.05);
  tree.updateNode(octomap::point3d(0.02F, 0.02F, 0.02F), true);
  tree.setNodeColor(tree.coordToKey(0.02, 0.02, 0.02), 10, 20, 30);
  std::stringstream ot;
  ASSERT_TRUE(tree.write(ot));
  const absl::StatusOr<VoxelMap> map = ParseOctree(
      ot.str(), "m.ot", {.occupied_threshold = 0.65, .max_bytes = 1 << 20});
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->CountOccupied(), 1);
  EXPECT_EQ(map->lowest(), VoxelIndex{});
}

TEST(OctreeFile, TheThresholdDecidesWhatIsOccupied) {
  octomap::OcTree tree(0.05);
  // One hit: probability 0.7 in the library's sensor model, in floats.
  tree.updateNode(octomap::point3d(0.02F, 0.02F, 0.02F), true);
  std::stringstream ot;
  ASSERT_TRUE(tree.write(ot));
  const auto occupied_at = [&ot](double threshold) {
    return ParseOctree(ot.str(), "m.ot",
                       {.occupied_threshold = threshold, .max_bytes = 1 << 20})
        ->CountOccupied();
  };
  EXPECT_EQ(occupied_at(0.69), 1);
  EXPECT_EQ(occupied_at(0.71), 0);
}

TEST(OctreeFile, AnEmptyTreeIsAnEmptyMap) {
  octomap::OcTree tree(0.05);
  std::stringstream bt;
  ASSERT_TRUE(tree.writeBinary(bt));
  const absl::StatusOr<VoxelMap> map = ParseOctree(bt.str(), "m.bt");
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->size(), VoxelIndex{});
  EXPECT_TRUE(ParseOctree(*FormatOt(*map), "m.ot").ok());
}

TEST(OctreeFile, EveryTruncationIsAnError) {
  for (const std::string& bytes :
       {*FormatBt(RandomMap(7)), *FormatOt(RandomMap(7))}) {
    for (size_t length = 0; length < bytes.size();
         length += length < 200 ? 1 : 37) {
      const absl::StatusOr<VoxelMap> map =
          ParseOctree(absl::string_view(bytes).substr(0, length), "m.bt");
      ASSERT_EQ(map.status().code(), absl::StatusCode::kInvalidArgument);
      EXPECT_THAT(std::string(map.status().message()), HasSubstr("m.bt: "));
    }
    EXPECT_THAT(std::string(ParseOctree(bytes + "x", "m").status().message()),
                HasSubstr("1 bytes follow the last node"));
  }
}

std::string BinaryTree(absl::string_view body, int nodes) {
  return absl::StrCat("# Octomap OcTree binary file\nid OcTree\nsize ", nodes,
                      "\nres 0.05\ndata\n", body);
}

TEST(OctreeFile, HostileTreesAreRefused) {
  // Each node has one child that is a node, for ever.
  std::string deep;
  for (int i = 0; i < 1000; ++i) deep += std::string("\x03\0", 2);
  EXPECT_THAT(
      std::string(ParseOctree(BinaryTree(deep, 1001), "m").status().message()),
      HasSubstr("deeper than OctoMap's 16 levels"));
  // Two bytes that fill an eighth of all space.
  const absl::StatusOr<VoxelMap> huge =
      ParseOctree(BinaryTree(std::string("\x02\0", 2), 2), "m");
  EXPECT_EQ(huge.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(huge.status().message()),
              HasSubstr("32768 x 32768 x 32768 voxels"));
  EXPECT_THAT(
      std::string(ParseOctree(BinaryTree(std::string(2, '\0'), 999), "m")
                      .status()
                      .message()),
      HasSubstr("its head says 999 nodes, but there are 1"));
}

TEST(OctreeFile, HeadsWithErrorsSayWhat) {
  const auto error = [](absl::string_view bytes) {
    return std::string(ParseOctree(bytes, "m.bt").status().message());
  };
  EXPECT_THAT(error("P5\n"), HasSubstr("m.bt: this is not an OctoMap"));
  const std::string magic = "# Octomap OcTree binary file\n";
  EXPECT_THAT(error(magic + "id CountingOcTree\n"),
              HasSubstr("kind 'CountingOcTree'"));
  EXPECT_THAT(error(magic + "size many\n"), HasSubstr("'size'"));
  EXPECT_THAT(error(magic + "res nan\n"), HasSubstr("'res'"));
  EXPECT_THAT(error(magic + "data\n"), HasSubstr("lacks 'id'"));
  EXPECT_THAT(error(magic + "res 0.05\n"), HasSubstr("end with 'data'"));
}

TEST(OctreeFile, FilesAreChosenByTheirNames) {
  const VoxelMap map = RandomMap(8);
  const std::string folder = testing::TempDir();
  for (const char* name : {"/octree_file_test.bt", "/octree_file_test.ot"}) {
    ASSERT_TRUE(WriteOctree(map, folder + name).ok());
    const absl::StatusOr<VoxelMap> read = ReadOctree(folder + name);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->CountOccupied(), map.CountOccupied());
    EXPECT_EQ(read->CountFree(), map.CountFree());
    std::filesystem::remove(folder + name);
  }
  EXPECT_EQ(WriteOctree(map, folder + "/map.vrml").code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(OctreeFile, MapsTooFarFromTheOriginAreNotWritten) {
  const VoxelMap map =
      *VoxelMap::Make(0.05, {.x = 32760, .y = 0, .z = 0}, {9, 1, 1});
  EXPECT_EQ(FormatBt(map).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::octree
