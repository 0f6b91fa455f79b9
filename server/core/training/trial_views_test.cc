#include "server/core/training/trial_views.h"

#include "gtest/gtest.h"

namespace treeline::training {
namespace {

// 4 x 2 pixels, channel c of pixel i is 10 i + c, depth of pixel i is i + 1.
image::Frame SmallFrame() {
  image::Frame frame;
  frame.color = {.width = 4, .height = 2, .rgb = {}};
  frame.depth.emplace();
  frame.depth->width = 4;
  frame.depth->height = 2;
  for (int i = 0; i < 8; ++i) {
    for (int c = 0; c < 3; ++c) {
      frame.color.rgb.push_back(static_cast<uint8_t>(10 * i + c));
    }
    frame.depth->values.push_back(static_cast<uint16_t>(i + 1));
  }
  return frame;
}

TEST(TrialViewsTest, AMirrorTurnsRowsRoundInColorAndDepth) {
  const image::Frame mirrored = Mirrored(SmallFrame());
  EXPECT_EQ(mirrored.color.rgb[0], 30);
  EXPECT_EQ(mirrored.color.rgb[3 * 7 + 2], 42);
  EXPECT_EQ(mirrored.depth->values,
            (std::vector<uint16_t>{4, 3, 2, 1, 8, 7, 6, 5}));
}

TEST(TrialViewsTest, ACoverLeavesAWindow) {
  image::Frame cover = SmallFrame();
  std::ranges::fill(cover.color.rgb, uint8_t{200});
  std::ranges::fill(cover.depth->values, uint16_t{9});
  const image::Frame covered = Covered(
      SmallFrame(), cover, {.left = 0.5, .top = 0, .right = 1, .bottom = 0.5});
  EXPECT_EQ(covered.depth->values,
            (std::vector<uint16_t>{9, 9, 3, 4, 9, 9, 9, 9}));
  EXPECT_EQ(covered.color.rgb[3 * 2], 20);
  EXPECT_EQ(covered.color.rgb[3 * 6], 200);
}

TEST(TrialViewsTest, LightChangesColorsAlone) {
  const image::Frame frame = SmallFrame();
  const image::Frame dim = Relit(frame, {.gain = {0.5, 1, 2}});
  EXPECT_EQ(dim.color.rgb[3 * 4], 20);
  EXPECT_EQ(dim.color.rgb[3 * 4 + 1], 41);
  EXPECT_EQ(dim.color.rgb[3 * 4 + 2], 84);
  EXPECT_EQ(dim.depth->values, frame.depth->values);
  const image::Frame gray = Relit(frame, {.gamma = 1, .is_gray = true});
  EXPECT_EQ(gray.color.rgb[6], gray.color.rgb[7]);
  EXPECT_EQ(gray.color.rgb[6], gray.color.rgb[8]);
  EXPECT_FALSE(WithoutDepth(frame).depth.has_value());
}

TEST(TrialViewsTest, BlurSmearsAlongRows) {
  image::Frame frame = SmallFrame();
  std::ranges::fill(frame.color.rgb, uint8_t{0});
  frame.color.rgb[3] = 90;
  const image::Frame blurred = Blurred(frame, 1);
  EXPECT_EQ(blurred.color.rgb[0], 45);
  EXPECT_EQ(blurred.color.rgb[3], 30);
  EXPECT_EQ(blurred.color.rgb[6], 30);
  EXPECT_EQ(blurred.color.rgb[9], 0);
  EXPECT_EQ(blurred.color.rgb[12], 0);
}

}  // namespace
}  // namespace treeline::training
