#include "simulation/worlds/paint_materials.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"
#include "simulation/worlds/noise.h"

namespace treeline::worlds {
namespace {

constexpr int kWallWidth = 2048;
constexpr int kWallHeight = 1024;
constexpr float kPi = 3.14159265f;

float Float(int i) { return static_cast<float>(i); }

float UniformFloat(base::Random& random, float low, float high) {
  return static_cast<float>(random.NextUniform(low, high));
}

// Long fibres along x with rings: 0 dark to 1 light.
class WoodGrain {
 public:
  // Repeats after `period` units; 0: never.
  WoodGrain(uint64_t seed, int period)
      : bend_(seed, 3, 2 * period), fibre_(seed + 1, 3, 8 * period) {}

  float At(float x, float y) {
    const float bend = bend_.At(x * 2, y * 2);
    const float rings = 0.5f + 0.5f * std::sin(2 * kPi * (y * 14 + 3 * bend));
    return 0.45f * rings + 0.55f * fibre_.At(x * 8, y * 128);
  }

 private:
  FractalNoise bend_;
  FractalNoise fibre_;
};

// Grain of single pixels.
float Speckle(int x, int y, float strength, uint64_t seed) {
  return 1 + strength * (2 * CellNoise(x, y, seed) - 1);
}

}  // namespace

Float3 Hsv(HsvColor color) {
  const float h = 6 * (color.hue - std::floor(color.hue));
  const auto channel = [&](float offset) {
    const float k = std::fmod(offset + h, 6.0f);
    const float ramp = std::clamp(std::min(k, 4 - k), 0.0f, 1.0f);
    return color.value * (1 - color.saturation * ramp);
  };
  return {channel(5), channel(3), channel(1)};
}

Canvas PaintPlain(Float3 color, float grain, uint64_t seed) {
  Canvas canvas(128, 128);
  FractalNoise noise(seed, 3, 8);
  canvas.Paint([&](int x, int y) {
    const float soft = noise.At(Float(x) / 16, Float(y) / 16);
    return (1 + grain * (soft - 0.5f)) * Speckle(x, y, grain / 2, seed + 1) *
           color;
  });
  return canvas;
}

Canvas PaintPlaster(Float3 color, uint64_t seed) {
  Canvas canvas(kWallWidth, kWallHeight);
  FractalNoise stain_noise(seed, 4);
  FractalNoise roller_noise(seed + 1, 3);
  canvas.Paint([&](int x, int y) {
    const float stains = stain_noise.At(Float(x) / 400, Float(y) / 400);
    const float roller = roller_noise.At(Float(x) / 9, Float(y) / 14);
    return (1 + 0.22f * (stains - 0.5f) + 0.16f * (roller - 0.5f)) *
           Speckle(x, y, 0.02f, seed + 2) * color;
  });
  base::Random random(seed, 1);
  for (int i = 0; i < 40; ++i) {  // scuffs and filled holes
    const float x = UniformFloat(random, 0, kWallWidth);
    const float y = UniformFloat(random, 0, kWallHeight);
    const float radius = UniformFloat(random, 1, 9);
    canvas.Disc(x, y, radius, UniformFloat(random, 0.7f, 1.1f) * color, 0.35f);
  }
  return canvas;
}

Canvas PaintWallpaper(float hue, uint64_t seed) {
  const Float3 light = Hsv({hue, 0.10f, 0.90f});
  const Float3 dark = Hsv({hue + 0.03f, 0.20f, 0.78f});
  const Float3 blossom = Hsv({hue + 0.45f, 0.45f, 0.62f});
  const Float3 leaf = Hsv({0.3f, 0.35f, 0.5f});
  Canvas canvas(kWallWidth, kWallHeight, light);
  constexpr int kStripe = 64;
  for (int x = 0; x < kWallWidth; x += 2 * kStripe) {
    canvas.Rect(Float(x), 0, Float(x + kStripe), kWallHeight, dark);
    canvas.Rect(Float(x) + 4, 0, Float(x) + 7, kWallHeight, light);
    canvas.Rect(Float(x) + kStripe - 7, 0, Float(x) + kStripe - 4, kWallHeight,
                light);
  }
  for (int x = 96, column = 0; x < kWallWidth; x += 2 * kStripe, ++column) {
    for (int y = column % 2 == 0 ? 40 : 104; y < kWallHeight; y += 128) {
      const float cx = Float(x);
      const float cy = Float(y);
      canvas.Line(cx, cy, cx + 6, cy + 44, 3, leaf);
      canvas.Line(cx + 3, cy + 24, cx + 18, cy + 14, 5, leaf);
      for (int i = 0; i < 5; ++i) {
        const float angle = 2 * kPi * Float(i) / 5;
        canvas.Disc(cx + 9 * std::cos(angle), cy + 9 * std::sin(angle), 7,
                    blossom);
      }
      canvas.Disc(cx, cy, 5, light);
    }
  }
  canvas.Weather(0.16f, 300, 5, seed);
  canvas.Weather(0.08f, 4, 2, seed + 1);
  return canvas;
}

Canvas PaintBrick(uint64_t seed) {
  constexpr int kBrickWidth = 98;  // 24 cm
  constexpr int kBrickHeight = 28;
  constexpr float kMortar = 4;
  Canvas canvas(kWallWidth, kWallHeight, {0.72f, 0.69f, 0.64f});
  for (int row = 0; row * kBrickHeight < kWallHeight; ++row) {
    const int shift = row % 2 == 0 ? 0 : kBrickWidth / 2;
    for (int column = -1; column * kBrickWidth < kWallWidth; ++column) {
      base::Random random(seed, static_cast<uint64_t>(row * 4096 + column + 1));
      const Float3 color = Hsv({UniformFloat(random, 0.01f, 0.06f),
                                UniformFloat(random, 0.35f, 0.6f),
                                UniformFloat(random, 0.42f, 0.72f)});
      const float x =
          Float(column * kBrickWidth + shift) + UniformFloat(random, 0, 2);
      const float y = Float(row * kBrickHeight) + UniformFloat(random, 0, 2);
      canvas.Rect(x, y, x + kBrickWidth - kMortar, y + kBrickHeight - kMortar,
                  color);
      canvas.Rect(x + 1, y + kBrickHeight - kMortar - 2,
                  x + kBrickWidth - kMortar, y + kBrickHeight - kMortar,
                  0.7f * color, 0.5f);
    }
  }
  canvas.Weather(0.30f, 12, 4, seed + 1);
  canvas.Weather(0.25f, 260, 4, seed + 2);
  return canvas;
}

Canvas PaintPlanks(uint64_t seed) {
  constexpr int kSize = 2048;
  constexpr int kPlankHeight = 64;
  constexpr int kPlankLength = 700;
  Canvas canvas(kSize, kSize);
  WoodGrain wood(seed, 0);
  canvas.Paint([&](int x, int y) {
    const int row = y / kPlankHeight;
    const int shift = static_cast<int>(CellNoise(row, 0, seed) * kPlankLength);
    const int plank = (x + shift) / kPlankLength;
    const float tone = 0.78f + 0.44f * CellNoise(row, plank + 1, seed + 1);
    const float own = 40 * CellNoise(row, plank, seed + 2);
    const float grain =
        wood.At(Float(x) / 500 + own, Float(y % kPlankHeight) / 500 + own);
    const int gap_y = y % kPlankHeight;
    const int gap_x = (x + shift) % kPlankLength;
    const float gap = gap_y < 2 || gap_x < 2 ? 0.45f : 1.0f;
    const Float3 base =
        Mix({0.46f, 0.30f, 0.17f}, {0.74f, 0.54f, 0.34f}, grain);
    return tone * gap * base;
  });
  return canvas;
}

Canvas PaintWood(Float3 tone, uint64_t seed) {
  constexpr int kSize = 512;
  Canvas canvas(kSize, kSize);
  WoodGrain wood(seed, 1);
  canvas.Paint([&](int x, int y) {
    const float grain = wood.At(Float(x) / kSize, Float(y) / kSize);
    return (0.72f + 0.5f * grain) * Speckle(x, y, 0.04f, seed + 2) * tone;
  });
  return canvas;
}

Canvas PaintFabric(Float3 color, uint64_t seed) {
  constexpr int kSize = 512;
  Canvas canvas(kSize, kSize);
  FractalNoise wear_noise(seed, 4, 4);
  canvas.Paint([&](int x, int y) {
    const float weave = ((x / 4 + y / 4) % 2 == 0) ? 1.0f : 0.86f;
    const float wear = wear_noise.At(Float(x) / 128, Float(y) / 128);
    return (0.75f + 0.5f * wear) * weave *
           Speckle(x / 2, y / 2, 0.18f, seed + 1) * color;
  });
  return canvas;
}

Canvas PaintRug(float hue, uint64_t seed) {
  constexpr int kSize = 1024;
  const Float3 ground = Hsv({hue, 0.65f, 0.45f});
  const Float3 accent = Hsv({hue + 0.55f, 0.40f, 0.75f});
  const Float3 cream = {0.86f, 0.80f, 0.66f};
  Canvas canvas(kSize, kSize, ground);
  canvas.Frame(0, 0, kSize, kSize, 30, cream);
  canvas.Frame(44, 44, kSize - 44, kSize - 44, 60, accent);
  canvas.Frame(118, 118, kSize - 118, kSize - 118, 10, cream);
  base::Random random(seed, 2);
  for (int i = 0; i < 15; ++i) {  // ornaments in the border
    const float at = 74 + 62.5f * Float(i);
    for (const float edge : {74.0f, kSize - 74.0f}) {
      canvas.Disc(at, edge, 17, i % 2 == 0 ? ground : cream);
      canvas.Disc(edge, at, 17, i % 2 == 0 ? cream : ground);
    }
  }
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      const float x = 190 + 129 * Float(column);
      const float y = 190 + 129 * Float(row);
      const float r = UniformFloat(random, 34, 58);
      const Canvas::Point diamond[] = {
          {x, y - r}, {x + r, y}, {x, y + r}, {x - r, y}};
      canvas.Polygon(diamond, random.NextBelow(2) == 0 ? accent : cream);
      canvas.Disc(x, y, 0.45f * r,
                  Hsv({hue + UniformFloat(random, 0, 0.4f), 0.6f, 0.5f}));
    }
  }
  canvas.Weather(0.30f, 5, 2, seed);
  canvas.Weather(0.20f, 200, 4, seed + 1);
  return canvas;
}

Canvas PaintCurtain(float hue, uint64_t seed) {
  constexpr int kWidth = 256;
  constexpr int kHeight = 1024;
  const Float3 color = Hsv({hue, 0.45f, 0.70f});
  const Float3 band = Hsv({hue + 0.08f, 0.30f, 0.85f});
  Canvas canvas(kWidth, kHeight);
  canvas.Paint([&](int x, int y) {
    const float sway = 10 * ValueNoise(Float(y) / 300, 0, seed);
    const float fold = 0.80f + 0.20f * std::sin((Float(x) + sway) / 7);
    const bool in_band = (y / 48) % 3 == 0;
    return fold * Speckle(x, y, 0.06f, seed + 1) * (in_band ? band : color);
  });
  return canvas;
}

Canvas PaintRadiator(uint64_t seed) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 256;
  Canvas canvas(kWidth, kHeight);
  canvas.Paint([&](int x, int y) {
    const float rib = 0.5f + 0.5f * std::sin(2 * kPi * Float(x) / 32);
    return (0.62f + 0.28f * rib) * Speckle(x, y, 0.02f, seed) *
           Float3{1, 0.99f, 0.95f};
  });
  canvas.Rect(0, 0, kWidth, 14, {0.88f, 0.87f, 0.84f});
  canvas.Rect(0, kHeight - 14, kWidth, kHeight, {0.80f, 0.79f, 0.76f});
  return canvas;
}

Canvas PaintLeaf(uint64_t seed) {
  constexpr int kSize = 64;
  const Float3 color =
      Hsv({0.28f + 0.06f * CellNoise(0, 0, seed), 0.65f, 0.45f});
  Canvas canvas(kSize, kSize, color);
  canvas.Line(0, 32, 64, 32, 3, 1.5f * color);
  for (int i = 0; i < 7; ++i) {
    const float x = 4 + 8 * Float(i);
    canvas.Line(x, 32, x + 12, 4, 1.5f, 1.35f * color);
    canvas.Line(x, 32, x + 12, 60, 1.5f, 1.35f * color);
  }
  canvas.Weather(0.25f, 10, 3, seed);
  return canvas;
}

}  // namespace treeline::worlds
