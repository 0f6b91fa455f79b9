// PNG (ISO/IEC 15948), the part of it that plain 16-bit grey images need.
#include "common/image/depth_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <memory>
#include <new>
#include <span>
#include <string>

#include "absl/strings/match.h"
#include "common/image/png_unfilter.h"

namespace treeline::image {
namespace {

constexpr absl::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
constexpr size_t kChunkOverhead = 12;  // length, type, checksum
constexpr size_t kHeaderLength = 13;
// Bit depth 16, grey, and the only or plain ways to compress, filter and
// interlace.
constexpr absl::string_view kPlainHeaderEnd("\x10\0\0\0\0", 5);
constexpr int kCompressionLevel = 2;
constexpr size_t kPixelBytes = 2;
// Deflate never packs more tightly than this.
constexpr uint64_t kMaxExpansion = 1032;

struct Chunk {
  absl::string_view type;
  absl::string_view content;
};

uint32_t BigEndian32(absl::string_view bytes) {
  uint32_t value = 0;
  for (const char byte : bytes.substr(0, 4)) {
    value = (value << 8) | static_cast<uint8_t>(byte);
  }
  return value;
}

// Takes the next chunk off `rest`; nullopt if it is cut off or its checksum is
// wrong.
std::optional<Chunk> TakeChunk(absl::string_view& rest) {
  if (rest.size() < kChunkOverhead) return std::nullopt;
  const size_t length = BigEndian32(rest);
  if (length > rest.size() - kChunkOverhead) return std::nullopt;
  const absl::string_view checked = rest.substr(4, 4 + length);
  const uint32_t checksum = BigEndian32(rest.substr(8 + length));
  if (libdeflate_crc32(0, checked.data(), checked.size()) != checksum) {
    return std::nullopt;
  }
  rest.remove_prefix(kChunkOverhead + length);
  return Chunk{checked.substr(0, 4), checked.substr(4)};
}

// The compressed pixels, as they stand in the file's IDAT chunks. `joined`
// keeps them if there are several.
std::optional<absl::string_view> TakePixels(absl::string_view rest,
                                            std::string& joined) {
  absl::string_view pixels;
  bool is_over = false;
  while (true) {
    const std::optional<Chunk> chunk = TakeChunk(rest);
    if (!chunk.has_value()) return std::nullopt;
    if (chunk->type == "IEND") break;
    if (chunk->type == "IDAT") {
      if (is_over) return std::nullopt;
      if (pixels.empty()) {
        pixels = chunk->content;
        continue;
      }
      if (joined.empty()) joined.assign(pixels.data(), pixels.size());
      joined.append(chunk->content.data(), chunk->content.size());
      pixels = joined;
      continue;
    }
    is_over = !pixels.empty();
    // A lower-case letter first: ancillary, may be skipped.
    if ((chunk->type[0] & 0x20) == 0) return std::nullopt;
  }
  return pixels;
}

// Exactly as many bytes as there is room for.
bool Inflate(absl::string_view pixels, std::span<uint8_t> rows) {
  const std::unique_ptr<libdeflate_decompressor,
                        decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(),
                   &libdeflate_free_decompressor);
  return decompressor != nullptr &&
         libdeflate_zlib_decompress(decompressor.get(), pixels.data(),
                                    pixels.size(), rows.data(), rows.size(),
                                    nullptr) == LIBDEFLATE_SUCCESS;
}

void AppendBigEndian32(uint32_t value, std::string& out) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    out.push_back(static_cast<char>(value >> shift));
  }
}

void AppendChunk(absl::string_view type, absl::string_view content,
                 std::string& png) {
  AppendBigEndian32(static_cast<uint32_t>(content.size()), png);
  const size_t checked_at = png.size();
  png.append(type.data(), type.size());
  png.append(content.data(), content.size());
  AppendBigEndian32(
      libdeflate_crc32(0, png.data() + checked_at, png.size() - checked_at),
      png);
}

std::string Deflate(absl::string_view bytes) {
  const std::unique_ptr<libdeflate_compressor,
                        decltype(&libdeflate_free_compressor)>
      compressor(libdeflate_alloc_compressor(kCompressionLevel),
                 &libdeflate_free_compressor);
  if (compressor == nullptr) throw std::bad_alloc();
  std::string out(
      libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
  out.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(),
                                      bytes.size(), out.data(), out.size()));
  return out;
}

}  // namespace

std::optional<PlainDepthPng> DecodePlainDepthPng(absl::string_view bytes,
                                                 int64_t max_pixels) {
  if (!absl::StartsWith(bytes, kSignature)) return std::nullopt;
  bytes.remove_prefix(kSignature.size());
  const std::optional<Chunk> header = TakeChunk(bytes);
  if (!header.has_value() || header->type != "IHDR" ||
      header->content.size() != kHeaderLength ||
      header->content.substr(8) != kPlainHeaderEnd) {
    return std::nullopt;
  }
  const uint64_t width = BigEndian32(header->content);
  const uint64_t height = BigEndian32(header->content.substr(4));
  if (width == 0 || height == 0 ||
      width > static_cast<uint64_t>(max_pixels) / height) {
    return std::nullopt;
  }
  std::string joined;
  const std::optional<absl::string_view> pixels = TakePixels(bytes, joined);
  const size_t row_bytes = FilteredRowBytes(width);
  if (!pixels.has_value() ||
      row_bytes * height > kMaxExpansion * pixels->size()) {
    return std::nullopt;
  }
  const size_t filtered_bytes = row_bytes * height;
  const auto rows = std::make_unique_for_overwrite<uint8_t[]>(
      filtered_bytes + kUnfilterPadding_bytes);
  std::fill_n(rows.get() + filtered_bytes, kUnfilterPadding_bytes, uint8_t{0});
  if (!Inflate(*pixels, {rows.get(), filtered_bytes})) return std::nullopt;

  PlainDepthPng image{.width = static_cast<int>(width),
                      .height = static_cast<int>(height),
                      .values = {}};
  image.values.resize(width * height);
  if (!UnfilterGray16({rows.get(), filtered_bytes}, width, height,
                      image.values)) {
    return std::nullopt;
  }
  return image;
}

std::string EncodePlainDepthPng(int width, int height,
                                std::span<const uint16_t> values) {
  const size_t row_values = static_cast<size_t>(width);
  std::string rows;
  rows.reserve(static_cast<size_t>(height) * (1 + kPixelBytes * row_values));
  for (size_t i = 0; i < values.size(); ++i) {
    if (i % row_values == 0) rows.push_back(0);
    rows.push_back(static_cast<char>(values[i] >> 8));
    rows.push_back(static_cast<char>(values[i] & 255));
  }
  std::string png(kSignature.data(), kSignature.size());
  std::string header;
  AppendBigEndian32(static_cast<uint32_t>(width), header);
  AppendBigEndian32(static_cast<uint32_t>(height), header);
  header.append(kPlainHeaderEnd.data(), kPlainHeaderEnd.size());
  AppendChunk("IHDR", header, png);
  AppendChunk("IDAT", Deflate(rows), png);
  AppendChunk("IEND", "", png);
  return png;
}

}  // namespace treeline::image
