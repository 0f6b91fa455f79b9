#include "simulation/worlds/texture.h"

#include <cmath>

#include "gtest/gtest.h"
#include "simulation/worlds/noise.h"

namespace treeline::worlds {
namespace {

// A texel and its neighbours differ; what is not yet blended shows.
Canvas Checkers(int width, int height) {
  Canvas canvas(width, height);
  canvas.Paint([](int x, int y) {
    return (x + y) % 2 == 0 ? Float3{1, 1, 1} : Float3{0, 0, 0};
  });
  return canvas;
}

TEST(TextureTest, TexelCentresAreExact) {
  Canvas canvas(4, 2);
  canvas.Paint([](int x, int y) {
    return Float3{static_cast<float>(x) / 4, static_cast<float>(y) / 2, 0.5f};
  });
  const Texture texture(canvas);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      const Float3 color =
          texture.Sample((static_cast<float>(x) + 0.5f) / 4,
                         (static_cast<float>(y) + 0.5f) / 2, 1);
      // Stored in steps of 1/255.
      EXPECT_NEAR(std::sqrt(color.x), static_cast<float>(x) / 4, 0.003);
      EXPECT_NEAR(std::sqrt(color.y), static_cast<float>(y) / 2, 0.003);
      EXPECT_NEAR(std::sqrt(color.z), 0.5f, 0.003);
    }
  }
}

TEST(TextureTest, IsLinearBetweenTexelsAndRepeats) {
  Canvas canvas(2, 1, {0, 0, 0});
  canvas.Rect(1, 0, 2, 1, {1, 1, 1});
  const Texture texture(canvas);
  // Texel centres at u = 1/4 (black) and 3/4 (white).
  EXPECT_NEAR(std::sqrt(texture.Sample(0.5f, 0.5f, 1).x), 0.5, 0.01);
  EXPECT_NEAR(std::sqrt(texture.Sample(0.625f, 0.5f, 1).x), 0.75, 0.01);
  // Across the border from white to black again, and so on.
  EXPECT_NEAR(std::sqrt(texture.Sample(1.0f, 0.5f, 1).x), 0.5, 0.01);
  EXPECT_NEAR(std::sqrt(texture.Sample(-3.25f, 7.5f, 1).x), 1, 0.01);
  EXPECT_NEAR(std::sqrt(texture.Sample(5.25f, -2.5f, 1).x), 0, 0.01);
}

TEST(TextureTest, FarAwayOnlyTheMeanReflectanceIsLeft) {
  const Texture texture(Checkers(64, 32));
  // Half the light, not half of the displayed value.
  EXPECT_NEAR(texture.Mean().x, 0.5, 0.01);
  EXPECT_NEAR(texture.Sample(0.3f, 0.8f, 64 * 64).y, 0.5, 0.01);
  EXPECT_NEAR(texture.Sample(0.3f, 0.8f, 1e9f).y, 0.5, 0.01);
  // Already four texels level it out.
  EXPECT_NEAR(texture.Sample(0.3f, 0.8f, 4).z, 0.5, 0.01);
}

TEST(CanvasTest, RectCoversPartsOfPixels) {
  Canvas canvas(4, 4, {0, 0, 0});
  canvas.Rect(1, 1, 3, 2.5f, {1, 1, 1});
  EXPECT_EQ(canvas.at(0, 1).x, 0);
  EXPECT_EQ(canvas.at(1, 1).x, 1);
  EXPECT_EQ(canvas.at(2, 1).x, 1);
  EXPECT_EQ(canvas.at(3, 1).x, 0);
  EXPECT_NEAR(canvas.at(1, 2).x, 0.5, 1e-6);
  EXPECT_EQ(canvas.at(1, 3).x, 0);
}

TEST(CanvasTest, WhatLiesOutsideIsCutOff) {
  Canvas canvas(4, 4, {0, 0, 0});
  canvas.Disc(-10, -10, 5, {1, 1, 1});
  canvas.Rect(-100, 3, 100, 300, {1, 1, 1});
  canvas.Line(-5, -5, -1, 20, 2, {1, 1, 1});
  EXPECT_EQ(canvas.at(0, 0).x, 0);
  EXPECT_EQ(canvas.at(0, 3).x, 1);
  EXPECT_EQ(canvas.at(3, 3).x, 1);
}

TEST(CanvasTest, DiscAndPolygonHaveTheirAreas) {
  const auto area = [](const Canvas& canvas) {
    double sum = 0;
    for (int y = 0; y < canvas.height(); ++y) {
      for (int x = 0; x < canvas.width(); ++x) sum += canvas.at(x, y).x;
    }
    return sum;
  };
  Canvas disc(64, 64, {0, 0, 0});
  disc.Disc(32, 32, 20, {1, 1, 1});
  EXPECT_NEAR(area(disc), 3.14159 * 400, 6);
  Canvas diamond(64, 64, {0, 0, 0});
  const Canvas::Point corners[] = {{32, 12}, {52, 32}, {32, 52}, {12, 32}};
  diamond.Polygon(corners, {1, 1, 1});
  EXPECT_NEAR(area(diamond), 800, 6);
}

TEST(NoiseTest, CellsAreUniform) {
  // Mean 1/2 and variance 1/12; the mean of 10,000 has sigma 0.003.
  double sum = 0;
  double squares = 0;
  for (int y = -50; y < 50; ++y) {
    for (int x = -50; x < 50; ++x) {
      const double value = CellNoise(x, y, 3);
      ASSERT_GE(value, 0);
      ASSERT_LT(value, 1);
      sum += value;
      squares += value * value;
    }
  }
  EXPECT_NEAR(sum / 10000, 0.5, 0.012);
  EXPECT_NEAR(squares / 10000 - (sum / 10000) * (sum / 10000), 1.0 / 12, 0.004);
  EXPECT_NE(CellNoise(1, 2, 3), CellNoise(2, 1, 3));
  EXPECT_NE(CellNoise(1, 2, 3), CellNoise(1, 2, 4));
}

TEST(NoiseTest, ValuesAreContinuousAndMeetTheCells) {
  EXPECT_EQ(ValueNoise(3, -2, 7), CellNoise(3, -2, 7));
  for (float x = -2; x < 2; x += 0.01f) {
    // The fade's slope is at most 15/8 per unit.
    EXPECT_NEAR(ValueNoise(x, 0.3f, 7), ValueNoise(x + 0.01f, 0.3f, 7), 0.02);
  }
}

TEST(NoiseTest, PeriodsTile) {
  FractalNoise tiled(5, 3, 4);
  FractalNoise endless(5, 3);
  for (float x = 0; x < 4; x += 0.37f) {
    EXPECT_NEAR(tiled.At(x, 1.7f), tiled.At(x + 4, 1.7f - 8), 1e-4);
  }
  EXPECT_GT(std::abs(endless.At(0.5f, 0.5f) - endless.At(4.5f, 0.5f)), 1e-3);
}

TEST(NoiseTest, WhatItRemembersDoesNotChangeTheAnswer) {
  FractalNoise in_order(5, 4);
  for (int i = 0; i < 500; ++i) {
    // Along a row, then a jump back to the next.
    const float x = 0.13f * static_cast<float>(i % 100) - 3;
    const float y = 0.7f * static_cast<float>(i / 100);
    FractalNoise fresh(5, 4);
    ASSERT_EQ(in_order.At(x, y), fresh.At(x, y)) << i;
  }
}

}  // namespace
}  // namespace treeline::worlds
