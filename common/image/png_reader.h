// PNG files by libspng, within the limits of decode.h. For the decoders of this
// folder.
#ifndef COMMON_IMAGE_PNG_READER_H_
#define COMMON_IMAGE_PNG_READER_H_

#include <spng.h>

#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"

namespace treeline::image {

struct SpngDeleter {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using SpngContext = std::unique_ptr<spng_ctx, SpngDeleter>;

// INVALID_ARGUMENT: `what` of this size has no pixels, or is over the limits.
absl::Status CheckSize(absl::string_view what, int64_t width, int64_t height,
                       const DecodeLimits& limits);

// Opens `bytes`, which must live on, and reads the header only.
absl::StatusOr<SpngContext> OpenPng(absl::string_view bytes,
                                    const DecodeLimits& limits,
                                    spng_ihdr& header);

// Decodes into `out`, and reads on to the end of the file.
absl::Status DecodePng(absl::string_view bytes, spng_ctx* context,
                       spng_format format, void* out, size_t out_bytes);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_PNG_READER_H_
