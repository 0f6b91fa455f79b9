// LZFSE, the compression of Apple's phones, as Record3D uses it.
//
// A stream is a sequence of blocks, each of which copies literals and earlier
// output; lengths, distances and literals are coded with finite state entropy
// (J. Duda, Asymmetric numeral systems). The format is defined by Apple's
// published implementation (github.com/lzfse/lzfse: lzfse_internal.h for the
// headers and tables, lzfse_decode_base.c for their order). No package of
// Debian 12 decodes it. Blocks of the kinds that its encoder writes for more
// than 4 KiB are read: compressed with compressed tables ("bvx2"), and raw
// ("bvx-").
#ifndef SERVER_TOOLS_CAPTURE_LZFSE_H_
#define SERVER_TOOLS_CAPTURE_LZFSE_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::capture {

// The `size` bytes that `stream` holds. INVALID_ARGUMENT: it is no such stream,
// is damaged, or holds another number of bytes. Allocates no more than `size`
// and a constant. Safe on hostile bytes.
absl::StatusOr<std::vector<uint8_t>> DecodeLzfse(absl::string_view stream,
                                                 size_t size);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_LZFSE_H_
