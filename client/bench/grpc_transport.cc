#include "client/bench/grpc_transport.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <utility>

#include "client/bench/call_context.h"
#include "common/wire/status.h"

namespace treeline::bench {
namespace {

constexpr char kMethod[] = "/treeline.v1.RelocalizationService/Localize";
constexpr char kPushback[] = "grpc-retry-pushback-ms";

// gRPC's callback and whoever cancels share it.
struct Call : Transport::PendingCall {
  void Cancel() override { context.Cancel(); }

  CallContext context;
  grpc::ByteBuffer response;
};

void Finish(Call& call, const grpc::Status& status,
            const Transport::Done& done) {
  v1::LocalizeResponse response;
  Reply reply{.status = wire::FromGrpc(status),
              .pushback = call.context->GetServerTrailingMetadata().contains(
                  kPushback)};
  if (status.ok()) {
    reply.status = wire::FromGrpc(
        grpc::SerializationTraits<v1::LocalizeResponse>::Deserialize(
            &call.response, &response));
    if (reply.status.ok()) reply.response = &response;
  }
  call.context.Release();
  done(reply);
}

class GrpcTransport final : public Transport {
 public:
  GrpcTransport(const std::vector<relocalizer::Connection>& connections,
                const std::vector<WorkItem>& items)
      : connections_(connections), items_(items) {
    for (const relocalizer::Connection& connection : connections_) {
      stubs_.push_back(
          std::make_unique<grpc::GenericStub>(connection.channel()));
    }
  }

  std::shared_ptr<PendingCall> Ask(size_t number, size_t item,
                                   std::chrono::nanoseconds timeout,
                                   Done done) override {
    auto call = std::make_shared<Call>();
    const size_t connection = number % connections_.size();
    connections_[connection].Prepare(*call->context, items_[item].scene);
    call->context->set_deadline(
        std::chrono::system_clock::now() +
        std::chrono::duration_cast<std::chrono::system_clock::duration>(
            timeout));
    stubs_[connection]->UnaryCall(
        call->context.get(), kMethod, {}, &items_[item].request,
        &call->response,
        [call, done = std::move(done)](const grpc::Status& status) {
          Finish(*call, status, done);
        });
    return call;
  }

 private:
  const std::vector<relocalizer::Connection> connections_;
  const std::vector<WorkItem>& items_;
  std::vector<std::unique_ptr<grpc::GenericStub>> stubs_;
};

}  // namespace

std::unique_ptr<Transport> MakeGrpcTransport(
    const std::vector<relocalizer::Connection>& connections,
    const std::vector<WorkItem>& items) {
  return std::make_unique<GrpcTransport>(connections, items);
}

}  // namespace treeline::bench
