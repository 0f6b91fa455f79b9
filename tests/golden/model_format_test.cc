// A model file of each format version that was ever released is still read,
// and the current version is still written, byte for byte.
//
// If a change of the format is intended, raise kModelFormatVersion, add the
// next golden file, and keep the old ones readable.
#include <unistd.h>

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"

namespace treeline {
namespace {

std::string GoldenPath(const std::string& name) {
  return std::string(TREELINE_GOLDEN_FOLDER) + "/model-v" + name + ".bin";
}

// What the golden files hold: two trees, one with a split and one without.
forest::Forest GoldenForest() {
  forest::Forest forest;
  forest.nodes = {forest::Node::Split({-511, 3, 2, 1}, -7, 2),
                  forest::Node::Leaf(0), forest::Node::Leaf(1),
                  forest::Node::Leaf(2)};
  forest.tree_offsets = {0, 3, 4};
  forest.descriptors.resize(3);
  forest.descriptors[0].values[0] = 127;
  forest.descriptors[1].values[59] = -127;
  forest.payloads = {{{0, 32768, 65535}, {1, 2, 3, 4, 5, 6}, 7},
                     {{8, 9, 10}, {11, 12, 13, 14, 15, 16}, 17},
                     {{18, 19, 20}, {21, 22, 23, 24, 25, 26}, 65535}};
  forest.bounds_min_in_world = {-1.25, 0.5, 0};
  forest.bounds_max_in_world = {2, 3, 4};
  return forest;
}

// What the packed one holds: a tree of 256 leaves, each a number in base 2.
forest::Forest LargerGoldenForest() {
  forest::Forest forest;
  const auto grow = [&](const auto& self, uint32_t leaves) -> void {
    if (leaves == 1) {
      const auto n = static_cast<uint16_t>(forest.payloads.size());
      forest.nodes.push_back(forest::Node::Leaf(n));
      forest.descriptors.emplace_back().values[3] =
          static_cast<int8_t>(n % 7 - 3);
      forest.payloads.push_back({{n, 7, static_cast<uint16_t>(9 * n)}, {}, 5});
      return;
    }
    const size_t split = forest.nodes.size();
    forest.nodes.emplace_back();
    self(self, leaves / 2);
    forest.nodes[split] =
        forest::Node::Split({static_cast<int16_t>(leaves), -3, 1, 2}, -9,
                            static_cast<uint32_t>(forest.nodes.size() - split));
    self(self, leaves / 2);
  };
  grow(grow, 256);
  forest.tree_offsets = {0, static_cast<uint32_t>(forest.nodes.size())};
  forest.bounds_max_in_world = {1, 2, 3};
  return forest;
}

template <typename T>
bool SameBytes(std::span<const T> a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

forest::ModelInfo GoldenInfo() {
  forest::ModelInfo info;
  info.method = "rgbd";
  info.software_version = "0.1.0";
  info.created_utc = "2026-11-21T09:30:00Z";
  info.dataset = "7scenes:kitchen";
  info.seed = 18446744073709551615u;
  info.options = {{"trees", "2"}, {"max-depth", "25"}};
  info.calibration.color_from_depth = {geometry::Rotation3{},
                                       {-0.025, 0, 0.0078125}};
  info.calibration.depth_scale = 0.9921875;
  info.calibration.pose_sensor = camera::RgbdSensor::kDepth;
  info.training_frames = 500;
  info.training_samples = 2500000;
  info.training_s = 12.5;
  return info;
}

class EveryVersionTest : public testing::TestWithParam<uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Written, EveryVersionTest, testing::Values(1u, 2u));

TEST_P(EveryVersionTest, IsRead) {
  const auto model =
      forest::ModelFile::Open(GoldenPath(std::to_string(GetParam())));
  ASSERT_TRUE(model.ok()) << model.status();
  const forest::ModelInfo& info = (*model)->info();
  EXPECT_EQ(info.format_version, GetParam());
  EXPECT_EQ(info.memory_bytes, info.file_bytes);  // nothing is packed
  EXPECT_EQ(info.trees, 2);
  EXPECT_EQ(info.leaves, 3);
  EXPECT_EQ(info.seed, GoldenInfo().seed);
  EXPECT_EQ(info.options, GoldenInfo().options);
  EXPECT_EQ(info.calibration, GoldenInfo().calibration);
  EXPECT_EQ(info.training_samples, 2500000);

  const forest::ForestView& forest = (*model)->forest();
  const features::PixelDifference feature = forest.tree(0)[0].feature();
  EXPECT_EQ(feature.dx, -511);
  EXPECT_EQ(feature.dy, 3);
  EXPECT_EQ(feature.c1, 2);
  EXPECT_EQ(feature.c2, 1);
  EXPECT_EQ(forest.tree(0)[0].threshold(), -7);
  EXPECT_EQ(forest.tree(0)[0].right_offset(), 2u);
  EXPECT_TRUE(forest.tree(1)[0].is_leaf());
  EXPECT_EQ(forest.tree(1)[0].leaf(), 2u);
  EXPECT_EQ(forest.descriptors[1].values[59], -127);
  EXPECT_EQ(forest.payloads[2].count, 65535);
  EXPECT_EQ(forest.payloads[1].covariance[5], 16);
  EXPECT_EQ(forest.LeafMean(0).x, -1.25);
  EXPECT_EQ(forest.LeafMean(0).z, 4);
}

// How short a section becomes is zstd's affair, what it becomes is not.
TEST(ModelFormatTest, PackedSectionsAreRead) {
  const auto model = forest::ModelFile::Open(GoldenPath("2-packed"));
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_GT((*model)->info().memory_bytes, 5 * (*model)->info().file_bytes);
  const forest::Forest expected = LargerGoldenForest();
  const forest::ForestView& forest = (*model)->forest();
  EXPECT_TRUE(SameBytes(forest.nodes, expected.nodes));
  EXPECT_TRUE(SameBytes(forest.descriptors, expected.descriptors));
  EXPECT_TRUE(SameBytes(forest.payloads, expected.payloads));
}

TEST(ModelFormatTest, TheCurrentVersionIsWrittenByteForByte) {
  const std::string path =
      testing::TempDir() + "/model_format_" + std::to_string(getpid());
  ASSERT_TRUE(
      forest::WriteModel(path, GoldenInfo(), {GoldenForest().View()}).ok());
  const auto written = base::ReadFile(path);
  unlink(path.c_str());
  ASSERT_TRUE(written.ok());
  const auto golden =
      base::ReadFile(GoldenPath(std::to_string(forest::kModelFormatVersion)));
  ASSERT_TRUE(golden.ok()) << golden.status();
  EXPECT_EQ(*written, *golden);
}

}  // namespace
}  // namespace treeline
