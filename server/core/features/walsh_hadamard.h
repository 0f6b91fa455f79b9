// Walsh-Hadamard descriptors of image patches (thesis 4.2.1; Hel-Or and
// Hel-Or, "Real-time pattern matching using projection kernels", 2005).
#ifndef SERVER_CORE_FEATURES_WALSH_HADAMARD_H_
#define SERVER_CORE_FEATURES_WALSH_HADAMARD_H_

#include <array>
#include <cstdint>
#include <span>

#include "server/core/features/planar_image.h"

namespace treeline::features {

// Patches of 64 x 64 pixels: x - 32 .. x + 31, likewise in y.
inline constexpr int kPatchRadius_px = 32;
inline constexpr int kWhtCoefficientsPerChannel = 20;

// Twenty projections of each of red, green and blue. Projection k of a
// channel is
//   round(sum over the patch of W_k(x, y) * I(x, y) / 4096)
// clamped to [-127, 127], with W_k = w_i(x) * w_j(y) a product of Walsh
// functions (+1 or -1) of i and j sign changes. The kernels stand in order of
// i + j, then j (see kWhtOrder); kernel 0, the mean brightness, is stored
// less 128. All kernels used have i, j < 8 and so are constant on 8 x 8-pixel
// blocks.
//
// A cache line: bytes 60..63 are zero.
struct alignas(64) WhtDescriptor {
  std::array<int8_t, 64> values{};
};

// (i, j) of kernel k: sign changes along x and along y.
struct WhtKernel {
  uint8_t i;
  uint8_t j;
};
extern const std::array<WhtKernel, kWhtCoefficientsPerChannel> kWhtOrder;

// Whether the whole patch at (x, y) lies inside the image.
inline bool PatchInside(int x, int y, int width, int height) {
  return x >= kPatchRadius_px && y >= kPatchRadius_px &&
         x + kPatchRadius_px <= width && y + kPatchRadius_px <= height;
}

// Descriptors at (x[i], y[i]) for all i; every patch must lie inside.
// x, y and descriptors have the same size.
void ComputeWht(const PlanarImage& image, std::span<const int32_t> x,
                std::span<const int32_t> y,
                std::span<WhtDescriptor> descriptors);

// Squared Euclidean distance.
int32_t SquaredDistance(const WhtDescriptor& a, const WhtDescriptor& b);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_WALSH_HADAMARD_H_
