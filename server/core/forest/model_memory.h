// Where the bytes of a loaded model live.
#ifndef SERVER_CORE_FOREST_MODEL_MEMORY_H_
#define SERVER_CORE_FOREST_MODEL_MEMORY_H_

#include <cstdint>
#include <span>

#include "absl/status/statusor.h"

namespace treeline::forest {

// Memory of this process alone, so that nobody who writes to the model's file
// can change or take away what was verified. It begins at a page and is asked
// for in huge pages: a query walks through a forest at random, and misses fewer
// translations of addresses with them. Takes as much as the file, rounded up to
// a page of 4 KiB; it is anonymous, so the system cannot drop it as it drops
// the pages of a mapped file, and processes do not share it.
class ModelMemory {
 public:
  // RESOURCE_EXHAUSTED: the system has not that much.
  static absl::StatusOr<ModelMemory> Allocate(uint64_t bytes);

  ModelMemory() = default;
  ModelMemory(ModelMemory&& other) noexcept;
  ModelMemory& operator=(ModelMemory&& other) noexcept;
  ~ModelMemory();

  std::span<const uint8_t> bytes() const { return {data_, size_}; }
  // To be filled; not after Seal().
  std::span<uint8_t> writable() { return {data_, size_}; }

  // Whoever writes from now on is stopped by SIGSEGV.
  void Seal();

 private:
  uint8_t* data_ = nullptr;
  uint64_t size_ = 0;
};

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_MODEL_MEMORY_H_
