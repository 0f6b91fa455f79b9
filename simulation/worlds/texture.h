// Pictures on surfaces, filtered to the size of the pixel that sees them.
#ifndef SIMULATION_WORLDS_TEXTURE_H_
#define SIMULATION_WORLDS_TEXTURE_H_

#include <cstdint>
#include <vector>

#include "simulation/worlds/canvas.h"
#include "simulation/worlds/float3.h"

namespace treeline::worlds {

// Colour encoding with a gamma of 2 in place of sRGB's 2.2: a product and a
// square root instead of powers.
constexpr Float3 LinearFromDisplay(Float3 c) { return c * c; }
inline float DisplayFromLinear(float linear) { return std::sqrt(linear); }

// A repeating, mip-mapped picture. Immutable.
class Texture {
 public:
  // Width and height of the canvas must be powers of two.
  explicit Texture(const Canvas& canvas);

  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }

  // The reflectance (linear) at (u, v), where the picture fills [0, 1] x
  // [0, 1] with v downwards and repeats beyond, averaged over an area of
  // about `footprint` texels (trilinear).
  Float3 Sample(float u, float v, float footprint) const;

  // The mean reflectance (linear).
  Float3 Mean() const { return mean_; }

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<uint32_t> texels;  // red in the lowest byte
  };
  static Float3 SampleLevel(const Level& level, float u, float v);

  std::vector<Level> levels_;
  Float3 mean_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_TEXTURE_H_
