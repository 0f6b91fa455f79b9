#include "simulation/worlds/paint_prints.h"

#include <array>
#include <cmath>

#include "common/base/random.h"
#include "simulation/worlds/noise.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {
namespace {

constexpr int kPicture = 512;
constexpr float kPi = 3.14159265f;

float Float(int i) { return static_cast<float>(i); }

float UniformFloat(base::Random& random, float low, float high) {
  return static_cast<float>(random.NextUniform(low, high));
}

Float3 RandomColor(base::Random& random) {
  return Hsv({UniformFloat(random, 0, 1), UniformFloat(random, 0.3f, 0.85f),
              UniformFloat(random, 0.35f, 0.95f)});
}

// Sky, sun and ranges of hills, each farther one paler.
Canvas PaintLandscape(base::Random& random, uint64_t seed) {
  Canvas canvas(kPicture, kPicture);
  const float hue = UniformFloat(random, 0, 1);
  const Float3 high = Hsv({hue, 0.5f, 0.75f});
  const Float3 low = Hsv({hue + 0.1f, 0.25f, 0.98f});
  FractalNoise clouds(seed, 5);
  FractalNoise hills(seed + 1, 4);
  canvas.Paint([&](int x, int y) {
    const float cloud = clouds.At(Float(x) / 120, Float(y) / 50);
    return Mix(Mix(high, low, Float(y) / (0.7f * kPicture)), {1, 1, 1},
               std::max(0.0f, 1.6f * cloud - 0.8f));
  });
  const float sun_x = UniformFloat(random, 80, 430);
  const float sun_y = UniformFloat(random, 70, 190);
  canvas.Disc(sun_x, sun_y, UniformFloat(random, 24, 60), {1, 0.93f, 0.7f});
  for (int range = 0; range < 5; ++range) {
    const float nearness = Float(range + 1) / 5;
    const Float3 color = Mix(low, Hsv({hue + 0.3f, 0.6f, 0.25f}), nearness);
    const float base = 200 + 65 * Float(range);
    for (int x = 0; x < kPicture; ++x) {
      const float ridge =
          base - 130 * hills.At(Float(x) / 110, Float(range) * 9);
      canvas.Rect(Float(x), ridge, Float(x + 1), kPicture, color);
    }
  }
  canvas.Weather(0.15f, 20, 3, seed + 2);
  return canvas;
}

// Discs, bars and triangles on a plain ground.
Canvas PaintAbstract(base::Random& random, uint64_t seed) {
  Canvas canvas(kPicture, kPicture,
                Hsv({UniformFloat(random, 0, 1), 0.12f, 0.9f}));
  for (int i = 0; i < 26; ++i) {
    const Float3 color = RandomColor(random);
    const float x = UniformFloat(random, 0, kPicture);
    const float y = UniformFloat(random, 0, kPicture);
    const float r = UniformFloat(random, 15, 95);
    switch (random.NextBelow(4)) {
      case 0:
        canvas.Disc(x, y, r, color, 0.9f);
        canvas.Disc(x, y, 0.6f * r, RandomColor(random));
        break;
      case 1:
        canvas.Rect(x, y, x + 1.6f * r, y + 0.6f * r, color, 0.9f);
        break;
      case 2: {
        const Canvas::Point corners[] = {
            {x, y - r}, {x + r, y + 0.7f * r}, {x - r, y + 0.5f * r}};
        canvas.Polygon(corners, color, 0.9f);
        break;
      }
      default: {
        const float end_x = x + UniformFloat(random, -250, 250);
        const float end_y = y + UniformFloat(random, -250, 250);
        canvas.Line(x, y, end_x, end_y, UniformFloat(random, 3, 14), color);
      }
    }
  }
  canvas.Weather(0.12f, 6, 2, seed);
  return canvas;
}

// A title, a picture and columns of print.
Canvas PaintPoster(base::Random& random, uint64_t seed) {
  const Float3 ground = Hsv({UniformFloat(random, 0, 1), 0.7f, 0.5f});
  const Float3 ink = {0.95f, 0.92f, 0.82f};
  Canvas canvas(kPicture, kPicture, ground);
  canvas.Text(30, 490, 26, 62, ink, seed);
  canvas.Text(30, 490, 100, 30, Hsv({UniformFloat(random, 0, 1), 0.5f, 0.95f}),
              seed + 1);
  canvas.Rect(30, 146, 482, 360, 0.6f * ground);
  for (int i = 0; i < 14; ++i) {
    const float x = UniformFloat(random, 60, 450);
    const float y = UniformFloat(random, 205, 300);
    const float r = UniformFloat(random, 10, 60);
    canvas.Disc(x, y, r, RandomColor(random), 0.8f);
  }
  canvas.Frame(30, 146, 482, 360, 5, ink);
  for (int line = 0; line < 9; ++line) {
    const float y = 376 + 14 * Float(line);
    canvas.Text(30, 246, y, 9, ink, seed + 10 + static_cast<uint64_t>(line));
    canvas.Text(266, 482, y, 9, ink, seed + 40 + static_cast<uint64_t>(line));
  }
  canvas.Weather(0.08f, 60, 4, seed);
  return canvas;
}

// A town plan: blocks, roads, a river and names.
Canvas PaintPlan(base::Random& random, uint64_t seed) {
  Canvas canvas(kPicture, kPicture, {0.90f, 0.88f, 0.82f});
  for (int row = 0; row < 11; ++row) {
    for (int column = 0; column < 11; ++column) {
      const float x = 48 * Float(column) + UniformFloat(random, 0, 9);
      const float y = 48 * Float(row) + UniformFloat(random, 0, 9);
      const Float3 color =
          random.NextBelow(5) == 0
              ? Hsv({0.3f, 0.4f, 0.75f})
              : Hsv({0.08f, UniformFloat(random, 0.1f, 0.5f), 0.8f});
      const float width = UniformFloat(random, 24, 40);
      canvas.Rect(x, y, x + width, y + UniformFloat(random, 24, 40), color);
    }
  }
  float x = UniformFloat(random, 100, 400);
  float y = 0;
  while (y < kPicture) {
    const float next_x = x + UniformFloat(random, -45, 45);
    canvas.Line(x, y, next_x, y + 32, 26, {0.45f, 0.62f, 0.82f});
    x = next_x;
    y += 32;
  }
  for (int i = 0; i < 5; ++i) {
    const float top = UniformFloat(random, 0, kPicture);
    const float bottom = UniformFloat(random, 0, kPicture);
    canvas.Line(top, 0, bottom, kPicture, 7, {0.85f, 0.45f, 0.25f});
    const float left = UniformFloat(random, 0, kPicture);
    const float right = UniformFloat(random, 0, kPicture);
    canvas.Line(0, left, kPicture, right, 5, {0.95f, 0.85f, 0.4f});
  }
  for (uint64_t i = 0; i < 22; ++i) {
    const float left = UniformFloat(random, 0, 430);
    canvas.Text(left, left + 80, UniformFloat(random, 5, 500), 10,
                {0.15f, 0.15f, 0.2f}, seed + i);
  }
  canvas.Frame(0, 0, kPicture, kPicture, 14, {0.97f, 0.96f, 0.93f});
  return canvas;
}

// Folded cloth or marbled paint: bands of warped noise.
Canvas PaintMarbled(base::Random& random, uint64_t seed) {
  std::array<Float3, 5> palette;
  for (Float3& color : palette) color = RandomColor(random);
  Canvas canvas(kPicture, kPicture);
  FractalNoise warp_noise(seed, 4);
  FractalNoise band_noise(seed + 1, 4);
  canvas.Paint([&](int x, int y) {
    const float u = Float(x) / 100;
    const float v = Float(y) / 100;
    const float warp = 3 * warp_noise.At(u, v);
    const float value = 10 * band_noise.At(u + warp, v - warp);
    const size_t band = static_cast<size_t>(value);
    return Mix(palette[band % 5], palette[(band + 1) % 5],
               value - std::floor(value));
  });
  return canvas;
}

// Tiles of one size in many colours.
Canvas PaintMosaic(base::Random& random, uint64_t seed) {
  const float hue = UniformFloat(random, 0, 1);
  Canvas canvas(kPicture, kPicture, {0.2f, 0.2f, 0.2f});
  for (int row = 0; row < 16; ++row) {
    for (int column = 0; column < 16; ++column) {
      const float place = std::hypot(Float(row) - 7.5f, Float(column) - 7.5f);
      const Float3 color =
          Hsv({hue + 0.05f * place + 0.15f * CellNoise(row, column, seed), 0.6f,
               0.4f + 0.5f * CellNoise(row, column, seed + 1)});
      const float x = 32 * Float(column);
      const float y = 32 * Float(row);
      canvas.Rect(x + 2, y + 2, x + 30, y + 30, color);
    }
  }
  return canvas;
}

}  // namespace

Canvas PaintPicture(int kind, uint64_t seed) {
  base::Random random(seed, 3);
  switch (kind % 6) {
    case 0:
      return PaintLandscape(random, seed);
    case 1:
      return PaintAbstract(random, seed);
    case 2:
      return PaintPoster(random, seed);
    case 3:
      return PaintPlan(random, seed);
    case 4:
      return PaintMarbled(random, seed);
    default:
      return PaintMosaic(random, seed);
  }
}

Canvas PaintWindowView(uint64_t seed) {
  constexpr int kSize = 1024;
  base::Random random(seed, 4);
  Canvas canvas(kSize, kSize);
  FractalNoise clouds(seed, 6);
  canvas.Paint([&](int x, int y) {
    const float cloud = clouds.At(Float(x) / 250, Float(y) / 110);
    const Float3 sky = Mix({0.52f, 0.70f, 0.92f}, {0.86f, 0.92f, 0.97f},
                           Float(y) / (0.6f * kSize));
    return Mix(sky, {1, 1, 1}, std::clamp(3 * cloud - 1.4f, 0.0f, 1.0f));
  });
  for (int i = 0; i < 9; ++i) {  // houses across the road
    const float x = UniformFloat(random, -60, kSize);
    const float width = UniformFloat(random, 90, 210);
    const float top = UniformFloat(random, 430, 640);
    const Float3 wall = Hsv({UniformFloat(random, 0.02f, 0.15f), 0.3f,
                             UniformFloat(random, 0.55f, 0.85f)});
    canvas.Rect(x, top, x + width, kSize, wall);
    const Canvas::Point roof[] = {
        {x - 8, top}, {x + width / 2, top - 60}, {x + width + 8, top}};
    canvas.Polygon(roof, Hsv({0.02f, 0.5f, 0.45f}));
    for (float wy = top + 25; wy < 760; wy += 60) {
      for (float wx = x + 16; wx + 22 < x + width; wx += 42) {
        canvas.Rect(wx, wy, wx + 22, wy + 32, {0.25f, 0.3f, 0.38f});
      }
    }
  }
  for (int i = 0; i < 260; ++i) {  // leaves of a hedge and two trees
    const bool in_hedge = i % 2 == 0;
    const float tree_x = i % 4 == 1 ? 210.0f : 800.0f;
    const float angle = UniformFloat(random, 0, 2 * kPi);
    const float away = UniformFloat(random, 0, 120);
    const float x = in_hedge ? UniformFloat(random, 0, kSize)
                             : tree_x + away * std::cos(angle);
    const float y = in_hedge ? UniformFloat(random, 800, 1010)
                             : 520 + away * std::sin(angle);
    const float radius = UniformFloat(random, 14, 46);
    canvas.Disc(x, y, radius,
                Hsv({UniformFloat(random, 0.22f, 0.36f), 0.55f,
                     UniformFloat(random, 0.25f, 0.6f)}));
  }
  return canvas;
}

}  // namespace treeline::worlds
