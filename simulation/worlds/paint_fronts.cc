#include "simulation/worlds/paint_fronts.h"

#include <cmath>

#include "common/base/random.h"
#include "simulation/worlds/noise.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {
namespace {

constexpr float kPi = 3.14159265f;

float Float(int i) { return static_cast<float>(i); }

float UniformFloat(base::Random& random, float low, float high) {
  return static_cast<float>(random.NextUniform(low, high));
}

// A panel that looks sunk into its surroundings: lit from above.
void SunkPanel(Canvas& canvas, float x0, float y0, float x1, float y1,
               float bevel) {
  canvas.Rect(x0, y0, x1, y0 + bevel, {0, 0, 0}, 0.45f);
  canvas.Rect(x0, y0, x0 + bevel, y1, {0, 0, 0}, 0.30f);
  canvas.Rect(x0, y1 - bevel, x1, y1, {1, 1, 1}, 0.35f);
  canvas.Rect(x1 - bevel, y0, x1, y1, {1, 1, 1}, 0.20f);
}

}  // namespace

Canvas PaintBookSpines(uint64_t seed) {
  constexpr int kWidth = 64;
  constexpr int kHeight = 256;
  Canvas canvas(kSpineColumns * kWidth, kSpineRows * kHeight);
  for (int i = 0; i < kSpineColumns * kSpineRows; ++i) {
    base::Random random(seed, static_cast<uint64_t>(i) + 100);
    const float x = Float(i % kSpineColumns * kWidth);
    const float y = Float(i / kSpineColumns * kHeight);
    // Half of the covers are red to yellow, as on most shelves.
    const bool warm = random.NextBelow(2) == 0;
    const float hue =
        warm ? UniformFloat(random, -0.05f, 0.13f) : UniformFloat(random, 0, 1);
    const Float3 cover = Hsv({hue, UniformFloat(random, 0.05f, 0.85f),
                              UniformFloat(random, 0.15f, 0.95f)});
    const bool dark = cover.x + cover.y + cover.z < 1.5f;
    const Float3 ink =
        dark ? Float3{0.93f, 0.88f, 0.70f} : Float3{0.12f, 0.10f, 0.12f};
    canvas.Rect(x, y, x + kWidth, y + kHeight, cover);
    canvas.Rect(x, y, x + 5, y + kHeight, {0, 0, 0}, 0.35f);
    canvas.Rect(x + kWidth - 5, y, x + kWidth, y + kHeight, {0, 0, 0}, 0.25f);
    const float band = UniformFloat(random, 16, 60);
    const Float3 label = Hsv({UniformFloat(random, 0, 1), 0.5f, 0.8f});
    canvas.Rect(x, y + band, x + kWidth, y + band + UniformFloat(random, 4, 40),
                label);
    canvas.Rect(x, y + 226, x + kWidth, y + 231, ink);
    // The title runs down the spine: a column of cells for each glyph.
    for (int glyph = 0; glyph < 14; ++glyph) {
      const uint64_t pattern = random.NextBits() | random.NextBits();
      if (random.NextBelow(6) == 0) continue;
      for (int cell = 0; cell < 15; ++cell) {
        if (((pattern >> cell) & 1) == 0) continue;
        const float left = x + 20 + 5 * Float(cell / 3);
        const float top = y + 106 + 8 * Float(glyph) + 2 * Float(cell % 3);
        canvas.Rect(left, top, left + 5, top + 2, ink);
      }
    }
  }
  canvas.Weather(0.12f, 30, 4, seed);
  return canvas;
}

Canvas PaintCardboard(uint64_t seed) {
  constexpr int kSize = 256;
  base::Random random(seed, 5);
  Canvas canvas(kSize, kSize);
  FractalNoise grain_noise(seed, 4);
  canvas.Paint([&](int x, int y) {
    const float fluting = 1 + 0.03f * std::sin(Float(y) * 1.3f);
    const float grain = grain_noise.At(Float(x) / 40, Float(y) / 12);
    return fluting * (0.85f + 0.3f * grain) * Float3{0.68f, 0.51f, 0.34f};
  });
  canvas.Rect(0, 112, kSize, 140, {0.80f, 0.70f, 0.50f}, 0.8f);
  const float x = UniformFloat(random, 15, 110);
  const float y = random.NextBelow(2) == 0 ? 20.0f : 155.0f;
  canvas.Rect(x, y, x + 110, y + 78, {0.95f, 0.94f, 0.90f});
  for (int line = 0; line < 4; ++line) {
    canvas.Text(x + 8, x + 102, y + 8 + 13 * Float(line), 8, {0.1f, 0.1f, 0.1f},
                seed + static_cast<uint64_t>(line));
  }
  for (float bar = x + 8; bar < x + 95; bar += UniformFloat(random, 3, 7)) {
    canvas.Rect(bar, y + 60, bar + UniformFloat(random, 1, 3), y + 74,
                {0.1f, 0.1f, 0.1f});
  }
  canvas.Text(20, 236, y < 100 ? 180.0f : 50.0f, 26,
              Hsv({UniformFloat(random, 0, 1), 0.7f, 0.4f}), seed + 9);
  return canvas;
}

Canvas PaintDoor(Float3 color, uint64_t seed) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 1024;
  Canvas canvas(kWidth, kHeight, color);
  canvas.Weather(0.12f, 90, 5, seed);
  for (int column = 0; column < 2; ++column) {
    const float x = 60 + 206 * Float(column);
    SunkPanel(canvas, x, 60, x + 186, 330, 9);
    SunkPanel(canvas, x, 390, x + 186, 700, 9);
    SunkPanel(canvas, x, 760, x + 186, 960, 9);
  }
  canvas.Weather(0.06f, 5, 2, seed + 1);
  return canvas;
}

Canvas PaintCupboard(Float3 tone, int columns, int rows, uint64_t seed) {
  constexpr int kSize = 512;
  Canvas canvas = PaintWood(tone, seed);
  const float width = Float(kSize) / Float(columns);
  const float height = Float(kSize) / Float(rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const float x = width * Float(column);
      const float y = height * Float(row);
      const float shade = CellNoise(row, column, seed);
      canvas.Rect(x, y, x + width, y + height, {0, 0, 0}, 0.15f * shade);
      canvas.Frame(x, y, x + width, y + height, 2.5f, {0.05f, 0.04f, 0.03f},
                   0.8f);
      SunkPanel(canvas, x + 0.12f * width, y + 0.12f * height,
                x + 0.88f * width, y + 0.88f * height, 4);
    }
  }
  return canvas;
}

Canvas PaintScreen(uint64_t seed) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 256;
  base::Random random(seed, 6);
  Canvas canvas(kWidth, kHeight, {0.10f, 0.20f, 0.32f});
  canvas.Rect(0, 238, kWidth, kHeight, {0.75f, 0.76f, 0.78f});
  for (int i = 0; i < 3; ++i) {
    const float x = 20 + 160 * Float(i);
    const float y = UniformFloat(random, 10, 50);
    canvas.Rect(x, y, x + 145, y + 170, {0.93f, 0.94f, 0.95f});
    canvas.Rect(x, y, x + 145, y + 14,
                Hsv({UniformFloat(random, 0, 1), 0.6f, 0.6f}));
    for (int line = 0; line < 16; ++line) {
      const float indent = 6 * Float(static_cast<int>(random.NextBelow(4)));
      const float end = x + UniformFloat(random, 60, 140);
      canvas.Text(x + 8 + indent, end, y + 20 + 9 * Float(line), 6,
                  Hsv({UniformFloat(random, 0, 1), 0.7f, 0.45f}),
                  seed + static_cast<uint64_t>(100 * i + line));
    }
  }
  return canvas;
}

Canvas PaintKeyboard(uint64_t seed) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 128;
  Canvas canvas(kWidth, kHeight, {0.16f, 0.16f, 0.17f});
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 18; ++column) {
      const float x = 6 + 28 * Float(column);
      const float y = 5 + 24 * Float(row);
      canvas.Rect(x, y, x + 24, y + 20, {0.32f, 0.32f, 0.34f});
      canvas.Text(x + 6, x + 18, y + 5, 10, {0.85f, 0.85f, 0.85f},
                  seed + static_cast<uint64_t>(row * 18 + column));
    }
  }
  return canvas;
}

Canvas PaintPage(uint64_t seed) {
  constexpr int kSize = 256;
  base::Random random(seed, 7);
  Canvas canvas(kSize, kSize, {0.95f, 0.95f, 0.92f});
  canvas.Text(24, 230, 18, 16, {0.1f, 0.1f, 0.15f}, seed);
  for (int line = 0; line < 17; ++line) {
    const float end = random.NextBelow(5) == 0 ? 140.0f : 232.0f;
    canvas.Text(24, end, 46 + 11.5f * Float(line), 7, {0.25f, 0.25f, 0.25f},
                seed + 1 + static_cast<uint64_t>(line));
  }
  if (random.NextBelow(2) == 0) {
    canvas.Rect(60, 120, 200, 190,
                Hsv({UniformFloat(random, 0, 1), 0.4f, 0.7f}));
  }
  return canvas;
}

Canvas PaintCushion(float hue, uint64_t seed) {
  constexpr int kSize = 256;
  base::Random random(seed, 8);
  const Float3 ground = Hsv({hue, 0.55f, 0.75f});
  const Float3 accent = Hsv({hue + 0.4f, 0.5f, 0.55f});
  Canvas canvas(kSize, kSize, ground);
  const bool rings = random.NextBelow(2) == 0;
  for (int i = 8; i > 0; --i) {
    const float size = 20 * Float(i);
    const Float3 color = i % 2 == 0 ? accent : ground;
    if (rings) {
      canvas.Disc(128, 128, size, color);
    } else {
      const Canvas::Point diamond[] = {{128, 128 - size},
                                       {128 + size, 128},
                                       {128, 128 + size},
                                       {128 - size, 128}};
      canvas.Polygon(diamond, color);
    }
  }
  canvas.Weather(0.25f, 5, 2, seed);
  return canvas;
}

Canvas PaintMagazine(uint64_t seed) {
  constexpr int kSize = 256;
  base::Random random(seed, 9);
  const float hue = UniformFloat(random, 0, 1);
  Canvas canvas(kSize, kSize);
  FractalNoise noise(seed, 4);
  canvas.Paint([&](int x, int y) {
    const float n = noise.At(Float(x) / 60, Float(y) / 60);
    return Hsv({hue + 0.5f * n, 0.5f, 0.35f + 0.6f * n});
  });
  canvas.Text(14, 250, 14, 48, {1, 0.95f, 0.85f}, seed);
  for (int line = 0; line < 5; ++line) {
    canvas.Text(14, UniformFloat(random, 100, 240), 130 + 23 * Float(line), 14,
                {1, 1, 1}, seed + 1 + static_cast<uint64_t>(line));
  }
  return canvas;
}

Canvas PaintClock(uint64_t seed) {
  constexpr int kSize = 256;
  base::Random random(seed, 10);
  Canvas canvas(kSize, kSize, {0.20f, 0.13f, 0.09f});
  canvas.Disc(128, 128, 118, {0.95f, 0.94f, 0.88f});
  const auto hand = [&](float turn, float from, float to, float width) {
    const float dx = std::sin(2 * kPi * turn);
    const float dy = -std::cos(2 * kPi * turn);
    canvas.Line(128 + from * dx, 128 + from * dy, 128 + to * dx, 128 + to * dy,
                width, {0.08f, 0.08f, 0.08f});
  };
  for (int hour = 0; hour < 12; ++hour) {
    hand(Float(hour) / 12, 92, 110, hour % 3 == 0 ? 10.0f : 5.0f);
  }
  const float hour = UniformFloat(random, 0, 1);
  hand(hour, -12, 58, 10);
  hand(12 * hour, -12, 84, 7);
  canvas.Disc(128, 128, 10, {0.6f, 0.1f, 0.1f});
  return canvas;
}

}  // namespace treeline::worlds
