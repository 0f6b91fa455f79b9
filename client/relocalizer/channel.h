// A gRPC channel with the retries, credentials and checks of a Treeline client.
#ifndef CLIENT_RELOCALIZER_CHANNEL_H_
#define CLIENT_RELOCALIZER_CHANNEL_H_

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <memory>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/relocalizer/connect_options.h"
#include "client/relocalizer/token_source.h"

namespace treeline::relocalizer {

// Thread-safe.
class Connection {
 public:
  // Connects when it is first needed. INVALID_ARGUMENT: options; otherwise
  // what is wrong with a file of a certificate or a token.
  static absl::StatusOr<Connection> Open(const ConnectOptions& options);

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // Puts into a call's context what every call carries: the token; where
  // `scene` is a scene's name, the metadata x-treeline-scene, by which a
  // balancer can choose the server; and `traceparent`, if it is one.
  void Prepare(grpc::ClientContext& context, absl::string_view scene = {},
               absl::string_view traceparent = {}) const;

 private:
  Connection(std::shared_ptr<grpc::Channel> channel,
             std::shared_ptr<TokenSource> token);

  std::shared_ptr<grpc::Channel> channel_;
  std::shared_ptr<TokenSource> token_;  // null: none
};

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_CHANNEL_H_
