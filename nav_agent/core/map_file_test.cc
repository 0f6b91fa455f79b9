#include "nav_agent/core/map_file.h"

#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/file.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::core {
namespace {

using testing::HasSubstr;

class MapFileTest : public testing::Test {
 protected:
  std::string Write(const std::string& name, absl::string_view bytes) const {
    const std::string path = (folder_ / name).string();
    EXPECT_TRUE(base::WriteFileAtomically(path, bytes).ok());
    return path;
  }
  // A map of one row: 0, 100, 205, 254 of 255.
  std::string WriteMapWith(const std::string& settings) const {
    Write("m.pgm",
          absl::string_view("P5\n# a comment\n4 1\n255\n\0\x64\xcd\xfe", 28));
    return Write(
        "m.yaml",
        "image: m.pgm\nresolution: 0.1\norigin: [1, 2, 0]\n" + settings);
  }
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

constexpr Occupancy kF = Occupancy::kFree;
constexpr Occupancy kO = Occupancy::kOccupied;
constexpr Occupancy kU = Occupancy::kUnknown;

TEST_F(MapFileTest, ReadsWhatItWrites) {
  OccupancyGrid grid = OccupancyGrid::Filled(
      3, 2, 0.05, {.translation = {-1.5, 2.25}, .yaw_rad = 0.5}, kU);
  grid.cells = {kF, kO, kU, kO, kF, kF};
  const std::string path = (folder_ / "level.yaml").string();
  ASSERT_TRUE(WriteMap(grid, path).ok());
  const absl::StatusOr<OccupancyGrid> read = ReadMap(path);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->cells, grid.cells);
  EXPECT_EQ(read->width, 3);
  EXPECT_DOUBLE_EQ(read->resolution_m, 0.05);
  EXPECT_EQ(read->map_from_grid, grid.map_from_grid);
}

TEST_F(MapFileTest, TheFirstRowOfThePictureIsTheTopOfTheMap) {
  Write("m.pgm", "P2 1 2 255 0 254\n");
  const std::string path =
      Write("m.yaml", "image: m.pgm\nresolution: 1\norigin: [0, 0, 0]\n");
  const absl::StatusOr<OccupancyGrid> map = ReadMap(path);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->At({0, 1}), kO);
  EXPECT_EQ(map->At({0, 0}), kF);
  EXPECT_EQ(map->CellOf({0.5, 1.5}), (CellIndex{0, 1}));
}

TEST_F(MapFileTest, ThresholdsNegationAndModesAreMapServers) {
  EXPECT_THAT(ReadMap(WriteMapWith(""))->cells,
              testing::ElementsAre(kO, kU, kU, kF));
  EXPECT_THAT(ReadMap(WriteMapWith("negate: 1\n"))->cells,
              testing::ElementsAre(kF, kU, kO, kO));
  EXPECT_THAT(
      ReadMap(WriteMapWith("occupied_thresh: 0.6\nfree_thresh: 0.25\n"))->cells,
      testing::ElementsAre(kO, kO, kF, kF));
  EXPECT_THAT(ReadMap(WriteMapWith("mode: raw\n"))->cells,
              testing::ElementsAre(kF, kO, kU, kU));
}

TEST_F(MapFileTest, PngIsReadAsPgmIs) {
  const auto png = image::EncodePng(
      {.width = 4,
       .height = 1,
       .rgb = {0, 0, 0, 100, 100, 100, 205, 205, 205, 253, 254, 255}});
  ASSERT_TRUE(png.ok()) << png.status();
  Write("m.png", *png);
  const std::string path =
      Write("png.yaml", "image: m.png\nresolution: 0.1\norigin: [1, 2, 0.5]\n");
  const auto map = ReadMap(path);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->cells, ReadMap(WriteMapWith(""))->cells);
  Write("m.png", png->substr(0, 20));
  EXPECT_THAT(std::string(ReadMap(path).status().message()),
              HasSubstr("m.png"));
}

// Maps lie in one folder, and links to them where they are used.
TEST_F(MapFileTest, OfALinkThePictureIsBesideItOrBesideItsTarget) {
  Write("m.pgm", "P2 1 2 255 0 254\n");
  const std::string target =
      Write("m.yaml", "image: m.pgm\nresolution: 1\norigin: [0, 0, 0]\n");
  const std::filesystem::path elsewhere = folder_ / "used";
  std::filesystem::create_directory(elsewhere);
  std::filesystem::create_symlink(target, elsewhere / "link.yaml");
  const std::string link = (elsewhere / "link.yaml").string();
  const auto map = ReadMap(link);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->At({0, 1}), kO);
  // What lies beside the link counts more.
  std::ofstream(elsewhere / "m.pgm") << "P2 1 2 255 254 254\n";
  EXPECT_EQ(ReadMap(link)->At({0, 1}), kF);
  std::filesystem::remove(elsewhere / "m.pgm");
  std::filesystem::remove(folder_ / "m.pgm");
  EXPECT_THAT(std::string(ReadMap(link).status().message()),
              HasSubstr("used/m.pgm"));
}

TEST_F(MapFileTest, SaysWhatIsWrong) {
  const auto error = [](const std::string& path) {
    return std::string(ReadMap(path).status().message());
  };
  EXPECT_THAT(error(WriteMapWith("negate: 2\n")),
              HasSubstr("m.yaml:4: negate"));
  EXPECT_THAT(error(WriteMapWith("resolutoin: 2\n")),
              HasSubstr("did you mean 'resolution'?"));
  EXPECT_THAT(error(WriteMapWith("negate: 0\nnegate: 1\n")),
              HasSubstr("'negate' stands there twice"));
  EXPECT_THAT(error(Write("text.yaml", "no map\n")), HasSubstr("image"));
  EXPECT_THAT(error(WriteMapWith("occupied_thresh: 0.1\n")),
              HasSubstr("free_thresh, 0.196, is above occupied_thresh, 0.1"));
  EXPECT_THAT(error(Write("n.yaml", "image: none.pgm\nresolution: 0\n")),
              HasSubstr("n.yaml:2: resolution is 0"));
  EXPECT_EQ(ReadMap((folder_ / "absent.yaml").string()).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(WriteMap({}, "map.pgm").message(),
            "a map's name ends in .yaml; got map.pgm");
}

TEST(ParsePgm, RefusesWhatIsBroken) {
  const auto error = [](absl::string_view bytes) {
    return std::string(ParsePgm(bytes, "p").status().message());
  };
  EXPECT_EQ(error("P6 1 1 255 x"),
            "p: this is neither a PGM (P5 or P2) nor a PNG picture");
  EXPECT_THAT(error("P5 0 1 255 "), HasSubstr("out of range"));
  EXPECT_THAT(error("P5 1000000 1000000 255 x"), HasSubstr("too short for"));
  EXPECT_THAT(error("P5 4 1 255\nab"), HasSubstr("ends after 2 of 4 bytes"));
  EXPECT_THAT(error("P2 2 1 9 1 10 "), HasSubstr("not in 0..9"));
  EXPECT_THAT(error("P5 1 1 9\nz"), HasSubstr("grey level 122 is above 9"));
  EXPECT_THAT(error("P5 1 1 65535\nz"), HasSubstr("ends after 1 of 2 bytes"));
}

}  // namespace
}  // namespace treeline::core
