// Undoes the filters of a PNG's rows, many rows at once.
#ifndef COMMON_IMAGE_PNG_UNFILTER_H_
#define COMMON_IMAGE_PNG_UNFILTER_H_

#include <cstddef>
#include <cstdint>
#include <span>

namespace treeline::image {

// A row of `width` 16-bit grey pixels as it is inflated: its filter and the
// filtered bytes, the high one of each pixel first.
constexpr size_t FilteredRowBytes(size_t width) { return 1 + 2 * width; }

// Readable bytes that must follow the last row.
inline constexpr size_t kUnfilterPadding_bytes = 64;

// Undoes the filters of `height` rows (ISO/IEC 15948, chapter 9), which
// stand one after the other in `rows` and are followed by
// kUnfilterPadding_bytes. values: width * height of them, host byte order.
// False, and values are not defined, for a filter that does not exist.
//
// A pixel depends on its left neighbour, so a row alone is one long chain of
// steps. Sixteen rows are undone side by side, each a pixel behind the one
// above it: what a pixel depends on is known one step before.
bool UnfilterGray16(std::span<const uint8_t> rows, size_t width, size_t height,
                    std::span<uint16_t> values);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_PNG_UNFILTER_H_
