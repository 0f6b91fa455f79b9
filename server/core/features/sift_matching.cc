#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/sift_matching.cc"
// Products of bytes in one instruction, where the machine has it.
#define HWY_WANT_AVX3_DL 1
#include "server/core/features/sift_matching.h"

#include <cstring>

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

// What all targets share.
#ifndef TREELINE_SIFT_MATCHING_SHARED_
#define TREELINE_SIFT_MATCHING_SHARED_

namespace treeline::features {

// References are read once for so many queries.
constexpr size_t kQueries = 4;
constexpr size_t kSize = SiftDescriptor::kDimensions;
// Descriptors are read in words of four bytes.
constexpr size_t kWords = kSize / 4;
// Further than any two descriptors are apart: no reference.
constexpr int32_t kNowhere = 1 << 29;

// Queries as the dot products read them: less 128, or the even and the odd
// bytes of each word as 16 bits.
struct QueryBlock {
  int32_t less_middle[kQueries][kWords] = {};
  int32_t even[kQueries][kWords] = {};
  int32_t odd[kQueries][kWords] = {};
  uint8_t bytes[kQueries][kSize] = {};
  int32_t norm[kQueries] = {};

  void Set(size_t q, const uint8_t* descriptor) {
    std::memcpy(bytes[q], descriptor, kSize);
    norm[q] = 0;
    for (size_t w = 0; w < kWords; ++w) {
      uint32_t word = 0;
      std::memcpy(&word, descriptor + 4 * w, 4);
      less_middle[q][w] = static_cast<int32_t>(word ^ 0x80808080u);
      even[q][w] = static_cast<int32_t>(word & 0x00ff00ffu);
      odd[q][w] = static_cast<int32_t>((word >> 8) & 0x00ff00ffu);
    }
    for (size_t i = 0; i < kSize; ++i) {
      norm[q] += descriptor[i] * descriptor[i];
    }
  }
};

}  // namespace treeline::features

#endif  // TREELINE_SIFT_MATCHING_SHARED_

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<int32_t, 16>;
using V = hn::Vec<D>;

// As many references as a vector has lanes: word w of the reference in lane l
// is words[w * lanes + l]. `offset` is what their squared distance from a query
// has beside the query's norm and twice the products that Dots computes.
struct Tile {
  HWY_ALIGN int32_t words[kWords * 16];
  HWY_ALIGN int32_t offset[16];
};

void FillTile(const SiftDescriptorView& references, size_t first, Tile& tile) {
  const size_t lanes = hn::Lanes(D());
  for (size_t l = 0; l < lanes; ++l) {
    if (first + l >= references.size) {
      for (size_t w = 0; w < kWords; ++w) tile.words[w * lanes + l] = 0;
      tile.offset[l] = kNowhere;
      continue;
    }
    const uint8_t* at = references.data + (first + l) * references.stride_bytes;
    for (size_t w = 0; w < kWords; ++w) {
      std::memcpy(&tile.words[w * lanes + l], at + 4 * w, 4);
    }
    int32_t norm = 0;
    int32_t sum = 0;
    for (size_t i = 0; i < kSize; ++i) {
      norm += at[i] * at[i];
      sum += at[i];
    }
#if HWY_TARGET == HWY_AVX3_DL
    tile.offset[l] = norm - 256 * sum;
#else
    (void)sum;
    tile.offset[l] = norm;
#endif
  }
}

// The products of the queries with the references of a tile.
HWY_INLINE void Dots(const QueryBlock& queries, const Tile& tile,
                     V (&dots)[kQueries]) {
  const D d;
  for (V& dot : dots) dot = hn::Zero(d);
#if HWY_TARGET == HWY_AVX3_DL
  // Bytes without sign times bytes with one. Highway 1.0 has no name for it,
  // and does not let the compiler use its intrinsic; every machine of this
  // target (Ice Lake, Zen 4) has it.
  for (size_t w = 0; w < kWords; ++w) {
    const V words = hn::Load(d, tile.words + w * hn::Lanes(d));
    for (size_t q = 0; q < kQueries; ++q) {
      const V query = hn::Set(d, queries.less_middle[q][w]);
      __asm__("vpdpbusd %2, %1, %0"
              : "+v"(dots[q].raw)
              : "v"(words.raw), "v"(query.raw));
    }
  }
#elif HWY_TARGET != HWY_SCALAR
  // Two sums a lane, of which products is each target's own; together they are
  // of neighbours.
  const hn::Repartition<int16_t, D> d16;
  const V low = hn::Set(d, 0x00ff00ff);
  V others[kQueries];
  for (V& other : others) other = hn::Zero(d);
  for (size_t w = 0; w < kWords; ++w) {
    const V words = hn::Load(d, tile.words + w * hn::Lanes(d));
    const auto even = hn::BitCast(d16, hn::And(words, low));
    const auto odd = hn::BitCast(d16, hn::And(hn::ShiftRight<8>(words), low));
    for (size_t q = 0; q < kQueries; ++q) {
      const auto of = [&](int32_t pair) HWY_ATTR {
        return hn::BitCast(d16, hn::Set(d, pair));
      };
      dots[q] = hn::ReorderWidenMulAccumulate(d, even, of(queries.even[q][w]),
                                              dots[q], others[q]);
      dots[q] = hn::ReorderWidenMulAccumulate(d, odd, of(queries.odd[q][w]),
                                              dots[q], others[q]);
    }
  }
  for (size_t q = 0; q < kQueries; ++q) {
    dots[q] = hn::RearrangeToOddPlusEven(dots[q], others[q]);
  }
#else
  const size_t lanes = hn::Lanes(d);
  for (size_t q = 0; q < kQueries; ++q) {
    HWY_ALIGN int32_t sums[16] = {};
    for (size_t l = 0; l < lanes; ++l) {
      for (size_t w = 0; w < kWords; ++w) {
        uint8_t bytes[4];
        std::memcpy(bytes, &tile.words[w * lanes + l], 4);
        for (size_t i = 0; i < 4; ++i) {
          sums[l] += bytes[i] * queries.bytes[q][4 * w + i];
        }
      }
    }
    dots[q] = hn::Load(d, sums);
  }
#endif
}

// The nearest of the references in each lane.
struct LaneBest {
  V distance, second, index;
};

// Of equally near ones the first counts.
NearestSift NearestOfLanes(const LaneBest& best) {
  const D d;
  HWY_ALIGN int32_t distance[16];
  HWY_ALIGN int32_t second[16];
  HWY_ALIGN int32_t index[16];
  hn::Store(best.distance, d, distance);
  hn::Store(best.second, d, second);
  hn::Store(best.index, d, index);
  NearestSift nearest;
  const auto see = [&](int32_t at, int32_t which) {
    if (at >= kNowhere) return;
    if (at < nearest.squared_distance ||
        (at == nearest.squared_distance &&
         static_cast<uint32_t>(which) < nearest.index)) {
      nearest = {static_cast<uint32_t>(which), at, nearest.squared_distance};
    } else if (at < nearest.second_squared_distance) {
      nearest.second_squared_distance = at;
    }
  };
  for (size_t l = 0; l < hn::Lanes(d); ++l) see(distance[l], index[l]);
  for (size_t l = 0; l < hn::Lanes(d); ++l) {
    if (second[l] < kNowhere && second[l] < nearest.second_squared_distance) {
      nearest.second_squared_distance = second[l];
    }
  }
  return nearest;
}

// |a - b|^2 = |a|^2 + |b|^2 - 2 a . b. `tiles` has room for all references.
void NearestOfTiles(const SiftDescriptor* queries, size_t count,
                    const SiftDescriptorView& references, void* tile_memory,
                    NearestSift* nearest) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  const size_t tile_count = (references.size + lanes - 1) / lanes;
  Tile* const tiles = static_cast<Tile*>(tile_memory);
  for (size_t t = 0; t < tile_count; ++t) {
    FillTile(references, t * lanes, tiles[t]);
  }
  QueryBlock block;
  for (size_t first = 0; first < count; first += kQueries) {
    const size_t used = first + kQueries < count ? kQueries : count - first;
    for (size_t q = 0; q < used; ++q) {
      block.Set(q, queries[first + q].values.data());
    }
    LaneBest best[kQueries];
    for (LaneBest& b : best) {
      b = {hn::Set(d, kNowhere), hn::Set(d, kNowhere), hn::Zero(d)};
    }
    for (size_t t = 0; t < tile_count; ++t) {
      V dots[kQueries];
      Dots(block, tiles[t], dots);
      const V offset = hn::Load(d, tiles[t].offset);
      const V index = hn::Iota(d, static_cast<int32_t>(t * lanes));
      for (size_t q = 0; q < kQueries; ++q) {
        const V distance = hn::Add(hn::Set(d, block.norm[q]),
                                   hn::Sub(offset, hn::ShiftLeft<1>(dots[q])));
        LaneBest& b = best[q];
        b.index = hn::IfThenElse(hn::Lt(distance, b.distance), index, b.index);
        b.second = hn::Min(b.second, hn::Max(b.distance, distance));
        b.distance = hn::Min(b.distance, distance);
      }
    }
    for (size_t q = 0; q < used; ++q) {
      nearest[first + q] = NearestOfLanes(best[q]);
    }
  }
}

size_t TileBytes(size_t references) {
  const size_t lanes = hn::Lanes(D());
  return (references + lanes - 1) / lanes * sizeof(Tile);
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

#include "hwy/aligned_allocator.h"

namespace treeline::features {
namespace {

HWY_EXPORT(NearestOfTiles);
HWY_EXPORT(TileBytes);

}  // namespace

void FindNearestSift(std::span<const SiftDescriptor> queries,
                     const SiftDescriptorView& references,
                     std::span<NearestSift> nearest) {
  std::ranges::fill(nearest, NearestSift{});
  if (references.size == 0) return;
  const auto tiles = hwy::AllocateAligned<uint8_t>(
      HWY_DYNAMIC_DISPATCH(TileBytes)(references.size));
  HWY_DYNAMIC_DISPATCH(NearestOfTiles)
  (queries.data(), queries.size(), references, tiles.get(), nearest.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
