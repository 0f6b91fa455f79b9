// LocalizeStream over gRPC.
#ifndef CLIENT_RELOCALIZER_GRPC_LOCALIZE_STREAM_H_
#define CLIENT_RELOCALIZER_GRPC_LOCALIZE_STREAM_H_

#include <memory>

#include "client/relocalizer/channel.h"
#include "client/relocalizer/relocalizer.h"
#include "treeline/v1/relocalization.grpc.pb.h"

namespace treeline::relocalizer {

// `stub` is used until the call has returned; the connection is kept.
std::unique_ptr<LocalizeStream> OpenGrpcStream(
    const Connection& connection, v1::RelocalizationService::Stub& stub,
    const StreamOptions& options);

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_GRPC_LOCALIZE_STREAM_H_
