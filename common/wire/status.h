// absl::Status <-> grpc::Status: the same codes, two types.
#ifndef COMMON_WIRE_STATUS_H_
#define COMMON_WIRE_STATUS_H_

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace treeline {

// Messages are cut to this many bytes: they travel in the trailing metadata,
// which peers bound at 8 KiB.
inline constexpr size_t kMaxStatusMessageBytes = 1024;

grpc::Status ToGrpc(const absl::Status& status);

// A code outside the 17 that exist becomes UNKNOWN.
absl::Status FromGrpc(const grpc::Status& status);

}  // namespace treeline

#endif  // COMMON_WIRE_STATUS_H_
