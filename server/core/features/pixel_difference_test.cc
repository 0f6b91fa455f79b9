#include "server/core/features/pixel_difference.h"

#include "gtest/gtest.h"

namespace treeline::features {
namespace {

// Pixel (x, y) has red 10 y + x, green 100 + that, blue 200.
PlanarImage Ramp() {
  image::ColorImage image{10, 8, {}};
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 10; ++x) {
      const int red = 10 * y + x;
      for (int value : {red, 100 + red, 200}) {
        image.rgb.push_back(static_cast<uint8_t>(value));
      }
    }
  }
  return PlanarImage(image);
}

TEST(PixelDifferenceTest, ComparesChannelsAtAnOffset) {
  // At 1 m and the reference focal length a delta of 4 is one pixel.
  const int32_t one_metre = InverseDepthQ12(kReferenceFocal_px, 1);
  EXPECT_EQ(one_metre, 4096);
  const PlanarImage image = Ramp();
  EXPECT_EQ(Evaluate({8, 12, 0, 0}, image, 3, 2, one_metre), 23 - 55);
  EXPECT_EQ(Evaluate({-8, -4, 2, 1}, image, 3, 2, one_metre), 200 - 111);
}

TEST(PixelDifferenceTest, LooksAtTheSameSpotFromTwiceTheDistance) {
  const PlanarImage image = Ramp();
  const int32_t near = InverseDepthQ12(kReferenceFocal_px, 1);
  const int32_t far = InverseDepthQ12(kReferenceFocal_px, 2);
  EXPECT_EQ(Evaluate({8, 8, 0, 0}, image, 4, 4, near), 44 - 66);
  EXPECT_EQ(Evaluate({8, 8, 0, 0}, image, 4, 4, far), 44 - 55);
}

TEST(PixelDifferenceTest, AndThroughALongerLens) {
  EXPECT_EQ(InverseDepthQ12(2 * kReferenceFocal_px, 2),
            InverseDepthQ12(kReferenceFocal_px, 1));
}

TEST(PixelDifferenceTest, ClampsToTheBorder) {
  const PlanarImage image = Ramp();
  const int32_t one_metre = InverseDepthQ12(kReferenceFocal_px, 1);
  EXPECT_EQ(Evaluate({511, 0, 0, 0}, image, 3, 2, one_metre), 23 - 29);
  EXPECT_EQ(Evaluate({0, -511, 0, 0}, image, 3, 2, one_metre), 23 - 3);
}

TEST(PixelDifferenceTest, OffsetsRoundToNearest) {
  const int32_t one_metre = InverseDepthQ12(kReferenceFocal_px, 1);
  EXPECT_EQ(OffsetPixels(1, one_metre), 0);
  EXPECT_EQ(OffsetPixels(2, one_metre), 1);
  EXPECT_EQ(OffsetPixels(-2, one_metre), 0);
  EXPECT_EQ(OffsetPixels(-3, one_metre), -1);
}

TEST(PixelDifferenceTest, InverseDepthStaysInRangeForAnyDepth) {
  EXPECT_EQ(InverseDepthQ12(525, 1e-9), 65535);
  EXPECT_EQ(InverseDepthQ12(525, 1e9), 1);
}

}  // namespace
}  // namespace treeline::features
