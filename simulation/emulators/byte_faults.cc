#include "simulation/emulators/byte_faults.h"

#include <algorithm>
#include <utility>

#include "common/base/random.h"

namespace treeline::emulators {
namespace {

// Streams of random numbers of one seed.
constexpr uint64_t kByteStream = 0;
constexpr uint64_t kPieceStream = uint64_t{1} << 62;

}  // namespace

std::vector<std::string> ByteFaults::Apply(absl::string_view bytes,
                                           const ActiveFaults& faults,
                                           base::MonotonicTime now) {
  if (held_.empty()) held_since_ = now;
  for (const char byte : bytes) {
    base::Random random(seed_, kByteStream + bytes_seen_++);
    if (random.NextUnit() < faults.drop) continue;
    const bool change = random.NextUnit() < faults.corrupt;
    const auto other = static_cast<char>(1 + random.NextBelow(255));
    if (faults.garbage) {
      held_ += static_cast<char>(random.NextBelow(256));
    } else {
      held_ += change ? static_cast<char>(byte ^ other) : byte;
    }
  }
  std::vector<std::string> writes;
  if (held_.empty() ||
      (faults.merge_s > 0 &&
       base::MillisecondsBetween(held_since_, now) * 1e-3 < faults.merge_s)) {
    return writes;
  }
  std::string all = std::exchange(held_, {});
  if (faults.split_bytes <= 0) {
    writes.push_back(std::move(all));
    return writes;
  }
  for (size_t at = 0; at < all.size();) {
    base::Random random(seed_, kPieceStream + pieces_++);
    const size_t size =
        1 + random.NextBelow(static_cast<uint32_t>(faults.split_bytes));
    writes.push_back(all.substr(at, size));
    at += size;
  }
  return writes;
}

}  // namespace treeline::emulators
