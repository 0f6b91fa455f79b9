#include "common/grpc_server/call_counter.h"

#include <grpcpp/support/server_interceptor.h>

#include <string>
#include <utility>
#include <vector>

namespace treeline::grpc_server {
namespace {

using flood_guard::FloodGuard;

// Lives as long as its call, and touches nothing of it.
class OpenCall final : public grpc::experimental::Interceptor {
 public:
  OpenCall(std::shared_ptr<FloodGuard> guard, std::string address)
      : guard_(std::move(guard)), address_(std::move(address)) {
    guard_->BeginCall(address_);
  }
  ~OpenCall() override { guard_->EndCall(address_); }

  void Intercept(
      grpc::experimental::InterceptorBatchMethods* methods) override {
    methods->Proceed();
  }

 private:
  const std::shared_ptr<FloodGuard> guard_;
  const std::string address_;
};

class OpenCalls final
    : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit OpenCalls(std::shared_ptr<FloodGuard> guard)
      : guard_(std::move(guard)) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    return new OpenCall(
        guard_, flood_guard::AddressKeyOfPeer(info->server_context()->peer()));
  }

 private:
  const std::shared_ptr<FloodGuard> guard_;
};

}  // namespace

void CountCalls(std::shared_ptr<FloodGuard> guard,
                grpc::ServerBuilder& builder) {
  std::vector<
      std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
      factories;
  factories.push_back(std::make_unique<OpenCalls>(std::move(guard)));
  builder.experimental().SetInterceptorCreators(std::move(factories));
}

}  // namespace treeline::grpc_server
