// Who is told of a call's end may close its connection at once: gRPC must not
// be left to do that on a thread of its own.
#include "client/bench/grpc_transport.h"

#include <grpcpp/channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "client/bench/stream_client.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

constexpr std::chrono::seconds kTimeout(60);

class GrpcTransportTest : public testing::Test {
 protected:
  GrpcTransportTest() {
    const grpc::Slice bytes(std::string(4, 'q'));
    items_.push_back({.scene = "room",
                      .stem = "",
                      .encoding = "",
                      .request = grpc::ByteBuffer(&bytes, 1),
                      .world_from_camera = {}});
    // Nobody listens at port 1: calls end with UNAVAILABLE.
    connections_.push_back(
        relocalizer::Connection::Open({.server = "127.0.0.1:1",
                                       .max_attempts = 1,
                                       .own_connections = true})
            .value());
    channel_ = connections_[0].channel();
  }

  // Waits until the call has been begun: until then the thread that begins it
  // may hold the channel, too.
  void CountOwners() {
    begun_.WaitForNotification();
    owners_at_end_ = channel_.use_count();
  }

  std::vector<WorkItem> items_;
  std::vector<relocalizer::Connection> connections_;
  std::weak_ptr<grpc::Channel> channel_;
  absl::Notification begun_;
  long owners_at_end_ = 0;  // NOLINT(google-runtime-int): use_count's type
};

TEST_F(GrpcTransportTest, ACallThatHasEndedDoesNotHoldItsChannel) {
  const std::unique_ptr<Transport> transport =
      MakeGrpcTransport(connections_, items_);
  const auto owners = channel_.use_count();
  const auto told = std::make_shared<absl::Notification>();
  absl::Status status;
  const std::shared_ptr<Transport::PendingCall> call =
      transport->Ask(0, 0, kTimeout, [&, told](const Reply& reply) {
        CountOwners();
        status = reply.status;
        told->Notify();
      });
  begun_.Notify();
  told->WaitForNotification();
  EXPECT_EQ(owners_at_end_, owners);
  call->Cancel();  // too late, and harmless
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
}

TEST_F(GrpcTransportTest, AStreamThatHasEndedDoesNotHoldItsChannel) {
  grpc::GenericStub stub(connections_[0].channel());
  const auto owners = channel_.use_count();
  const auto told = std::make_shared<absl::Notification>();
  absl::Status status;
  StreamClient::Host host;
  host.next = [] { return std::optional<size_t>(0); };
  host.answer = [](const StreamClient::Frame&, const absl::Status&,
                   const v1::LocalizeResponse*) {};
  host.end = [&, told](StreamClient*, const absl::Status& ended) {
    CountOwners();
    status = ended;
    told->Notify();
  };
  // Deletes itself.
  (new StreamClient(connections_[0], stub, items_, 1, std::move(host)))
      ->Start();
  begun_.Notify();
  told->WaitForNotification();
  EXPECT_EQ(owners_at_end_, owners);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
}

}  // namespace
}  // namespace treeline::bench
