// Messages of gRPC as bytes: what came is looked at before it is parsed.
#ifndef SERVER_SERVICE_GRPC_MESSAGE_H_
#define SERVER_SERVICE_GRPC_MESSAGE_H_

#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

#include "absl/status/status.h"
#include "common/base/byte_budget.h"

namespace treeline::service {

// Parses what has arrived, and frees it, unless there is no memory. `lease`
// holds both while both are there, then the message. INVALID_ARGUMENT: see
// wire::CheckMessageShape. UNAVAILABLE with reason OVERLOADED and a time to
// retry: there is no memory for it.
absl::Status TakeMessage(grpc::ByteBuffer& bytes, base::ByteLease& lease,
                         google::protobuf::Message& message);

grpc::ByteBuffer BytesOf(const google::protobuf::Message& message);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_GRPC_MESSAGE_H_
