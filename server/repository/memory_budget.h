// How much memory models may take, and which go when another needs room.
#ifndef SERVER_REPOSITORY_MEMORY_BUDGET_H_
#define SERVER_REPOSITORY_MEMORY_BUDGET_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace treeline::repository {

// A model in memory, as a candidate to go.
struct ResidentModel {
  uint64_t bytes = 0;
  // The number of its last use; the least was used longest ago.
  uint64_t last_use = 0;
  // A query, or whoever else got it, still has it: its memory comes free only
  // when that lets go.
  bool is_in_use = false;
  // Of the scene for which room is made.
  bool is_same_scene = false;
};

// Bytes of models, in a limit, if there is one. Loads at work reserve theirs.
class MemoryBudget {
 public:
  // 0: no limit.
  explicit MemoryBudget(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}

  uint64_t limit_bytes() const { return limit_bytes_; }
  uint64_t reservations() const { return reservations_; }

  // Whether a model alone is too large.
  bool IsTooLarge(uint64_t bytes) const {
    return limit_bytes_ != 0 && bytes > limit_bytes_;
  }
  // Whether there is room for `bytes` beside what is reserved and
  // `resident_bytes`, which all models take that are not destroyed yet.
  bool Fits(uint64_t bytes, uint64_t resident_bytes) const {
    return limit_bytes_ == 0 ||
           resident_bytes + reserved_bytes_ + bytes <= limit_bytes_;
  }

  void Reserve(uint64_t bytes);
  // Gives back what Reserve() took.
  void Return(uint64_t bytes);

  // Which of `held`, by index and in this order, go for a model of `bytes`:
  // none if it fits; as few as are enough. Idle ones first, and the longest
  // unused of them first; then those in use; last those of the very scene, so
  // that it has no gap. `resident_bytes` as above: what is in it beyond `held`
  // was let go and is still used. That comes free without anything being done,
  // and the reservations may; if it is enough, neither those in use nor those
  // of the scene go.
  std::vector<size_t> ChooseToGo(std::span<const ResidentModel> held,
                                 uint64_t bytes, uint64_t resident_bytes) const;

 private:
  uint64_t limit_bytes_;
  uint64_t reserved_bytes_ = 0;
  uint64_t reservations_ = 0;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_MEMORY_BUDGET_H_
