// gzip, by zlib.
#ifndef NAV_AGENT_RECORDING_GUNZIP_H_
#define NAV_AGENT_RECORDING_GUNZIP_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::recording {

bool IsGzip(absl::string_view bytes);

// What was compressed. DATA_LOSS if the bytes are broken or end early;
// RESOURCE_EXHAUSTED if there is more than max_bytes.
absl::StatusOr<std::string> Gunzip(absl::string_view bytes, size_t max_bytes);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_GUNZIP_H_
