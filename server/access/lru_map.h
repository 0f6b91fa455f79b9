// A map that remembers a bounded number of entries: those used last.
#ifndef SERVER_ACCESS_LRU_MAP_H_
#define SERVER_ACCESS_LRU_MAP_H_

#include <cstddef>
#include <list>
#include <string>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace treeline::access {

// Not thread-safe.
template <typename Value>
class LruMap {
 public:
  explicit LruMap(size_t capacity) : capacity_(capacity) {}

  // nullptr: not there. Counts as a use. Valid until the next Insert or Clear.
  Value* Find(const std::string& key) {
    const auto found = by_key_.find(key);
    if (found == by_key_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return &entries_.front().second;
  }

  // Replaces what the key had. With a capacity of 0 nothing is kept.
  void Insert(const std::string& key, Value value) {
    if (capacity_ == 0) return;
    if (Value* const present = Find(key); present != nullptr) {
      *present = std::move(value);
      return;
    }
    entries_.emplace_front(key, std::move(value));
    by_key_[key] = entries_.begin();
    if (entries_.size() > capacity_) {
      by_key_.erase(entries_.back().first);
      entries_.pop_back();
    }
  }

  void Clear() {
    by_key_.clear();
    entries_.clear();
  }

  size_t size() const { return entries_.size(); }

 private:
  using Entries = std::list<std::pair<std::string, Value>>;

  const size_t capacity_ = 0;
  // The one used last comes first.
  Entries entries_;
  absl::flat_hash_map<std::string, typename Entries::iterator> by_key_;
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_LRU_MAP_H_
