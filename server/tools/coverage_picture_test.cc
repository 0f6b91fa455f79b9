#include "server/tools/coverage_picture.h"

#include <array>
#include <map>

#include "gtest/gtest.h"

namespace treeline::tools {
namespace {

using Color = std::array<uint8_t, 3>;

// A corridor of `places` open places of 0.25 m along x.
keyframes::CoverageMap Corridor(int places) {
  keyframes::CoverageMap coverage{
      .cell_m = 0.25, .columns = places, .rows = 1, .headings = 16};
  coverage.places.assign(static_cast<size_t>(places), {.is_open = true});
  return coverage;
}

std::map<Color, int> Colors(const image::ColorImage& picture) {
  std::map<Color, int> counts;
  for (size_t i = 0; i + 2 < picture.rgb.size(); i += 3) {
    ++counts[{picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]}];
  }
  return counts;
}

image::ColorImage Draw(const keyframes::CoverageMap& coverage) {
  return DrawCoverage({}, coverage, "test");
}

TEST(CoveragePictureTest, PlacesAreAsLargeAsTheScaleSays) {
  keyframes::CoverageMap coverage = Corridor(8);
  for (keyframes::CoveragePlace& place : coverage.places) place.good = 0xffff;
  const int covered = Colors(Draw(coverage))[{253, 231, 37}];
  // 2 m x 0.25 m, at the scale that makes 2.8 m 1000 pixels, to two pixels on
  // each side.
  EXPECT_GE(covered, 710 * 85);
  EXPECT_LE(covered, 718 * 93);
}

TEST(CoveragePictureTest, MoreHeadingsAreOfAnotherColour) {
  const Color none{226, 226, 230};
  const Color all{253, 231, 37};
  keyframes::CoverageMap coverage = Corridor(8);
  EXPECT_GT(Colors(Draw(coverage))[none], 60000);
  for (size_t i = 0; i < 4; ++i) coverage.places[i].good = 0xffff;
  std::map<Color, int> half = Colors(Draw(coverage));
  EXPECT_NEAR(half[none], half[all], 2000);
}

TEST(CoveragePictureTest, APictureOfATallSceneIsNotTooTall) {
  keyframes::CoverageMap coverage = Corridor(1);
  coverage.rows = 400;
  coverage.places.assign(400, {.is_open = true, .good = 1});
  const image::ColorImage picture = Draw(coverage);
  EXPECT_LE(picture.height, 1300);
  EXPECT_GE(picture.width, 700);
  EXPECT_EQ(picture.rgb.size(), 3u * static_cast<size_t>(picture.width) *
                                    static_cast<size_t>(picture.height));
}

TEST(CoveragePictureTest, MarksAreDrawnWhereTheyAre) {
  const Color mark{200, 30, 30};
  const keyframes::CoverageMap coverage = Corridor(8);
  EXPECT_EQ(Colors(Draw(coverage))[mark], 0);
  const image::ColorImage picture =
      DrawCoverage({}, coverage, "test",
                   {.letters = {{.text = "A", .x_m = 0.5, .y_m = 0.125}},
                    .crosses = {{.x_m = 1.5, .y_m = 0.125}}});
  // 357 pixels to the metre; the plan begins 0.4 m to the left of x = 0.
  double letter_x = 0;
  int letter = 0;
  int cross = 0;
  for (int x = 0; x < picture.width; ++x) {
    for (int y = 0; y < picture.height; ++y) {
      const size_t i = 3 * static_cast<size_t>(y * picture.width + x);
      if (picture.rgb[i] != mark[0] || picture.rgb[i + 1] != mark[1] ||
          picture.rgb[i + 2] != mark[2]) {
        continue;
      }
      if (x < 28 + 1.4 * 357) {
        letter_x += x;
        ++letter;
      } else {
        ++cross;
      }
    }
  }
  EXPECT_GT(letter, 200);
  EXPECT_GT(cross, 10);
  EXPECT_NEAR(letter_x / letter, 28 + (0.5 + 0.4) * 357, 3);
}

}  // namespace
}  // namespace treeline::tools
