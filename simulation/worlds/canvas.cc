#include "simulation/worlds/canvas.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"
#include "simulation/worlds/noise.h"

namespace treeline::worlds {
namespace {

// 0 outside, 1 inside, a ramp of one pixel at the edge.
float Inside(float signed_distance_px) {
  return std::clamp(signed_distance_px + 0.5f, 0.0f, 1.0f);
}

}  // namespace

Canvas::Canvas(int width, int height, Float3 color)
    : width_(width),
      height_(height),
      pixels_(static_cast<size_t>(width) * static_cast<size_t>(height), color) {
}

template <typename Coverage>
void Canvas::Blend(float x0, float y0, float x1, float y1, Float3 color,
                   float opacity, Coverage coverage) {
  const auto bound = [](float value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0f, static_cast<float>(limit)));
  };
  const int first_x = bound(std::floor(x0) - 1, width_);
  const int first_y = bound(std::floor(y0) - 1, height_);
  const int last_x = bound(std::ceil(x1) + 1, width_);
  const int last_y = bound(std::ceil(y1) + 1, height_);
  for (int y = first_y; y < last_y; ++y) {
    for (int x = first_x; x < last_x; ++x) {
      const float share = opacity * coverage(static_cast<float>(x) + 0.5f,
                                             static_cast<float>(y) + 0.5f);
      if (share <= 0) continue;
      Float3& pixel = pixels_[Index(x, y)];
      pixel = Mix(pixel, color, share);
    }
  }
}

void Canvas::Rect(float x0, float y0, float x1, float y1, Float3 color,
                  float opacity) {
  Blend(x0, y0, x1, y1, color, opacity, [=](float x, float y) {
    return std::min(Inside(x - x0), Inside(x1 - x)) *
           std::min(Inside(y - y0), Inside(y1 - y));
  });
}

void Canvas::Frame(float x0, float y0, float x1, float y1, float line,
                   Float3 color, float opacity) {
  Rect(x0, y0, x1, y0 + line, color, opacity);
  Rect(x0, y1 - line, x1, y1, color, opacity);
  Rect(x0, y0 + line, x0 + line, y1 - line, color, opacity);
  Rect(x1 - line, y0 + line, x1, y1 - line, color, opacity);
}

void Canvas::Disc(float cx, float cy, float radius, Float3 color,
                  float opacity) {
  Blend(cx - radius, cy - radius, cx + radius, cy + radius, color, opacity,
        [=](float x, float y) {
          return Inside(radius - std::hypot(x - cx, y - cy));
        });
}

void Canvas::Line(float x0, float y0, float x1, float y1, float width,
                  Float3 color, float opacity) {
  const float dx = x1 - x0;
  const float dy = y1 - y0;
  const float squared_length = std::max(dx * dx + dy * dy, 1e-6f);
  const float half = width / 2;
  Blend(std::min(x0, x1) - half, std::min(y0, y1) - half,
        std::max(x0, x1) + half, std::max(y0, y1) + half, color, opacity,
        [=](float x, float y) {
          const float t = std::clamp(
              ((x - x0) * dx + (y - y0) * dy) / squared_length, 0.0f, 1.0f);
          return Inside(half - std::hypot(x - x0 - t * dx, y - y0 - t * dy));
        });
}

void Canvas::Polygon(std::span<const Point> corners, Float3 color,
                     float opacity) {
  float x0 = 1e9f;
  float y0 = 1e9f;
  float x1 = -1e9f;
  float y1 = -1e9f;
  for (const Point& corner : corners) {
    x0 = std::min(x0, corner.x);
    y0 = std::min(y0, corner.y);
    x1 = std::max(x1, corner.x);
    y1 = std::max(y1, corner.y);
  }
  Blend(x0, y0, x1, y1, color, opacity, [=](float x, float y) {
    float distance = 1e9f;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Point& a = corners[i];
      const Point& b = corners[(i + 1) % corners.size()];
      const float ex = b.x - a.x;
      const float ey = b.y - a.y;
      const float length = std::max(std::hypot(ex, ey), 1e-6f);
      distance = std::min(distance, (ex * (y - a.y) - ey * (x - a.x)) / length);
    }
    return Inside(distance);
  });
}

void Canvas::Text(float x0, float x1, float y, float glyph_height, Float3 color,
                  uint64_t seed) {
  base::Random random(seed, 0x7e87);
  const float cell = glyph_height / 5;
  float x = x0;
  while (x + 3 * cell <= x1) {
    // A glyph is a 3 x 5 pattern of cells, about every sixth one a space.
    if (random.NextBelow(6) != 0) {
      const uint64_t pattern = random.NextBits() | random.NextBits();
      for (int i = 0; i < 15; ++i) {
        if (((pattern >> i) & 1) == 0) continue;
        const float left = x + static_cast<float>(i % 3) * cell;
        const float top = y + static_cast<float>(i / 3) * cell;
        Rect(left, top, left + cell, top + cell, color);
      }
    }
    x += 4 * cell;
  }
}

void Canvas::Weather(float strength, float scale, int octaves, uint64_t seed) {
  FractalNoise noise(seed, octaves);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const float value = noise.At(static_cast<float>(x) / scale,
                                   static_cast<float>(y) / scale);
      Float3& pixel = pixels_[Index(x, y)];
      pixel = (1 + strength * (2 * value - 1)) * pixel;
    }
  }
}

}  // namespace treeline::worlds
