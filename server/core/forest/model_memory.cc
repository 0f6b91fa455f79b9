#include "server/core/forest/model_memory.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::forest {

absl::StatusOr<ModelMemory> ModelMemory::Allocate(uint64_t bytes) {
  ModelMemory memory;
  if (bytes == 0) return memory;
  void* address = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (address == MAP_FAILED) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "no memory for ", bytes, " bytes: ", std::strerror(errno)));
  }
  memory.data_ = static_cast<uint8_t*>(address);
  memory.size_ = bytes;
  // A wish: where the system gives no huge pages, small ones do.
  (void)madvise(address, bytes, MADV_HUGEPAGE);
  return memory;
}

void ModelMemory::Seal() {
  if (data_ != nullptr) (void)mprotect(data_, size_, PROT_READ);
}

ModelMemory::ModelMemory(ModelMemory&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

ModelMemory& ModelMemory::operator=(ModelMemory&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

ModelMemory::~ModelMemory() {
  if (data_ != nullptr) munmap(data_, size_);
}

}  // namespace treeline::forest
