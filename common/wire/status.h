// absl::Status <-> grpc::Status and google.rpc.Status: the same codes and
// details in three types.
#ifndef COMMON_WIRE_STATUS_H_
#define COMMON_WIRE_STATUS_H_

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"

namespace treeline::wire {

// Messages are cut to this many bytes: they travel in the trailing metadata,
// which peers bound at 8 KiB.
inline constexpr size_t kMaxStatusMessageBytes = 1024;

// Reason and retry time (common/base/error_info.h) become the details
// google.rpc.ErrorInfo, of domain "treeline", and google.rpc.RetryInfo.
grpc::Status ToGrpc(const absl::Status& status);
google::rpc::Status ToProto(const absl::Status& status);

// A code outside the 17 that exist becomes UNKNOWN. Details that are not ours
// or do not parse are passed over.
absl::Status FromGrpc(const grpc::Status& status);
absl::Status FromProto(const google::rpc::Status& status);

}  // namespace treeline::wire

#endif  // COMMON_WIRE_STATUS_H_
