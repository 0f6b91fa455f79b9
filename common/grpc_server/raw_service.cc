#include "common/grpc_server/raw_service.h"

#include <grpcpp/impl/codegen/server_callback_handlers.h>
#include <grpcpp/impl/rpc_service_method.h>

#include <utility>

namespace treeline::grpc_server {

void RawService::AddRawMethod(std::string path, MakeReactor make) {
  const int index = static_cast<int>(paths_.size());
  paths_.push_back(std::make_unique<std::string>(std::move(path)));
  AddMethod(new grpc::internal::RpcServiceMethod(
      paths_.back()->c_str(), grpc::internal::RpcMethod::BIDI_STREAMING,
      nullptr));
  MarkMethodRawCallback(
      index, new grpc::internal::CallbackBidiHandler<grpc::ByteBuffer,
                                                     grpc::ByteBuffer>(
                 std::move(make)));
}

}  // namespace treeline::grpc_server
