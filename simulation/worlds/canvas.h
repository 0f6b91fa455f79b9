// A picture to paint on: what the surfaces of a synthetic world show.
#ifndef SIMULATION_WORLDS_CANVAS_H_
#define SIMULATION_WORLDS_CANVAS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "simulation/worlds/float3.h"

namespace treeline::worlds {

// Colours are red, green and blue as displayed (gamma-encoded), in [0, 1].
// Positions are in pixels from the top left corner of the picture; edges are
// smoothed over one pixel. What lies outside is cut off.
class Canvas {
 public:
  Canvas(int width, int height, Float3 color = {1, 1, 1});

  int width() const { return width_; }
  int height() const { return height_; }
  Float3 at(int x, int y) const { return pixels_[Index(x, y)]; }

  // Sets every pixel (x, y) to color_of(x, y).
  template <typename ColorOf>
  void Paint(ColorOf color_of) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        pixels_[Index(x, y)] = color_of(x, y);
      }
    }
  }

  // Covers the rectangle from (x0, y0) to (x1, y1).
  void Rect(float x0, float y0, float x1, float y1, Float3 color,
            float opacity = 1);
  // The outline of a rectangle, `line` pixels wide, inside it.
  void Frame(float x0, float y0, float x1, float y1, float line, Float3 color,
             float opacity = 1);
  void Disc(float x, float y, float radius, Float3 color, float opacity = 1);
  // A straight line with round ends.
  void Line(float x0, float y0, float x1, float y1, float width, Float3 color,
            float opacity = 1);
  struct Point {
    float x = 0;
    float y = 0;
  };
  // A convex polygon, corners in clockwise order as seen in the picture.
  void Polygon(std::span<const Point> corners, Float3 color, float opacity = 1);

  // What looks like a line of print from a distance: words of random glyphs
  // of `glyph_height` from x0 to at most x1, on the line whose top is y.
  void Text(float x0, float x1, float y, float glyph_height, Float3 color,
            uint64_t seed);

  // Multiplies with noise: 1 +- strength, `scale` pixels to a unit of noise.
  void Weather(float strength, float scale, int octaves, uint64_t seed);

 private:
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) +
           static_cast<size_t>(x);
  }
  // Blends `color` over the pixels of a box, where coverage(x, y) at the
  // pixel's centre says how much of it.
  template <typename Coverage>
  void Blend(float x0, float y0, float x1, float y1, Float3 color,
             float opacity, Coverage coverage);

  int width_;
  int height_;
  std::vector<Float3> pixels_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_CANVAS_H_
