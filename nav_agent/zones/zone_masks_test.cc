#include "nav_agent/zones/zone_masks.h"

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::zones {
namespace {

using testing::HasSubstr;

class ZoneMasksTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    Write("m.pgm", "P2 4 1 255\n0 128 205 255\n");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string Write(const std::string& name, absl::string_view bytes) const {
    const std::string path = (folder_ / name).string();
    EXPECT_TRUE(base::WriteFileAtomically(path, bytes).ok());
    return path;
  }
  absl::StatusOr<std::vector<ZoneMask>> Read(const std::string& mode,
                                             const std::string& mask) {
    Write("m.yaml", "image: m.pgm\nresolution: 0.1\norigin: [1, 2, 0]\nmode: " +
                        mode + "\n");
    return ReadZoneMasks(
        Write("masks.yaml", "masks:\n  - file: m.yaml\n" + mask));
  }

  std::filesystem::path folder_;
};

// What Nav2's filters make of the same four pixels: black, grey, map_server's
// grey for unknown, white.
TEST_F(ZoneMasksTest, AKeepOutMaskKeepsOutOfBlack) {
  const auto masks = Read("trinary", "    filter: keep-out\n    level: 1\n");
  ASSERT_TRUE(masks.ok()) << masks.status();
  ASSERT_EQ(masks->size(), 1u);
  const ZoneMask& mask = masks->front();
  EXPECT_EQ(mask.kind, ZoneKind::kKeepOut);
  EXPECT_EQ(mask.level, 1);
  EXPECT_EQ(mask.name, "m.yaml");
  EXPECT_TRUE(mask.KeepsOut(mask.values->At({0, 0})));
  for (const int x : {1, 2, 3}) {
    EXPECT_FALSE(mask.KeepsOut(mask.values->At({x, 0}))) << x;
  }
  EXPECT_FALSE(mask.KeepsOut(std::nullopt));
}

TEST_F(ZoneMasksTest, ASpeedMaskGivesPercentsOrMetresASecond) {
  // In mode scale 128 of 255 has the occupancy (1 - 128 / 255 - 0.196) /
  // (0.65 - 0.196), which is 67 percent.
  auto masks = Read("scale", "    filter: speed-percent\n");
  ASSERT_TRUE(masks.ok()) << masks.status();
  const ZoneMask& percent = masks->front();
  EXPECT_EQ(percent.values->At({1, 0}), 67);
  EXPECT_NEAR(*percent.Limit_mps(67, 0.6), 0.402, 1e-9);
  EXPECT_EQ(percent.Limit_mps(0, 0.6), std::nullopt);
  EXPECT_EQ(percent.Limit_mps(100, 0.6), std::nullopt);
  EXPECT_EQ(percent.Limit_mps(std::nullopt, 0.6), std::nullopt);
  masks = Read("scale",
               "    filter: speed-mps\n    base: 1.0\n    multiplier: -0.01\n");
  ASSERT_TRUE(masks.ok()) << masks.status();
  EXPECT_NEAR(*masks->front().Limit_mps(67, 0.6), 0.33, 1e-9);
  // A robot that may not move at all is what keep-out zones are for.
  EXPECT_EQ(masks->front().Limit_mps(100, 0.6), kMinZoneSpeed_mps);
}

TEST_F(ZoneMasksTest, ARawMaskHasItsValuesAsTheyAre) {
  Write("m.pgm", "P2 4 1 255\n0 30 100 255\n");
  const auto masks = Read("raw", "    filter: speed-percent\n");
  ASSERT_TRUE(masks.ok()) << masks.status();
  EXPECT_EQ(masks->front().values->At({0, 0}), 0);
  EXPECT_EQ(masks->front().values->At({1, 0}), 30);
  EXPECT_EQ(masks->front().values->At({2, 0}), 100);
  EXPECT_EQ(masks->front().values->At({3, 0}), std::nullopt);
}

TEST_F(ZoneMasksTest, ErrorsNameFileAndLine) {
  EXPECT_THAT(
      std::string(Read("trinary", "    filter: speed\n").status().message()),
      HasSubstr("masks.yaml:3"));
  EXPECT_THAT(std::string(Read("trinary", "    filter: keep-out\n    base: 1\n")
                              .status()
                              .message()),
              HasSubstr("base and multiplier are of speed filters"));
  EXPECT_THAT(
      std::string(
          ReadZoneMasks(Write("none.yaml", "masks: []\n")).status().message()),
      HasSubstr("it lists no masks"));
  EXPECT_THAT(std::string(ReadZoneMasks(Write("lost.yaml",
                                              "masks:\n  - file: gone.yaml\n"
                                              "    filter: keep-out\n"))
                              .status()
                              .message()),
              HasSubstr("gone.yaml"));
  Write("m.pgm", "P5 4 1 255\n");
  EXPECT_FALSE(Read("trinary", "    filter: keep-out\n").ok());
}

}  // namespace
}  // namespace treeline::zones
