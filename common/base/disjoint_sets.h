// Which of some numbers belong together.
#ifndef COMMON_BASE_DISJOINT_SETS_H_
#define COMMON_BASE_DISJOINT_SETS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace treeline::base {

// Sets of the numbers 0 to count - 1, each alone at first, that can be joined
// (Tarjan 1975, with path halving and union by index). Not thread-safe.
class DisjointSets {
 public:
  // count: at most 2^32.
  explicit DisjointSets(size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), uint32_t{0});
  }

  // The least number of the set that i is in: names of sets do not depend on
  // the order in which they were joined. Shortens the way for later calls.
  uint32_t Find(uint32_t i) {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }

  // Makes one set of those that a and b are in.
  void Join(uint32_t a, uint32_t b) {
    a = Find(a);
    b = Find(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parents_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_DISJOINT_SETS_H_
