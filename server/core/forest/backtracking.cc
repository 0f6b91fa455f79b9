#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/forest/backtracking.cc"
#include "server/core/forest/backtracking.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

// One SIMD lane walks one sample. A lane that reaches a leaf takes its next
// unvisited sibling at once, and a lane that has seen all its leaves takes the
// next sample, so lanes never wait for each other.
//
// The priority queue is a sorted list of at most N_max - 1 entries a lane: of
// more, the worst could never be taken. An entry is distance << 23 | node: its
// order is the order of Algorithm 3, and an insertion is a chain of minima and
// maxima without a branch.

HWY_BEFORE_NAMESPACE();
namespace treeline::forest::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kNodeBits = 23;
constexpr uint32_t kNodeMask = (1u << kNodeBits) - 1;
constexpr uint32_t kEmpty = 0xffffffffu;

// Vectors walked in turn.
constexpr size_t kGroups = 4;

using DI = hn::ScalableTag<int32_t>;
using DU = hn::Rebind<uint32_t, DI>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;

// What is fixed for a walk.
struct Walk {
  const int32_t* nodes;  // pairs lo, hi
  const uint8_t* pixels;
  int width;
  int height;
  const int32_t* x;
  const int32_t* y;
  const int32_t* inverse_depth;
  size_t samples;
  size_t leaves_per_sample;
  uint32_t* out;

  size_t next_sample = 0;  // not yet taken by any lane
  size_t active = 0;       // lanes with a sample
};

// The feature of split nodes `lo` for the samples in the lanes.
HWY_INLINE VI Feature(const Walk& walk, VI lo, VI x, VI y, VI inverse_depth,
                      VI center) {
  const DI d;
  const VI three = hn::Set(d, 3);
  const VI half = hn::Set(d, 1 << (features::kOffsetShift - 1));
  const VI zero = hn::Zero(d);
  const VI dx = hn::ShiftRight<22>(hn::ShiftLeft<22>(lo));
  const VI dy = hn::ShiftRight<22>(hn::ShiftLeft<12>(lo));
  const VI c1 = hn::And(hn::ShiftRight<20>(lo), three);
  const VI c2 = hn::And(hn::ShiftRight<22>(lo), three);
  const VI offset_x = hn::ShiftRight<features::kOffsetShift>(
      hn::Add(hn::Mul(dx, inverse_depth), half));
  const VI offset_y = hn::ShiftRight<features::kOffsetShift>(
      hn::Add(hn::Mul(dy, inverse_depth), half));
  const VI x2 =
      hn::Min(hn::Max(hn::Add(x, offset_x), zero), hn::Set(d, walk.width - 1));
  const VI y2 =
      hn::Min(hn::Max(hn::Add(y, offset_y), zero), hn::Set(d, walk.height - 1));
  // Row c2 * height + y2 of the planes.
  const VI row = hn::Add(hn::Mul(c2, hn::Set(d, walk.height)), y2);
  const VI offset = hn::Add(hn::Mul(row, hn::Set(d, walk.width)), x2);
  const VI byte = hn::Set(d, 255);
  const VI second =
      hn::And(hn::GatherOffset(d, reinterpret_cast<const int32_t*>(walk.pixels),
                               offset),
              byte);
  const VI first = hn::And(hn::Shr(center, hn::ShiftLeft<3>(c1)), byte);
  return hn::Sub(first, second);
}

// As many walking samples as a vector has lanes.
class LaneGroup {
 public:
  void Start(Walk& walk) {
    for (size_t lane = 0; lane < hn::Lanes(DI()); ++lane) {
      TakeSample(walk, lane);
    }
  }

  // One node further in every lane.
  HWY_INLINE void Step(Walk& walk) {
    const DI d;
    const DU du;
    const VU empty = hn::Set(du, kEmpty);
    const VU node = hn::Load(du, node_);
    const VI index = hn::BitCast(d, hn::Add(node, node));
    const VI lo = hn::GatherIndex(d, walk.nodes, index);
    const VI hi = hn::GatherIndex(d, walk.nodes + 1, index);
    const VU right_offset = hn::ShiftRight<9>(hn::BitCast(du, hi));
    const auto at_leaf = hn::Eq(right_offset, hn::Zero(du));

    // A leaf's number is no feature: its lanes compute with zeros instead.
    const VI f =
        Feature(walk, hn::IfThenZeroElse(hn::RebindMask(d, at_leaf), lo),
                hn::Load(d, x_), hn::Load(d, y_), hn::Load(d, inverse_depth_),
                hn::Load(d, center_));
    const VI threshold = hn::Sub(hn::And(hi, hn::Set(d, 511)), hn::Set(d, 256));
    const VI margin = hn::Sub(f, threshold);
    const auto go_right = hn::RebindMask(du, hn::Gt(margin, hn::Zero(d)));
    const VU left = hn::Add(node, hn::Set(du, 1));
    const VU right = hn::Add(node, right_offset);
    const VU chosen = hn::IfThenElse(go_right, right, left);
    const size_t queue_size = walk.leaves_per_sample - 1;
    if (queue_size > 0) {
      const VU other = hn::IfThenElse(go_right, left, right);
      VU entry = hn::Or(
          hn::ShiftLeft<kNodeBits>(hn::BitCast(du, hn::Abs(margin))), other);
      entry = hn::IfThenElse(at_leaf, empty, entry);
      for (size_t k = 0; k < queue_size; ++k) {
        const VU kept = hn::Load(du, queue_[k]);
        hn::Store(hn::Min(kept, entry), du, queue_[k]);
        entry = hn::Max(kept, entry);
      }
    }
    if (HWY_LIKELY(hn::AllFalse(du, at_leaf))) {
      hn::Store(chosen, du, node_);
      FetchNodes(walk);
      return;
    }
    // Lanes at a leaf take the head of their queue (kEmpty: they have none).
    const VU head = hn::Load(du, queue_[0]);
    for (size_t k = 0; k < queue_size; ++k) {
      // queue_[queue_size] is always empty.
      hn::Store(hn::IfThenElse(at_leaf, hn::Load(du, queue_[k + 1]),
                               hn::Load(du, queue_[k])),
                du, queue_[k]);
    }
    const VU head_node = hn::And(head, hn::Set(du, kNodeMask));
    hn::Store(hn::IfThenElse(at_leaf, head_node, chosen), du, node_);
    alignas(64) int32_t leaf[kMaxLanes];
    alignas(64) uint32_t heads[kMaxLanes];
    hn::Store(lo, d, leaf);
    hn::Store(head, du, heads);
    uint8_t bits[8] = {};
    hn::StoreMaskBits(du, at_leaf, bits);
    unsigned arrived = static_cast<unsigned>(bits[0] | bits[1] << 8);
    while (arrived != 0) {
      const size_t lane = static_cast<size_t>(__builtin_ctz(arrived));
      arrived &= arrived - 1;
      Arrive(walk, lane, static_cast<uint32_t>(leaf[lane]),
             heads[lane] != kEmpty);
    }
    FetchNodes(walk);
  }

 private:
  static constexpr size_t kMaxLanes = 16;  // 512 bits

  // Whether a lane is at a leaf is known only when its node is there, and
  // guessed wrongly now and then: without this the other groups' misses would
  // wait for this one's.
  HWY_INLINE void FetchNodes(const Walk& walk) const {
    for (size_t lane = 0; lane < hn::Lanes(DI()); ++lane) {
      __builtin_prefetch(walk.nodes + 2 * static_cast<size_t>(node_[lane]));
    }
  }

  void TakeSample(Walk& walk, size_t lane) {
    for (size_t k = 0; k < walk.leaves_per_sample; ++k) {
      queue_[k][lane] = kEmpty;
    }
    // An idle lane walks with sample 0, and its leaves are not recorded.
    const bool idle = walk.next_sample == walk.samples;
    const size_t s = idle ? 0 : walk.next_sample++;
    x_[lane] = walk.x[s];
    y_[lane] = walk.y[s];
    inverse_depth_[lane] = walk.inverse_depth[s];
    const size_t width = static_cast<size_t>(walk.width);
    const size_t plane = width * static_cast<size_t>(walk.height);
    const uint8_t* pixel = walk.pixels +
                           static_cast<size_t>(walk.y[s]) * width +
                           static_cast<size_t>(walk.x[s]);
    center_[lane] = pixel[0] | pixel[plane] << 8 | pixel[2 * plane] << 16;
    node_[lane] = 0;
    cursor_[lane] = end_[lane] = nullptr;
    if (idle) return;
    cursor_[lane] = walk.out + s * walk.leaves_per_sample;
    end_[lane] = cursor_[lane] + walk.leaves_per_sample;
    ++walk.active;
  }

  // A lane has reached a leaf; it goes on if it may see more and has where.
  void Arrive(Walk& walk, size_t lane, uint32_t leaf, bool has_more) {
    if (end_[lane] == nullptr) {
      TakeSample(walk, lane);
      return;
    }
    *cursor_[lane]++ = leaf;
    if (cursor_[lane] != end_[lane] && has_more) return;
    while (cursor_[lane] != end_[lane]) *cursor_[lane]++ = kNoLeaf;
    --walk.active;
    TakeSample(walk, lane);
  }

  alignas(64) int32_t x_[kMaxLanes];
  alignas(64) int32_t y_[kMaxLanes];
  alignas(64) int32_t inverse_depth_[kMaxLanes];
  alignas(64) int32_t center_[kMaxLanes];  // R | G << 8 | B << 16 at (x, y)
  alignas(64) uint32_t node_[kMaxLanes];
  alignas(64) uint32_t queue_[kMaxBacktrackingLeaves][kMaxLanes];
  uint32_t* cursor_[kMaxLanes];  // where a lane's next leaf goes
  uint32_t* end_[kMaxLanes];     // of its sample's slots; null: lane is idle
};

void VisitLeavesOfTree(const Node* tree, const uint8_t* pixels, int width,
                       int height, const int32_t* x, const int32_t* y,
                       const int32_t* inverse_depth, size_t samples,
                       int leaves_per_sample, uint32_t* out) {
  Walk walk{reinterpret_cast<const int32_t*>(tree),
            pixels,
            width,
            height,
            x,
            y,
            inverse_depth,
            samples,
            static_cast<size_t>(leaves_per_sample),
            out};
  // The groups' cache misses overlap.
  LaneGroup groups[kGroups];
  for (LaneGroup& group : groups) group.Start(walk);
  while (walk.active > 0) {
    for (LaneGroup& group : groups) group.Step(walk);
  }
}

// Squared distances of one descriptor to many leaves; the nearest of each run
// of `run` leaves. Leaf descriptors are fetched ahead: each is a cache line
// somewhere in memory.
void NearestOfRuns(const int8_t* descriptor, const int8_t* leaf_descriptors,
                   const uint32_t* leaves, size_t run, size_t runs,
                   size_t run_stride, LeafMatch* matches) {
  const hn::CappedTag<int16_t, 32> d16;
  const hn::Rebind<int8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  for (size_t r = 0; r < runs; ++r) {
    const uint32_t* candidates = leaves + r * run_stride;
    LeafMatch best;
    best.distance = 0x7fffffff;
    size_t k = 0;
    uint32_t next_mode = 0;
    uint32_t last_mode = 0;
    for (;;) {
      if (next_mode == last_mode) {
        if (k == run || candidates[k] == kNoLeaf) break;
        next_mode = Node::FirstMode(candidates[k]);
        last_mode = next_mode + Node::Modes(candidates[k]);
        ++k;
      }
      const uint32_t mode = next_mode++;
      const int8_t* leaf = leaf_descriptors + static_cast<size_t>(mode) * 64;
      auto even = hn::Zero(d32);
      auto odd = hn::Zero(d32);
      for (size_t i = 0; i < 64; i += hn::Lanes(d16)) {
        const auto difference =
            hn::Sub(hn::PromoteTo(d16, hn::LoadU(d8, descriptor + i)),
                    hn::PromoteTo(d16, hn::LoadU(d8, leaf + i)));
        even = hn::ReorderWidenMulAccumulate(d32, difference, difference, even,
                                             odd);
      }
      const int32_t distance =
          hn::GetLane(hn::SumOfLanes(d32, hn::Add(even, odd)));
      if (distance < best.distance ||
          (distance == best.distance && mode < best.leaf)) {
        best = {mode, distance};
      }
    }
    matches[r] = best;
  }
}

}  // namespace treeline::forest::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace treeline::forest {
namespace {

HWY_EXPORT(VisitLeavesOfTree);
HWY_EXPORT(NearestOfRuns);

// Leaf descriptors are fetched this many samples ahead of their use.
constexpr size_t kSamplesAhead = 2;

// Samples walked between two looks at the stop token.
constexpr size_t kChunk = 1024;

}  // namespace

void VisitLeaves(std::span<const Node> tree, const features::PlanarImage& image,
                 const SampleView& samples, int leaves_per_sample,
                 std::span<uint32_t> out) {
  if (samples.size() == 0) return;
  HWY_DYNAMIC_DISPATCH(VisitLeavesOfTree)
  (tree.data(), image.data(), image.width(), image.height(), samples.x.data(),
   samples.y.data(), samples.inverse_depth_q12.data(), samples.size(),
   leaves_per_sample, out.data());
}

namespace {

// The same number of leaves for every sample.
void PredictAlike(const ForestView& forest, const features::PlanarImage& image,
                  const SampleView& samples,
                  std::span<const features::WhtDescriptor> descriptors,
                  int leaves_per_sample, const std::stop_token& stop,
                  std::vector<uint32_t>& scratch,
                  std::span<LeafMatch> matches) {
  const size_t trees = static_cast<size_t>(forest.trees());
  const size_t run = static_cast<size_t>(leaves_per_sample);
  const auto nearest_of_runs = HWY_DYNAMIC_DISPATCH(NearestOfRuns);
  const auto* leaf_descriptors =
      reinterpret_cast<const int8_t*>(forest.descriptors.data());
  scratch.resize(trees * kChunk * run);
  for (size_t begin = 0; begin < samples.size(); begin += kChunk) {
    if (stop.stop_requested()) return;
    const size_t count = std::min(kChunk, samples.size() - begin);
    const SampleView chunk{samples.x.subspan(begin, count),
                           samples.y.subspan(begin, count),
                           samples.inverse_depth_q12.subspan(begin, count)};
    for (size_t t = 0; t < trees; ++t) {
      VisitLeaves(forest.tree(static_cast<int>(t)), image, chunk,
                  leaves_per_sample,
                  std::span(scratch).subspan(t * kChunk * run, count * run));
    }
    const auto fetch = [&](size_t i) {
      for (size_t t = 0; t < trees; ++t) {
        const uint32_t* leaves = scratch.data() + (t * kChunk + i) * run;
        for (size_t k = 0; k < run && leaves[k] != kNoLeaf; ++k) {
          __builtin_prefetch(leaf_descriptors +
                             static_cast<size_t>(Node::FirstMode(leaves[k])) *
                                 64);
        }
      }
    };
    for (size_t i = 0; i < std::min(kSamplesAhead, count); ++i) fetch(i);
    for (size_t i = 0; i < count; ++i) {
      if (i + kSamplesAhead < count) fetch(i + kSamplesAhead);
      LeafMatch* best = matches.data() + (begin + i) * trees;
      nearest_of_runs(descriptors[begin + i].values.data(), leaf_descriptors,
                      scratch.data() + i * run, run, trees, kChunk * run, best);
      std::sort(best, best + trees, [](const LeafMatch& a, const LeafMatch& b) {
        return a.distance != b.distance ? a.distance < b.distance
                                        : a.leaf < b.leaf;
      });
    }
  }
}

}  // namespace

void PredictLeaves(const ForestView& forest, const features::PlanarImage& image,
                   const SampleView& samples,
                   std::span<const features::WhtDescriptor> descriptors,
                   const BacktrackingOptions& options,
                   const std::stop_token& stop, BacktrackingScratch& scratch,
                   std::span<LeafMatch> matches) {
  const int first_leaves = std::min(options.first_leaves, options.leaves);
  PredictAlike(forest, image, samples, descriptors, first_leaves, stop,
               scratch.leaves, matches);
  if (first_leaves == options.leaves || stop.stop_requested()) return;
  const size_t trees = static_cast<size_t>(forest.trees());
  BacktrackingScratch& s = scratch;
  s.index.clear();
  s.x.clear();
  s.y.clear();
  s.inverse_depth_q12.clear();
  s.descriptors.clear();
  for (size_t i = 0; i < samples.size(); ++i) {
    if (matches[i * trees].distance <= options.good_squared_distance) continue;
    s.index.push_back(static_cast<uint32_t>(i));
    s.x.push_back(samples.x[i]);
    s.y.push_back(samples.y[i]);
    s.inverse_depth_q12.push_back(samples.inverse_depth_q12[i]);
    s.descriptors.push_back(descriptors[i]);
  }
  s.matches.resize(s.index.size() * trees);
  PredictAlike(forest, image, {s.x, s.y, s.inverse_depth_q12}, s.descriptors,
               options.leaves, stop, s.leaves, s.matches);
  if (stop.stop_requested()) return;
  for (size_t i = 0; i < s.index.size(); ++i) {
    std::copy_n(
        s.matches.begin() + static_cast<std::ptrdiff_t>(i * trees), trees,
        matches.begin() + static_cast<std::ptrdiff_t>(s.index[i] * trees));
  }
}

}  // namespace treeline::forest
#endif  // HWY_ONCE
