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

void Nearest(const SiftDescriptor* queries, size_t count,
             const SiftDescriptorView& references, NearestSift* nearest) {
  const hn::CappedTag<int16_t, 32> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  for (size_t first = 0; first < count; first += kQueries) {
    const size_t last = first + kQueries < count ? first + kQueries : count;
    for (size_t r = 0; r < references.size; ++r) {
      const uint8_t* reference = references.data + r * references.stride_bytes;
      for (size_t q = first; q < last; ++q) {
        const uint8_t* query = queries[q].values.data();
        auto even = hn::Zero(d32);
        auto odd = hn::Zero(d32);
        for (size_t i = 0; i < SiftDescriptor::kDimensions;
             i += hn::Lanes(d16)) {
          const auto difference =
              hn::Sub(hn::PromoteTo(d16, hn::LoadU(d8, query + i)),
                      hn::PromoteTo(d16, hn::LoadU(d8, reference + i)));
          even = hn::ReorderWidenMulAccumulate(d32, difference, difference,
                                               even, odd);
        }
        const int32_t distance =
            hn::GetLane(hn::SumOfLanes(d32, hn::Add(even, odd)));
        NearestSift& best = nearest[q];
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

namespace treeline::features {
namespace {

HWY_EXPORT(Nearest);

}  // namespace

void FindNearestSift(std::span<const SiftDescriptor> queries,
                     const SiftDescriptorView& references,
                     std::span<NearestSift> nearest) {
  std::ranges::fill(nearest, NearestSift{});
  HWY_DYNAMIC_DISPATCH(Nearest)
  (queries.data(), queries.size(), references, nearest.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
