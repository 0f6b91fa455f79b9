#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/forest/sift_backtracking.cc"
#include "server/core/forest/sift_backtracking.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

// A descriptor is walked through all trees first, and the descriptors of the
// leaves it reaches are fetched from memory while its predecessor's distances
// are computed: each mode is two cache lines somewhere in many megabytes.

HWY_BEFORE_NAMESPACE();
namespace treeline::forest::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Squared distances of `descriptor` to `count` descriptors in a row.
void DistancesToRun(const uint8_t* descriptor, const uint8_t* run, size_t count,
                    int32_t* distances) {
  constexpr size_t kDimensions = features::SiftDescriptor::kDimensions;
  const hn::CappedTag<int16_t, 32> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const hn::RepartitionToWide<decltype(d16)> d32;
  for (size_t m = 0; m < count; ++m) {
    const uint8_t* mode = run + m * kDimensions;
    auto even = hn::Zero(d32);
    auto odd = hn::Zero(d32);
    for (size_t i = 0; i < kDimensions; i += hn::Lanes(d16)) {
      const auto difference =
          hn::Sub(hn::PromoteTo(d16, hn::LoadU(d8, descriptor + i)),
                  hn::PromoteTo(d16, hn::LoadU(d8, mode + i)));
      even =
          hn::ReorderWidenMulAccumulate(d32, difference, difference, even, odd);
    }
    distances[m] = hn::GetLane(hn::SumOfLanes(d32, hn::Add(even, odd)));
  }
}

}  // namespace treeline::forest::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <array>
#include <cstdlib>

namespace treeline::forest {
namespace {

HWY_EXPORT(DistancesToRun);

constexpr int kNodeBits = 23;
constexpr uint32_t kNodeMask = (1u << kNodeBits) - 1;
// Descriptors matched between two looks at the stop token.
constexpr size_t kChunk = 64;
constexpr size_t kLineBytes = 64;

// The leaves that one descriptor reaches, of all trees.
struct Visit {
  std::vector<uint32_t> leaves;
  size_t count = 0;
};

struct Candidate {
  uint32_t mode;
  int32_t distance;
};

class SiftMatcher {
 public:
  SiftMatcher(const ForestView& forest, const SiftSearchOptions& options)
      : forest_(forest),
        per_tree_(static_cast<size_t>(options.leaves_per_tree)),
        squared_place_(options.same_place * options.same_place),
        distances_to_run_(HWY_DYNAMIC_DISPATCH(DistancesToRun)) {
    for (Visit& visit : visits_) {
      visit.leaves.resize(per_tree_ * static_cast<size_t>(forest.trees()));
    }
  }

  void Match(std::span<const features::SiftDescriptor> descriptors,
             std::span<const uint32_t> which, std::span<SiftMatch> matches) {
    Walk(descriptors[which[0]], visits_[0]);
    for (size_t k = 0; k < which.size(); ++k) {
      if (k + 1 < which.size()) {
        Walk(descriptors[which[k + 1]], visits_[(k + 1) % 2]);
      }
      matches[which[k]] = Nearest(descriptors[which[k]], visits_[k % 2]);
    }
  }

 private:
  void Walk(const features::SiftDescriptor& descriptor, Visit& visit) {
    visit.count = 0;
    for (int t = 0; t < forest_.trees(); ++t) {
      const size_t added = VisitSiftLeaves(
          forest_.tree(t), descriptor,
          std::span(visit.leaves).subspan(visit.count, per_tree_));
      for (size_t k = visit.count; k < visit.count + added; ++k) {
        const char* run = reinterpret_cast<const char*>(
            forest_.sift_descriptors.data() + Node::FirstMode(visit.leaves[k]));
        const size_t bytes =
            Node::Modes(visit.leaves[k]) * sizeof(features::SiftDescriptor);
        for (size_t b = 0; b < bytes; b += kLineBytes) {
          __builtin_prefetch(run + b);
        }
      }
      visit.count += added;
    }
  }

  SiftMatch Nearest(const features::SiftDescriptor& descriptor,
                    const Visit& visit) {
    candidates_.clear();
    SiftMatch best{.distance = SiftMatch::kNothingElsewhere,
                   .distance_elsewhere = SiftMatch::kNothingElsewhere};
    std::array<int32_t, Node::kMaxModes> distances;
    for (size_t k = 0; k < visit.count; ++k) {
      const uint32_t first = Node::FirstMode(visit.leaves[k]);
      const uint32_t modes = Node::Modes(visit.leaves[k]);
      distances_to_run_(descriptor.values.data(),
                        forest_.sift_descriptors[first].values.data(), modes,
                        distances.data());
      for (uint32_t m = 0; m < modes; ++m) {
        candidates_.push_back({first + m, distances[m]});
        if (distances[m] < best.distance ||
            (distances[m] == best.distance && first + m < best.mode)) {
          best.mode = first + m;
          best.distance = distances[m];
        }
      }
    }
    if (best.mode == kNoLeaf) return best;
    const geometry::Vec3 place = forest_.LeafMean(best.mode);
    for (const Candidate& candidate : candidates_) {
      if (candidate.distance >= best.distance_elsewhere) continue;
      if (geometry::SquaredNorm(forest_.LeafMean(candidate.mode) - place) >
          squared_place_) {
        best.distance_elsewhere = candidate.distance;
      }
    }
    return best;
  }

  const ForestView& forest_;
  const size_t per_tree_;
  const double squared_place_;
  void (*const distances_to_run_)(const uint8_t*, const uint8_t*, size_t,
                                  int32_t*);
  Visit visits_[2];
  std::vector<Candidate> candidates_;
};

}  // namespace

int32_t SquaredDistance(const features::SiftDescriptor& a,
                        const features::SiftDescriptor& b) {
  int32_t distance = 0;
  HWY_DYNAMIC_DISPATCH(DistancesToRun)
  (a.values.data(), b.values.data(), 1, &distance);
  return distance;
}

size_t VisitSiftLeaves(std::span<const Node> tree,
                       const features::SiftDescriptor& descriptor,
                       std::span<uint32_t> leaves) {
  // Siblings not yet visited, nearest first: |margin| << 23 | node. Of more
  // than there are leaves to go, the farthest could never be taken.
  std::array<uint32_t, kMaxBacktrackingLeaves> queue;
  size_t queued = 0;
  size_t found = 0;
  uint32_t at = 0;
  for (;;) {
    const Node& node = tree[at];
    if (node.is_leaf()) {
      leaves[found++] = node.lo;
      if (found == leaves.size() || queued == 0) return found;
      at = queue[0] & kNodeMask;
      std::copy(queue.begin() + 1,
                queue.begin() + static_cast<std::ptrdiff_t>(queued),
                queue.begin());
      --queued;
      continue;
    }
    const int value = descriptor.values[node.lo & 127] - 128;
    const int margin = value - node.threshold();
    const uint32_t left = at + 1;
    const uint32_t right = at + node.right_offset();
    const uint32_t other = margin > 0 ? left : right;
    at = margin > 0 ? right : left;
    const size_t room = leaves.size() - found - 1;
    const uint32_t entry =
        static_cast<uint32_t>(std::abs(margin)) << kNodeBits | other;
    if (queued == room) {
      if (room == 0 || entry >= queue[queued - 1]) continue;
      --queued;
    }
    size_t slot = queued++;
    for (; slot > 0 && queue[slot - 1] > entry; --slot) {
      queue[slot] = queue[slot - 1];
    }
    queue[slot] = entry;
  }
}

void MatchSift(const ForestView& forest,
               std::span<const features::SiftDescriptor> descriptors,
               std::span<const uint32_t> which,
               const SiftSearchOptions& options, const std::stop_token& stop,
               std::span<SiftMatch> matches) {
  SiftMatcher matcher(forest, options);
  for (size_t begin = 0; begin < which.size(); begin += kChunk) {
    if (stop.stop_requested()) return;
    matcher.Match(descriptors,
                  which.subspan(begin, std::min(kChunk, which.size() - begin)),
                  matches);
  }
}

}  // namespace treeline::forest
#endif  // HWY_ONCE
