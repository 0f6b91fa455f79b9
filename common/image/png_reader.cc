#include "common/image/png_reader.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::image {
namespace {

// What text and colour profiles in a small PNG may unpack to.
constexpr size_t kMinPngChunkLimit = 16u << 20;
// Deflate never packs more tightly than this: a larger picture is cut off, and
// found out before memory is asked for.
constexpr uint64_t kMaxPngExpansion = 1032;

absl::Status PngError(absl::string_view bytes, int code) {
  if (code == SPNG_EMEM) {
    return absl::ResourceExhaustedError("no memory to decode a PNG image");
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "PNG image of ", bytes.size(),
      " bytes: ", code == SPNG_IO_EOF ? "truncated" : spng_strerror(code)));
}

}  // namespace

absl::Status CheckSize(absl::string_view what, int64_t width, int64_t height,
                       const DecodeLimits& limits) {
  if (width < 1 || height < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(what, " has no pixels: ", width, " x ", height));
  }
  if (width > limits.max_width || height > limits.max_height ||
      width > limits.max_pixels / height) {
    return absl::InvalidArgumentError(
        absl::StrCat(what, " of ", width, " x ", height,
                     " pixels is over the limit of ", limits.max_width, " x ",
                     limits.max_height, " and ", limits.max_pixels, " pixels"));
  }
  return absl::OkStatus();
}

absl::StatusOr<SpngContext> OpenPng(absl::string_view bytes,
                                    const DecodeLimits& limits,
                                    spng_ihdr& header) {
  // Chunks carry a CRC; the Adler sum inside would check the same twice.
  SpngContext context(spng_ctx_new(SPNG_CTX_IGNORE_ADLER32));
  if (context == nullptr) return PngError(bytes, SPNG_EMEM);
  const size_t chunk_limit = std::max(kMinPngChunkLimit, bytes.size());
  int code = spng_set_chunk_limits(context.get(), chunk_limit, chunk_limit);
  if (code == 0) {
    code = spng_set_png_buffer(context.get(), bytes.data(), bytes.size());
  }
  if (code == 0) code = spng_get_ihdr(context.get(), &header);
  if (code != 0) return PngError(bytes, code);
  TL_RETURN_IF_ERROR(
      CheckSize("PNG image", header.width, header.height, limits));
  if (uint64_t{header.width} * header.height * header.bit_depth / 8 >
      kMaxPngExpansion * bytes.size()) {
    return PngError(bytes, SPNG_IO_EOF);
  }
  return context;
}

absl::Status DecodePng(absl::string_view bytes, spng_ctx* context,
                       spng_format format, void* out, size_t out_bytes) {
  size_t needed = 0;
  int code = spng_decoded_image_size(context, format, &needed);
  if (code == 0 && needed != out_bytes) {
    return absl::InternalError("PNG decoder disagrees about the image size");
  }
  if (code == 0) code = spng_decode_image(context, out, out_bytes, format, 0);
  if (code == 0) code = spng_decode_chunks(context);
  return code == 0 ? absl::OkStatus() : PngError(bytes, code);
}

}  // namespace treeline::image
