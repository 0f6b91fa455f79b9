#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/walsh_hadamard.cc"
#include "server/core/features/walsh_hadamard.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// sums[8 * row + column] of the 8 x 8-pixel blocks of the 64 x 64 patch whose
// top left pixel is at `patch`. Eight adjacent bytes are added by one SAD
// instruction, so a patch costs 64 loads of 64 bytes.
void SumBlocks(const uint8_t* patch, size_t stride, uint64_t* sums) {
#if HWY_TARGET == HWY_SCALAR
  // There is nothing that adds eight bytes.
  for (size_t block = 0; block < 64; ++block) {
    const uint8_t* const corner = patch + 8 * (block / 8 * stride + block % 8);
    sums[block] = 0;
    for (size_t y = 0; y < 8; ++y) {
      for (size_t x = 0; x < 8; ++x) sums[block] += corner[y * stride + x];
    }
  }
#else
  const hn::CappedTag<uint8_t, 64> d8;
  const hn::Repartition<uint64_t, decltype(d8)> d64;
  const size_t step = hn::Lanes(d8);
  for (size_t row = 0; row < 8; ++row) {
    for (size_t x = 0; x < 64; x += step) {
      auto total = hn::Zero(d64);
      for (size_t y = 0; y < 8; ++y) {
        total = hn::Add(total, hn::SumsOf8(hn::LoadU(
                                   d8, patch + (8 * row + y) * stride + x)));
      }
      hn::StoreU(total, d64, sums + 8 * row + x / 8);
    }
  }
#endif
}

int32_t SquaredDistance64(const int8_t* a, const int8_t* b) {
  const hn::CappedTag<int16_t, 32> d16;
  const hn::Rebind<int8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  auto even = hn::Zero(d32);
  auto odd = hn::Zero(d32);
  for (size_t i = 0; i < 64; i += hn::Lanes(d16)) {
    const auto difference = hn::Sub(hn::PromoteTo(d16, hn::LoadU(d8, a + i)),
                                    hn::PromoteTo(d16, hn::LoadU(d8, b + i)));
    even =
        hn::ReorderWidenMulAccumulate(d32, difference, difference, even, odd);
  }
  return hn::GetLane(hn::SumOfLanes(d32, hn::Add(even, odd)));
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace treeline::features {

HWY_EXPORT(SumBlocks);
HWY_EXPORT(SquaredDistance64);

const std::array<WhtKernel, kWhtCoefficientsPerChannel> kWhtOrder = {{
    {0, 0},                                  //
    {1, 0}, {0, 1},                          //
    {2, 0}, {1, 1}, {0, 2},                  //
    {3, 0}, {2, 1}, {1, 2}, {0, 3},          //
    {4, 0}, {3, 1}, {2, 2}, {1, 3}, {0, 4},  //
    {5, 0}, {4, 1}, {3, 2}, {2, 3}, {1, 4},
}};

namespace {

// The Walsh transform of eight numbers in order of sign changes: out[s] uses
// the function that changes sign s times. Butterflies give the Hadamard order;
// the permutation (bit-reversed Gray code) sorts by sign changes.
void Walsh8(const int32_t* in, size_t stride, int32_t* out) {
  const int32_t a0 = in[0] + in[4 * stride];
  const int32_t a1 = in[stride] + in[5 * stride];
  const int32_t a2 = in[2 * stride] + in[6 * stride];
  const int32_t a3 = in[3 * stride] + in[7 * stride];
  const int32_t a4 = in[0] - in[4 * stride];
  const int32_t a5 = in[stride] - in[5 * stride];
  const int32_t a6 = in[2 * stride] - in[6 * stride];
  const int32_t a7 = in[3 * stride] - in[7 * stride];
  const int32_t b0 = a0 + a2, b1 = a1 + a3, b2 = a0 - a2, b3 = a1 - a3;
  const int32_t b4 = a4 + a6, b5 = a5 + a7, b6 = a4 - a6, b7 = a5 - a7;
  out[0] = b0 + b1;  // ++++++++
  out[1] = b4 + b5;  // ++++----
  out[2] = b6 + b7;  // ++----++
  out[3] = b2 + b3;  // ++--++--
  out[4] = b2 - b3;  // +--++--+
  out[5] = b6 - b7;  // +--+-++-
  out[6] = b4 - b5;  // +-+--+-+
  out[7] = b0 - b1;  // +-+-+-+-
}

int8_t Quantize(int32_t sum, int32_t offset) {
  // Division by 4096, rounded to nearest, ties up.
  const int32_t rounded = ((sum + 2048) >> 12) - offset;
  return static_cast<int8_t>(std::clamp(rounded, -127, 127));
}

}  // namespace

void ComputeWht(const PlanarImage& image, std::span<const int32_t> x,
                std::span<const int32_t> y,
                std::span<WhtDescriptor> descriptors) {
  const auto sum_blocks = HWY_DYNAMIC_DISPATCH(SumBlocks);
  const size_t stride = static_cast<size_t>(image.width());
  const size_t plane = static_cast<size_t>(image.plane_bytes());
  for (size_t s = 0; s < x.size(); ++s) {
    const size_t corner = static_cast<size_t>(y[s] - kPatchRadius_px) * stride +
                          static_cast<size_t>(x[s] - kPatchRadius_px);
    for (size_t channel = 0; channel < 3; ++channel) {
      uint64_t sums[64];
      sum_blocks(image.data() + channel * plane + corner, stride, sums);
      int32_t blocks[64];
      std::copy(sums, sums + 64, blocks);
      // along_x[8 * row + i], then down the columns that are needed.
      int32_t along_x[64];
      for (size_t row = 0; row < 8; ++row) {
        Walsh8(blocks + 8 * row, 1, along_x + 8 * row);
      }
      int32_t along_both[6][8];
      for (size_t i = 0; i < 6; ++i) Walsh8(along_x + i, 8, along_both[i]);
      int8_t* out =
          descriptors[s].values.data() + channel * kWhtCoefficientsPerChannel;
      for (size_t k = 0; k < kWhtOrder.size(); ++k) {
        out[k] = Quantize(along_both[kWhtOrder[k].i][kWhtOrder[k].j],
                          k == 0 ? 128 : 0);
      }
    }
    std::fill(descriptors[s].values.begin() + 60, descriptors[s].values.end(),
              int8_t{0});
  }
}

int32_t SquaredDistance(const WhtDescriptor& a, const WhtDescriptor& b) {
  return HWY_DYNAMIC_DISPATCH(SquaredDistance64)(a.values.data(),
                                                 b.values.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
