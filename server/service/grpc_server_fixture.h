// For tests: the service over a real loopback connection.
#ifndef SERVER_SERVICE_GRPC_SERVER_FIXTURE_H_
#define SERVER_SERVICE_GRPC_SERVER_FIXTURE_H_

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "server/service/access_policy.h"
#include "server/service/grpc_server.h"
#include "server/service/service_dispatcher.h"
#include "server/service/service_test_util.h"
#include "treeline/v1/relocalization.grpc.pb.h"

namespace treeline::service {

inline std::string StringOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  if (!buffer.Dump(&slices).ok()) return "";
  std::string text;
  for (const grpc::Slice& slice : slices) {
    text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return text;
}

class GrpcServerTest : public testing::Test {
 protected:
  GrpcServerTest()
      : scenes_({{"kitchen", [](auto&, auto&) { return LocalizedEstimate(); }},
                 {"gate", [this](auto&, auto&) { return PassGate(); }},
                 {"patient", [this](auto&, auto& o) { return WaitForStop(o); }},
                 {"throws",
                  [](auto&, auto&) -> absl::StatusOr<localizer::PoseEstimate> {
                    throw std::runtime_error("secret of the house");
                  }}},
                /*keep_files=*/true) {}

  // Who is let in; may be replaced before the server starts.
  void UseAccess(AccessPolicy& access) { policy_ = &access; }

  void StartServer(const DispatcherOptions& dispatcher = {.workers = 1,
                                                          .queue = 1},
                   GrpcServerOptions options = {}) {
    dispatcher_.emplace(scenes_.repository(), *policy_, observer_, clock_,
                        dispatcher);
    options.listen = "127.0.0.1:0";
    auto server =
        GrpcServer::Start(*dispatcher_, scenes_.repository(), options, clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    channel_ = grpc::CreateChannel(server_->address(),
                                   grpc::InsecureChannelCredentials());
    stub_ = v1::RelocalizationService::NewStub(channel_);
  }

  // Returns when the test opens the gate; says when it got there.
  localizer::PoseEstimate PassGate() {
    at_gate_.Notify();
    gate_.WaitForNotification();
    return LocalizedEstimate();
  }

  // Returns when the call is stopped, as a real localizer does.
  absl::StatusOr<localizer::PoseEstimate> WaitForStop(
      const localizer::LocalizeOptions& options) {
    at_gate_.Notify();
    absl::Notification stopped;
    const std::stop_callback on_stop(options.stop, [&] { stopped.Notify(); });
    stopped.WaitForNotification();
    return absl::CancelledError("stopped");
  }

  grpc::Status Localize(const std::string& scene,
                        v1::LocalizeResponse* response = nullptr) {
    grpc::ClientContext context;
    v1::LocalizeResponse ignored;
    return stub_->Localize(&context, TestRequest(scene),
                           response != nullptr ? response : &ignored);
  }

  // Method of a service for which Debian ships no stubs, on raw bytes.
  grpc::Status CallRaw(const std::string& method, const std::string& request,
                       std::string* response) {
    grpc::GenericStub stub(channel_);
    grpc::ClientContext context;
    const grpc::Slice slice(request);
    const grpc::ByteBuffer in(&slice, 1);
    grpc::ByteBuffer out;
    grpc::Status result;
    absl::Notification done;
    stub.UnaryCall(&context, method, grpc::StubOptions(), &in, &out,
                   [&](grpc::Status status) {
                     result = std::move(status);
                     done.Notify();
                   });
    done.WaitForNotification();
    *response = StringOf(out);
    return result;
  }

  absl::Notification at_gate_;
  absl::Notification gate_;
  FakeScenes scenes_;
  RecordingObserver observer_;
  OpenAccess access_;
  AccessPolicy* policy_ = &access_;
  base::SteadyClock clock_;
  std::optional<ServiceDispatcher> dispatcher_;
  std::unique_ptr<GrpcServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::RelocalizationService::Stub> stub_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_GRPC_SERVER_FIXTURE_H_
