#include "server/repository/memory_budget.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace treeline::repository {

void MemoryBudget::Reserve(uint64_t bytes) {
  reserved_bytes_ += bytes;
  ++reservations_;
}

void MemoryBudget::Return(uint64_t bytes) {
  reserved_bytes_ -= bytes;
  --reservations_;
}

std::vector<size_t> MemoryBudget::ChooseToGo(
    std::span<const ResidentModel> held, uint64_t bytes,
    uint64_t resident_bytes) const {
  std::vector<size_t> order(held.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, {}, [&](size_t i) {
    const ResidentModel& model = held[i];
    return std::tuple(model.is_same_scene, model.is_in_use, model.last_use);
  });
  uint64_t held_bytes = 0;
  for (const ResidentModel& model : held) held_bytes += model.bytes;
  // What comes free without anything being done, or is waited for already.
  uint64_t coming =
      resident_bytes - std::min(resident_bytes, held_bytes) + reserved_bytes_;
  uint64_t used = resident_bytes + reserved_bytes_ + bytes;
  std::vector<size_t> chosen;
  for (const size_t i : order) {
    if (limit_bytes_ == 0 || used <= limit_bytes_) break;
    const bool may_wait = held[i].is_in_use || held[i].is_same_scene;
    if (may_wait && used - std::min(used, coming) <= limit_bytes_) break;
    if (held[i].is_in_use) {
      coming += held[i].bytes;  // when its queries have ended
    } else {
      used -= std::min(used, held[i].bytes);
    }
    chosen.push_back(i);
  }
  return chosen;
}

}  // namespace treeline::repository
