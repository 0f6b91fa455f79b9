// How chunks are packed.
#ifndef COMMON_MCAP_MCAP_COMPRESSION_H_
#define COMMON_MCAP_MCAP_COMPRESSION_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::mcap {

enum class Compression : uint8_t { kNone, kLz4, kZstd };

// "", "lz4" or "zstd", as chunks name it.
absl::string_view CompressionName(Compression compression);
// INVALID_ARGUMENT for any other.
absl::StatusOr<Compression> ParseCompression(absl::string_view name);

// INTERNAL: the library failed, which no input makes it do.
absl::StatusOr<std::string> Compress(Compression compression,
                                     absl::string_view bytes);
// DATA_LOSS unless it is exactly `size` bytes; no more are allocated.
absl::StatusOr<std::string> Decompress(Compression compression,
                                       absl::string_view bytes, size_t size);

uint32_t Crc32(absl::string_view bytes);

}  // namespace treeline::mcap

#endif  // COMMON_MCAP_MCAP_COMPRESSION_H_
