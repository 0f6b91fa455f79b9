#include "common/image/rvl.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/base/status_macros.h"
#include "common/image/png_reader.h"

namespace treeline::image {
namespace {

constexpr size_t kHeaderBytes = 8;
// A number of more nibbles is none of 32 bits.
constexpr int kMaxNibbles = 11;
constexpr int kNibblesInWord = 8;

uint32_t WordAt(absl::string_view bytes, size_t at) {
  uint32_t word = 0;
  for (size_t i = 0; i < 4; ++i) {
    word |= uint32_t{static_cast<uint8_t>(bytes[at + i])} << (8 * i);
  }
  return word;
}

class NibbleReader {
 public:
  explicit NibbleReader(absl::string_view words) : words_(words) {}

  // False: the words end, or the number is too long.
  bool Next(uint32_t& number) {
    number = 0;
    for (int i = 0; i < kMaxNibbles; ++i) {
      if (left_in_word_ == 0) {
        if (words_.size() - at_ < 4) return false;
        word_ = WordAt(words_, at_);
        at_ += 4;
        left_in_word_ = kNibblesInWord;
      }
      const uint32_t nibble = word_ >> 28;
      word_ <<= 4;
      --left_in_word_;
      number |= (nibble & 7U) << (3 * i);
      if ((nibble & 8U) == 0) return true;
    }
    return false;
  }

 private:
  absl::string_view words_;
  size_t at_ = 0;
  uint32_t word_ = 0;
  int left_in_word_ = 0;
};

absl::Status Broken() {
  return absl::InvalidArgumentError("RVL depth is cut off or broken");
}

}  // namespace

absl::StatusOr<DepthImage> DecodeRvl(absl::string_view bytes, double unit_m,
                                     const DecodeLimits& limits) {
  if (bytes.size() < kHeaderBytes) return Broken();
  const uint32_t width = WordAt(bytes, 0);
  const uint32_t height = WordAt(bytes, 4);
  TL_RETURN_IF_ERROR(CheckSize("RVL depth", width, height, limits));
  DepthImage depth{.width = static_cast<int>(width),
                   .height = static_cast<int>(height),
                   .values = {},
                   .unit_m = unit_m};
  const size_t count = size_t{width} * height;
  depth.values.assign(count, 0);
  NibbleReader reader(bytes.substr(kHeaderBytes));
  size_t at = 0;
  uint16_t value = 0;
  while (at < count) {
    uint32_t zeros = 0;
    uint32_t measured = 0;
    if (!reader.Next(zeros) || zeros > count - at) return Broken();
    at += zeros;
    if (!reader.Next(measured) || measured > count - at) return Broken();
    for (; measured > 0; --measured) {
      uint32_t folded = 0;
      if (!reader.Next(folded)) return Broken();
      // 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...
      const uint32_t difference = (folded >> 1) ^ (~(folded & 1U) + 1U);
      value = static_cast<uint16_t>(value + difference);
      depth.values[at++] = value;
    }
  }
  return depth;
}

}  // namespace treeline::image
