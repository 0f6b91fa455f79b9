#include "nav_agent/octomap/voxel_map.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace treeline::octree {
namespace {

constexpr int kWordBits = 64;

// Bits [begin, end) of a word, 0 <= begin < end <= 64.
uint64_t BitsBetween(int begin, int end) {
  const uint64_t up_to_end =
      end == kWordBits ? ~uint64_t{0} : (uint64_t{1} << end) - 1;
  return up_to_end & ~((uint64_t{1} << begin) - 1);
}

}  // namespace

absl::StatusOr<VoxelMap> VoxelMap::Make(double resolution_m, VoxelIndex lowest,
                                        VoxelIndex size, int64_t max_bytes) {
  if (!(resolution_m >= 1e-3 && resolution_m <= 10)) {
    return absl::InvalidArgumentError(
        absl::StrCat("a voxel of ", resolution_m, " m; 0.001 to 10 is usable"));
  }
  constexpr int kMaxSize = 1 << 16;
  if (std::min({size.x, size.y, size.z}) < 0 ||
      std::max({size.x, size.y, size.z}) > kMaxSize) {
    return absl::InvalidArgumentError(
        absl::StrCat("a map of ", size.x, " x ", size.y, " x ", size.z,
                     " voxels; 0 to ", kMaxSize, " each way are possible"));
  }
  const int words = (size.z + kWordBits - 1) / kWordBits;
  // At most 2^16 * 2^16 * 2^10 * 2^4: no overflow.
  const int64_t total = int64_t{size.x} * size.y * words;
  if (total * 2 * int64_t{sizeof(uint64_t)} > max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "its known space is ", size.x, " x ", size.y, " x ", size.z,
        " voxels, which would take more than ", max_bytes >> 20,
        " MiB; are there stray voxels far away?"));
  }
  VoxelMap map;
  map.resolution_m_ = resolution_m;
  map.lowest_ = lowest;
  map.size_ = size;
  map.words_ = words;
  map.occupied_.resize(static_cast<size_t>(total));
  map.known_.resize(static_cast<size_t>(total));
  return map;
}

Voxel VoxelMap::At(VoxelIndex v) const {
  if (!Contains(v)) return Voxel::kUnknown;
  const size_t word = Offset(v.x, v.y) + static_cast<size_t>(v.z / kWordBits);
  const uint64_t bit = uint64_t{1} << (v.z % kWordBits);
  if ((known_[word] & bit) == 0) return Voxel::kUnknown;
  return (occupied_[word] & bit) != 0 ? Voxel::kOccupied : Voxel::kFree;
}

void VoxelMap::SetRun(int x, int y, int begin_z, int end_z, Voxel value) {
  const size_t column = Offset(x, y);
  while (begin_z < end_z) {
    const int word = begin_z / kWordBits;
    const int end = std::min(end_z, (word + 1) * kWordBits);
    const uint64_t bits =
        BitsBetween(begin_z % kWordBits, end - word * kWordBits);
    const size_t at = column + static_cast<size_t>(word);
    if (value == Voxel::kUnknown) {
      known_[at] &= ~bits;
    } else {
      known_[at] |= bits;
    }
    if (value == Voxel::kOccupied) {
      occupied_[at] |= bits;
    } else {
      occupied_[at] &= ~bits;
    }
    begin_z = end;
  }
}

int64_t VoxelMap::CountOccupied() const {
  int64_t count = 0;
  for (const uint64_t word : occupied_) count += std::popcount(word);
  return count;
}

int64_t VoxelMap::CountFree() const {
  int64_t count = 0;
  for (const uint64_t word : known_) count += std::popcount(word);
  return count - CountOccupied();
}

VoxelIndex VoxelMap::IndexOf(geometry::Vec3 point_in_map) const {
  const auto index = [this](double value, int lowest) {
    // Clamped, so that far points do not overflow.
    const double voxel = std::floor(value / resolution_m_) - lowest;
    return static_cast<int>(std::clamp(voxel, -1e9, 1e9));
  };
  return {index(point_in_map.x, lowest_.x), index(point_in_map.y, lowest_.y),
          index(point_in_map.z, lowest_.z)};
}

geometry::Vec3 VoxelMap::CenterOf(VoxelIndex v) const {
  return resolution_m_ * geometry::Vec3{v.x + lowest_.x + 0.5,
                                        v.y + lowest_.y + 0.5,
                                        v.z + lowest_.z + 0.5};
}

}  // namespace treeline::octree
