// SIFT descriptors in a byte a dimension.
#ifndef SERVER_CORE_FEATURES_SIFT_DESCRIPTOR_H_
#define SERVER_CORE_FEATURES_SIFT_DESCRIPTOR_H_

#include <array>
#include <cstdint>

namespace treeline::features {

// Two cache lines.
struct alignas(64) SiftDescriptor {
  static constexpr int kDimensions = 128;
  // RootSIFT: the root of a value's share in the histogram, times this.
  static constexpr float kScale = 512;
  std::array<uint8_t, kDimensions> values{};
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SIFT_DESCRIPTOR_H_
