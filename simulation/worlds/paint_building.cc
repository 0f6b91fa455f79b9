#include "simulation/worlds/paint_building.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"
#include "simulation/worlds/noise.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {
namespace {

constexpr int kWide = 2048;
constexpr int kHigh = 1024;

float Float(int i) { return static_cast<float>(i); }

float UniformFloat(base::Random& random, float low, float high) {
  return static_cast<float>(random.NextUniform(low, high));
}

// Noise of kWide / period pixels to a unit, without a seam in a picture that
// is kWide wide.
class SeamlessNoise {
 public:
  SeamlessNoise(uint64_t seed, int octaves, int period)
      : scale_(Float(period) / kWide), noise_(seed, octaves, period) {}
  float At(int x, int y) {
    return noise_.At(Float(x) * scale_, Float(y) * scale_);
  }

 private:
  float scale_;
  FractalNoise noise_;
};

// Multiplies with 1 +- strength of noise.
void Age(Canvas& canvas, float strength, int period, int octaves,
         uint64_t seed) {
  SeamlessNoise noise(seed, octaves, period);
  canvas.Paint([&](int x, int y) {
    return (1 + 2 * strength * (noise.At(x, y) - 0.5f)) * canvas.at(x, y);
  });
}

}  // namespace

Canvas PaintPlasterWall(Float3 color, uint64_t seed) {
  Canvas canvas(kWide, kHigh, color);
  Age(canvas, 0.16f, 6, 5, seed);
  Age(canvas, 0.11f, 220, 2, seed + 1);
  base::Random random(seed, 1);
  for (int i = 0; i < 90; ++i) {  // scuffs, cracks and filled holes
    const float x = UniformFloat(random, 40, kWide - 40);
    const float y = UniformFloat(random, 40, kHigh - 40);
    const Float3 tone = UniformFloat(random, 0.55f, 1.12f) * color;
    if (i % 3 == 0) {
      const float turn = UniformFloat(random, 0, 6.28f);
      const float length = UniformFloat(random, 10, 38);
      canvas.Line(x, y, x + length * std::cos(turn),
                  y + length * std::sin(turn), 1.6f, tone, 0.5f);
    } else {
      canvas.Disc(x, y, UniformFloat(random, 1, 8), tone, 0.45f);
    }
  }
  return canvas;
}

Canvas PaintPaperWall(Float3 color, uint64_t seed) {
  constexpr int kStripe = 64;
  base::Random random(seed, 2);
  const Float3 dark = 0.82f * color;
  const Float3 mark =
      Hsv({UniformFloat(random, 0, 1), UniformFloat(random, 0.4f, 0.7f),
           UniformFloat(random, 0.35f, 0.6f)});
  const int arms = 4 + static_cast<int>(random.NextBelow(4));
  const bool has_stripes = random.NextBelow(2) == 0;
  Canvas canvas(kWide, kHigh, color);
  for (int x = 0; has_stripes && x < kWide; x += 2 * kStripe) {
    canvas.Rect(Float(x), 0, Float(x + kStripe), kHigh, dark);
  }
  for (int x = kStripe / 2, column = 0; x < kWide; x += kStripe, ++column) {
    for (int y = column % 2 == 0 ? 32 : 96; y < kHigh; y += 128) {
      for (int i = 0; i < arms; ++i) {
        const float angle = 6.2831853f * Float(i) / Float(arms);
        canvas.Line(Float(x), Float(y), Float(x) + 17 * std::cos(angle),
                    Float(y) + 17 * std::sin(angle), 5, mark, 0.8f);
      }
      canvas.Disc(Float(x), Float(y), 6, color);
    }
  }
  Age(canvas, 0.14f, 7, 5, seed);
  Age(canvas, 0.05f, 512, 1, seed + 1);
  return canvas;
}

Canvas PaintBrickWall(Float3 color, uint64_t seed) {
  constexpr int kColumns = 20;  // of 25 cm
  constexpr int kRows = 32;     // of 7.8 cm
  constexpr float kBrickWide = 2048.0f / kColumns;
  constexpr float kBrickHigh = 1024.0f / kRows;
  constexpr float kMortar = 4;
  Canvas canvas(kWide, kHigh, {0.70f, 0.68f, 0.63f});
  for (int row = 0; row < kRows; ++row) {
    for (int column = -1; column < kColumns; ++column) {
      // The last brick of a row goes on with the first.
      const int brick = (column + kColumns) % kColumns;
      base::Random random(seed, static_cast<uint64_t>(row * 64 + brick));
      const float bright = UniformFloat(random, 0.6f, 1.15f);
      const Float3 tone =
          bright *
          Float3{color.x * UniformFloat(random, 0.9f, 1.1f), color.y, color.z};
      const float shift = row % 2 == 0 ? 0 : kBrickWide / 2;
      const float x = Float(column) * kBrickWide + shift;
      const float y = Float(row) * kBrickHigh;
      canvas.Rect(x, y, x + kBrickWide - kMortar, y + kBrickHigh - kMortar,
                  tone);
      canvas.Rect(x, y + kBrickHigh - kMortar - 2, x + kBrickWide - kMortar,
                  y + kBrickHigh - kMortar, 0.6f * tone, 0.6f);
    }
  }
  Age(canvas, 0.22f, 170, 4, seed + 1);
  Age(canvas, 0.18f, 8, 4, seed + 2);
  return canvas;
}

Canvas PaintConcreteWall(Float3 color, uint64_t seed) {
  Canvas canvas(kWide, kHigh, color);
  Age(canvas, 0.22f, 9, 6, seed);
  Age(canvas, 0.10f, 400, 2, seed + 1);
  base::Random random(seed, 3);
  for (int i = 0; i < 500; ++i) {  // bubbles
    canvas.Disc(UniformFloat(random, 4, kWide - 4),
                UniformFloat(random, 4, kHigh - 4),
                UniformFloat(random, 0.8f, 3.2f), 0.45f * color, 0.7f);
  }
  for (int x = 0; x < kWide; x += kWide / 4) {  // where the boards met
    canvas.Rect(Float(x), 0, Float(x) + 3, kHigh, 0.55f * color, 0.8f);
    for (const float y : {200.0f, 800.0f}) {
      for (const float side : {120.0f, 390.0f}) {
        canvas.Disc(Float(x) + side, y, 9, 0.4f * color, 0.9f);
      }
    }
  }
  canvas.Rect(0, 0, kWide, 3, 0.55f * color, 0.8f);
  return canvas;
}

Canvas PaintBlots(Float3 color, uint64_t seed) {
  Canvas canvas(kWide, kHigh, color);
  base::Random random(seed, 4);
  for (int i = 0; i < 700; ++i) {
    const float radius = 4 + 70 * std::pow(UniformFloat(random, 0, 1), 4.0f);
    canvas.Disc(
        UniformFloat(random, radius, kWide - radius),
        UniformFloat(random, radius, kHigh - radius), radius,
        Hsv({UniformFloat(random, 0, 1), UniformFloat(random, 0.1f, 0.7f),
             UniformFloat(random, 0.2f, 0.95f)}),
        0.8f);
  }
  Age(canvas, 0.15f, 30, 5, seed);
  return canvas;
}

Canvas PaintPlankFloor(Float3 color, uint64_t seed) {
  constexpr int kPlankHigh = 64;  // 16 cm
  constexpr int kPlanks = 3;      // in a row
  constexpr int kPlankLong = kWide / kPlanks;
  Canvas canvas(kWide, kWide);
  SeamlessNoise bend(seed, 3, 8);
  SeamlessNoise fibre(seed + 1, 2, 32);
  canvas.Paint([&](int x, int y) {
    const int row = y / kPlankHigh;
    const int shift = static_cast<int>(CellNoise(row, 0, seed) * kWide);
    const int along = (x + shift) % (kPlankLong * kPlanks);
    const int plank = along / kPlankLong;
    const float tone = 0.72f + 0.5f * CellNoise(row, plank + 1, seed + 1);
    const float rings =
        0.5f + 0.5f * std::sin(0.35f * Float(y % kPlankHigh) +
                               9 * bend.At(x, y * 3 + 300 * plank));
    const float grain = 0.5f * rings + 0.5f * fibre.At(x, y * 24);
    const bool is_gap = y % kPlankHigh < 2 || along % kPlankLong < 3;
    return (is_gap ? 0.4f : 1.0f) * tone * (0.75f + 0.45f * grain) * color;
  });
  Age(canvas, 0.10f, 10, 4, seed + 5);
  return canvas;
}

Canvas PaintTileFloor(Float3 color, uint64_t seed) {
  constexpr int kTile = 128;  // 31 cm
  Canvas canvas(kWide, kWide);
  SeamlessNoise vein(seed, 5, 24);
  base::Random random(seed, 6);
  const float checker = UniformFloat(random, 0, 0.3f);
  canvas.Paint([&](int x, int y) {
    const int column = x / kTile;
    const int row = y / kTile;
    if (x % kTile < 3 || y % kTile < 3) return Float3{0.42f, 0.40f, 0.38f};
    const float own = 0.86f + 0.22f * CellNoise(column, row, seed + 1);
    const float dark = (column + row) % 2 == 0 ? 1.0f : 1.0f - checker;
    const float marble =
        std::abs(2 * vein.At(x + 211 * (column % 5), y + 157 * (row % 7)) - 1);
    return own * dark * (0.8f + 0.35f * std::min(1.0f, 3 * marble)) * color;
  });
  for (int i = 0; i < 60; ++i) {  // stains and chips
    canvas.Disc(UniformFloat(random, 10, kWide - 10),
                UniformFloat(random, 10, kWide - 10),
                UniformFloat(random, 2, 9),
                UniformFloat(random, 0.4f, 0.8f) * color, 0.5f);
  }
  Age(canvas, 0.10f, 8, 4, seed + 2);
  return canvas;
}

Canvas PaintCarpetFloor(Float3 color, uint64_t seed) {
  constexpr int kTile = 256;  // 62 cm
  Canvas canvas(kWide, kWide);
  SeamlessNoise wear(seed, 5, 9);
  const Float3 other = Hsv({CellNoise(1, 2, seed), 0.35f, 0.55f});
  canvas.Paint([&](int x, int y) {
    const int column = x / kTile;
    const int row = y / kTile;
    const float own = 0.8f + 0.3f * CellNoise(column, row, seed + 1);
    const int along = (column + row) % 2 == 0 ? x : y;
    const float pile = 0.88f + 0.24f * CellNoise(x / 3, y / 3, seed + 2);
    const bool is_thread =
        along % 32 < 5 && CellNoise(along / 32, column * 8 + row, seed) > 0.45f;
    return own * pile * (0.7f + 0.6f * wear.At(x, y)) *
           (is_thread ? other : color);
  });
  return canvas;
}

Canvas PaintRubberFloor(Float3 color, uint64_t seed) {
  constexpr int kSize = 512;
  Canvas canvas(kSize, kSize, color);
  for (int y = 32; y < kSize; y += 64) {
    for (int x = (y / 64) % 2 == 0 ? 32 : 64; x < kSize; x += 64) {
      canvas.Disc(Float(x) + 2, Float(y) + 3, 20, 0.55f * color);
      canvas.Disc(Float(x), Float(y), 19,
                  (1.1f + 0.5f * CellNoise(x, y, seed)) * color);
    }
  }
  FractalNoise noise(seed, 5, 8);
  canvas.Paint([&](int x, int y) {
    return (0.7f + 0.6f * noise.At(Float(x) / 64, Float(y) / 64)) *
           canvas.at(x, y);
  });
  return canvas;
}

Canvas PaintClothes(float hue, uint64_t seed) {
  constexpr int kSize = 256;
  base::Random random(seed, 7);
  const Float3 cloth = Hsv({hue, UniformFloat(random, 0.2f, 0.7f),
                            UniformFloat(random, 0.3f, 0.8f)});
  const Float3 stripe =
      Hsv({hue + 0.4f, 0.4f, UniformFloat(random, 0.3f, 0.9f)});
  Canvas canvas(kSize, kSize, cloth);
  const int pitch = 12 + static_cast<int>(random.NextBelow(40));
  for (int y = 0; y < kSize; y += pitch) {
    canvas.Rect(0, Float(y), kSize, Float(y + pitch / 3), stripe, 0.7f);
  }
  FractalNoise folds(seed, 4, 6);
  canvas.Paint([&](int x, int y) {
    return (0.6f +
            0.8f * folds.At(6 * Float(x) / kSize, 1.5f * Float(y) / kSize)) *
           canvas.at(x, y);
  });
  return canvas;
}

}  // namespace treeline::worlds
