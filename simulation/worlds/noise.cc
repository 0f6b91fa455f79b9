#include "simulation/worlds/noise.h"

#include "common/base/random.h"

namespace treeline::worlds {
namespace {

int Wrap(int i, int period) {
  if (period <= 0) return i;
  const int rest = i % period;
  return rest < 0 ? rest + period : rest;
}

// A polynomial step with continuous second derivative (Perlin 2002).
float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

uint64_t KeyOf(uint64_t seed) {
  return base::MixBits(seed + 0x9e3779b97f4a7c15u);
}

float KeyedNoise(int x, int y, uint64_t key) {
  const uint64_t cell =
      (static_cast<uint64_t>(static_cast<uint32_t>(x)) << 32) |
      static_cast<uint32_t>(y);
  return static_cast<float>(base::MixBits(cell ^ key) >> 40) * 0x1.0p-24f;
}

// std::floor without a call into the library.
int RoundDown(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

// The noise on the line of whole x between its random values at whole y.
float EdgeNoise(int x, float y, uint64_t seed, int period) {
  const uint64_t key = KeyOf(seed);
  const int cell_y = RoundDown(y);
  const float t = Fade(y - static_cast<float>(cell_y));
  const int wrapped_x = Wrap(x, period);
  return (1 - t) * KeyedNoise(wrapped_x, Wrap(cell_y, period), key) +
         t * KeyedNoise(wrapped_x, Wrap(cell_y + 1, period), key);
}

}  // namespace

float CellNoise(int x, int y, uint64_t seed) {
  return KeyedNoise(x, y, KeyOf(seed));
}

float ValueNoise(float x, float y, uint64_t seed, int period) {
  const int cell_x = RoundDown(x);
  const float t = Fade(x - static_cast<float>(cell_x));
  return (1 - t) * EdgeNoise(cell_x, y, seed, period) +
         t * EdgeNoise(cell_x + 1, y, seed, period);
}

FractalNoise::FractalNoise(uint64_t seed, int octaves, int period) {
  float total = 0;
  float amplitude = 1;
  for (int i = 0; i < octaves; ++i) {
    octaves_.push_back({.seed = seed + static_cast<uint64_t>(i) * 7919,
                        .period = period << i,
                        .amplitude = amplitude});
    total += amplitude;
    amplitude /= 2;
  }
  for (Octave& octave : octaves_) octave.amplitude /= total;
}

float FractalNoise::At(float x, float y) {
  float sum = 0;
  for (Octave& octave : octaves_) {
    const int cell_x = RoundDown(x);
    if (!octave.is_known || octave.y != y || octave.cell_x != cell_x) {
      const bool is_next =
          octave.is_known && octave.y == y && octave.cell_x + 1 == cell_x;
      octave.left = is_next ? octave.right
                            : EdgeNoise(cell_x, y, octave.seed, octave.period);
      octave.right = EdgeNoise(cell_x + 1, y, octave.seed, octave.period);
      octave.y = y;
      octave.cell_x = cell_x;
      octave.is_known = true;
    }
    const float t = Fade(x - static_cast<float>(cell_x));
    sum += octave.amplitude * ((1 - t) * octave.left + t * octave.right);
    x *= 2;
    y *= 2;
  }
  return sum;
}

}  // namespace treeline::worlds
