// A gRPC service whose messages are bytes and are read when we say so.
#ifndef COMMON_GRPC_SERVER_RAW_SERVICE_H_
#define COMMON_GRPC_SERVER_RAW_SERVICE_H_

#include <grpcpp/impl/service_type.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace treeline::grpc_server {

using RawReactor = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;

// What protoc generates reads, inflates and parses the request of a unary call
// before it tells anyone that there is a call. Here every method is a stream to
// gRPC, which on the wire is the same: the reactor sees the metadata first, and
// nothing is read until it asks.
class RawService : public grpc::Service {
 public:
  using MakeReactor = std::function<RawReactor*(grpc::CallbackServerContext*)>;

 protected:
  // "/treeline.v1.SceneService/GetScene". Before the server is built.
  void AddRawMethod(std::string path, MakeReactor make);

 private:
  // gRPC keeps pointers to them.
  std::vector<std::unique_ptr<std::string>> paths_;
};

}  // namespace treeline::grpc_server

#endif  // COMMON_GRPC_SERVER_RAW_SERVICE_H_
