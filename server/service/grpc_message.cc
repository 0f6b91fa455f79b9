#include "server/service/grpc_message.h"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/proto_buffer_reader.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/wire/message_shape.h"

namespace treeline::service {

absl::Status TakeMessage(grpc::ByteBuffer& bytes, base::ByteLease& lease,
                         google::protobuf::Message& message) {
  const size_t size = bytes.Length();
  message.Clear();
  if (!lease.Resize(2 * size)) return base::NoMemoryForRequest();
  grpc::ByteBuffer taken;
  taken.Swap(&bytes);
  absl::Status status;
  {
    grpc::ProtoBufferReader to_check(&taken);
    status = wire::CheckMessageShape(to_check, *message.GetDescriptor());
  }
  if (status.ok()) {
    grpc::ProtoBufferReader to_parse(&taken);
    if (!message.ParseFromZeroCopyStream(&to_parse)) {
      status =
          base::WithReason(absl::InvalidArgumentError(absl::StrCat(
                               "the request is not a ", message.GetTypeName(),
                               " in protobuf's binary format")),
                           "INVALID_REQUEST");
    }
  }
  taken.Clear();
  lease.Resize(status.ok() ? size : 0);
  return status;
}

grpc::ByteBuffer BytesOf(const google::protobuf::Message& message) {
  const grpc::Slice slice(message.SerializeAsString());
  return grpc::ByteBuffer(&slice, 1);
}

}  // namespace treeline::service
