#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/sift_matching.cc"
#include "server/core/features/sift_matching.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// References are read once for so many queries.
constexpr size_t kQueries = 4;
constexpr size_t kSize = SiftDescriptor::kDimensions;

int32_t SquaredNorm(const uint8_t* descriptor) {
  const hn::CappedTag<int16_t, 32> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  auto even = hn::Zero(d32);
  auto odd = hn::Zero(d32);
  for (size_t i = 0; i < kSize; i += hn::Lanes(d16)) {
    const auto values = hn::PromoteTo(d16, hn::LoadU(d8, descriptor + i));
    even = hn::ReorderWidenMulAccumulate(d32, values, values, even, odd);
  }
  return hn::GetLane(hn::SumOfLanes(d32, hn::Add(even, odd)));
}

// dots[q] of the kQueries queries, of 16 bits, with a reference.
void DotProducts(const int16_t* queries, const uint8_t* reference,
                 int32_t* dots) {
  const hn::CappedTag<int16_t, 32> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  auto sum0 = hn::Zero(d32);
  auto sum1 = hn::Zero(d32);
  auto sum2 = hn::Zero(d32);
  auto sum3 = hn::Zero(d32);
  auto odd0 = hn::Zero(d32);
  auto odd1 = hn::Zero(d32);
  auto odd2 = hn::Zero(d32);
  auto odd3 = hn::Zero(d32);
  for (size_t i = 0; i < kSize; i += hn::Lanes(d16)) {
    const auto values = hn::PromoteTo(d16, hn::LoadU(d8, reference + i));
    const auto of = [&](size_t q) HWY_ATTR {
      return hn::Load(d16, queries + q * kSize + i);
    };
    sum0 = hn::ReorderWidenMulAccumulate(d32, of(0), values, sum0, odd0);
    sum1 = hn::ReorderWidenMulAccumulate(d32, of(1), values, sum1, odd1);
    sum2 = hn::ReorderWidenMulAccumulate(d32, of(2), values, sum2, odd2);
    sum3 = hn::ReorderWidenMulAccumulate(d32, of(3), values, sum3, odd3);
  }
  dots[0] = hn::GetLane(hn::SumOfLanes(d32, hn::Add(sum0, odd0)));
  dots[1] = hn::GetLane(hn::SumOfLanes(d32, hn::Add(sum1, odd1)));
  dots[2] = hn::GetLane(hn::SumOfLanes(d32, hn::Add(sum2, odd2)));
  dots[3] = hn::GetLane(hn::SumOfLanes(d32, hn::Add(sum3, odd3)));
}

// |a - b|^2 = |a|^2 + |b|^2 - 2 a . b; `norms` has room for |b|^2 of all
// references.
void Nearest(const SiftDescriptor* queries, size_t count,
             const SiftDescriptorView& references, int32_t* norms,
             NearestSift* nearest) {
  for (size_t r = 0; r < references.size; ++r) {
    norms[r] = SquaredNorm(references.data + r * references.stride_bytes);
  }
  HWY_ALIGN int16_t block[kQueries * kSize] = {};
  for (size_t first = 0; first < count; first += kQueries) {
    const size_t used = first + kQueries < count ? kQueries : count - first;
    int32_t query_norm[kQueries] = {};
    for (size_t q = 0; q < used; ++q) {
      const uint8_t* query = queries[first + q].values.data();
      for (size_t i = 0; i < kSize; ++i) block[q * kSize + i] = query[i];
      query_norm[q] = SquaredNorm(query);
    }
    for (size_t r = 0; r < references.size; ++r) {
      int32_t dots[kQueries];
      DotProducts(block, references.data + r * references.stride_bytes, dots);
      for (size_t q = 0; q < used; ++q) {
        const int32_t distance = query_norm[q] + norms[r] - 2 * dots[q];
        NearestSift& best = nearest[first + q];
        if (distance < best.squared_distance) {
          best = {static_cast<uint32_t>(r), distance, best.squared_distance};
        } else if (distance < best.second_squared_distance) {
          best.second_squared_distance = distance;
        }
      }
    }
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <vector>

namespace treeline::features {
namespace {

HWY_EXPORT(Nearest);

}  // namespace

void FindNearestSift(std::span<const SiftDescriptor> queries,
                     const SiftDescriptorView& references,
                     std::span<NearestSift> nearest) {
  std::ranges::fill(nearest, NearestSift{});
  std::vector<int32_t> norms(references.size);
  HWY_DYNAMIC_DISPATCH(Nearest)
  (queries.data(), queries.size(), references, norms.data(), nearest.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
