#include "simulation/worlds/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeline::worlds {
namespace {

uint32_t Pack(Float3 display) {
  const auto byte = [](float value) {
    return static_cast<uint32_t>(std::clamp(value, 0.0f, 1.0f) * 255 + 0.5f);
  };
  return byte(display.x) | (byte(display.y) << 8) | (byte(display.z) << 16);
}

Float3 Unpack(uint32_t texel) {
  return {static_cast<float>(texel & 255),
          static_cast<float>((texel >> 8) & 255),
          static_cast<float>((texel >> 16) & 255)};
}

// Two texels mixed, `share` 256ths of the second: all channels at once.
uint32_t Blend(uint32_t a, uint32_t b, uint32_t share) {
  constexpr uint32_t kOdd = 0x00ff00ffu;
  const uint32_t red_blue =
      ((a & kOdd) * (256 - share) + (b & kOdd) * share) >> 8;
  const uint32_t green =
      ((a >> 8) & kOdd) * (256 - share) + ((b >> 8) & kOdd) * share;
  return (red_blue & kOdd) | (green & ~kOdd);
}

// The largest whole number not above x, for |x| below 2^31. (std::floor is a
// call into the library without SSE4.1.)
int RoundDown(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

// An approximation of log2 for x >= 1, exact at powers of two and linear in
// between: enough to blend mip levels.
float RoughLog2(float x) {
  const uint32_t bits = std::bit_cast<uint32_t>(x);
  const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float mantissa =
      std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u);
  return exponent + mantissa - 1;
}

}  // namespace

Texture::Texture(const Canvas& canvas) {
  Level base{.width = canvas.width(), .height = canvas.height(), .texels = {}};
  base.texels.reserve(static_cast<size_t>(base.width) *
                      static_cast<size_t>(base.height));
  for (int y = 0; y < base.height; ++y) {
    for (int x = 0; x < base.width; ++x) {
      base.texels.push_back(Pack(canvas.at(x, y)));
    }
  }
  levels_.push_back(std::move(base));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{.width = std::max(fine.width / 2, 1),
                 .height = std::max(fine.height / 2, 1),
                 .texels = {}};
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        Float3 sum;
        for (int i = 0; i < 4; ++i) {
          const int fine_x = std::min(2 * x + i % 2, fine.width - 1);
          const int fine_y = std::min(2 * y + i / 2, fine.height - 1);
          sum = sum + LinearFromDisplay(Unpack(fine.texels[static_cast<size_t>(
                          fine_y * fine.width + fine_x)]));
        }
        sum = (0.25f / (255 * 255)) * sum;
        coarse.texels.push_back(
            Pack({DisplayFromLinear(sum.x), DisplayFromLinear(sum.y),
                  DisplayFromLinear(sum.z)}));
      }
    }
    levels_.push_back(std::move(coarse));
  }
  mean_ = LinearFromDisplay((1.0f / 255) * Unpack(levels_.back().texels[0]));
}

Float3 Texture::SampleLevel(const Level& level, float u, float v) {
  // In 24.8 fixed point: eight bits of position between texels are as fine as
  // the eight bits of the texels.
  const int x = RoundDown(u * static_cast<float>(level.width) * 256) - 128;
  const int y = RoundDown(v * static_cast<float>(level.height) * 256) - 128;
  const uint32_t tx = static_cast<uint32_t>(x) & 255;
  const uint32_t ty = static_cast<uint32_t>(y) & 255;
  const size_t mask_x = static_cast<size_t>(level.width) - 1;
  const size_t mask_y = static_cast<size_t>(level.height) - 1;
  const size_t x0 = static_cast<size_t>(x >> 8) & mask_x;
  const size_t x1 = (x0 + 1) & mask_x;
  const size_t y0 = static_cast<size_t>(y >> 8) & mask_y;
  const size_t y1 = (y0 + 1) & mask_y;
  const uint32_t* row0 =
      level.texels.data() + y0 * static_cast<size_t>(level.width);
  const uint32_t* row1 =
      level.texels.data() + y1 * static_cast<size_t>(level.width);
  const uint32_t texel =
      Blend(Blend(row0[x0], row0[x1], tx), Blend(row1[x0], row1[x1], tx), ty);
  return LinearFromDisplay((1.0f / 255) * Unpack(texel));
}

Float3 Texture::Sample(float u, float v, float footprint) const {
  const float depth = std::min(0.5f * RoughLog2(std::max(footprint, 1.0f)),
                               static_cast<float>(levels_.size() - 1));
  const size_t fine = static_cast<size_t>(depth);
  // Near a level, that one alone: half of the samples need no second.
  const float blend = 2 * (depth - static_cast<float>(fine)) - 0.5f;
  if (blend <= 0) return SampleLevel(levels_[fine], u, v);
  const Float3 coarse = SampleLevel(levels_[fine + 1], u, v);
  if (blend >= 1) return coarse;
  return Mix(SampleLevel(levels_[fine], u, v), coarse, blend);
}

}  // namespace treeline::worlds
