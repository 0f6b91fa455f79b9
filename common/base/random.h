// Counter-based random numbers: a draw is a function of (seed, stream, index)
// and of nothing else, so results never depend on threads or on order.
#ifndef COMMON_BASE_RANDOM_H_
#define COMMON_BASE_RANDOM_H_

#include <cmath>
#include <cstdint>

namespace treeline::base {

// SplitMix64's finaliser (Steele, Lea, Flood 2014): a bijection whose output
// bits each depend on every input bit.
constexpr uint64_t MixBits(uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9u;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// One random stream. Streams with different (seed, stream) are independent.
// Cheap to make: make one per tree, node, query or hypothesis.
class Random {
 public:
  constexpr Random(uint64_t seed, uint64_t stream)
      : state_(MixBits(seed + 0x9e3779b97f4a7c15u) ^
               MixBits(stream + 0xd1b54a32d192ed03u)) {}

  constexpr uint64_t NextBits() {
    state_ += 0x9e3779b97f4a7c15u;
    return MixBits(state_);
  }

  // Uniform in [0, bound), bound > 0 (Lemire's multiply-shift; the bias is
  // below bound / 2^32).
  constexpr uint32_t NextBelow(uint32_t bound) {
    return static_cast<uint32_t>(((NextBits() >> 32) * bound) >> 32);
  }

  // Uniform in [0, 1).
  constexpr double NextUnit() {
    return static_cast<double>(NextBits() >> 11) * 0x1.0p-53;
  }

  constexpr double NextUniform(double low, double high) {
    return low + (high - low) * NextUnit();
  }

  // Standard normal (Box-Muller, one of the pair).
  double NextGaussian() {
    const double u = 1.0 - NextUnit();
    const double v = NextUnit();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586477 * v);
  }

 private:
  uint64_t state_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_RANDOM_H_
