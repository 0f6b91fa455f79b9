// Relocalizer over gRPC.
#ifndef CLIENT_RELOCALIZER_GRPC_RELOCALIZER_H_
#define CLIENT_RELOCALIZER_GRPC_RELOCALIZER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "client/relocalizer/connect_options.h"
#include "client/relocalizer/relocalizer.h"

namespace treeline::relocalizer {

// A connection, made when it is first needed and again whenever it breaks; so
// that the server is not there yet is no error here. INVALID_ARGUMENT: options;
// otherwise what is wrong with a file of a certificate or a token.
absl::StatusOr<std::unique_ptr<Relocalizer>> ConnectRelocalizer(
    const ConnectOptions& options);

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_GRPC_RELOCALIZER_H_
