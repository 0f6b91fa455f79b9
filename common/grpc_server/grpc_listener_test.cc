#include "common/grpc_server/grpc_listener.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/impl/server_builder_plugin.h>
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <memory>
#include <string>

#include "common/base/listen_address.h"

namespace treeline::grpc_server {
namespace {

using ::testing::HasSubstr;

class GrpcListenerTest : public ::testing::Test {
 protected:
  // With a service that knows no method: without any, gRPC does not start.
  absl::StatusOr<GrpcListener> Start(const GrpcListenerOptions& options) {
    grpc::CallbackGenericService& service = services_.emplace_back();
    return StartGrpcListener(options, [&](grpc::ServerBuilder& builder) {
      builder.RegisterCallbackGenericService(&service);
    });
  }

 private:
  std::deque<grpc::CallbackGenericService> services_;
};

TEST_F(GrpcListenerTest, TellsWhichPortItTook) {
  const auto listener = Start({.listen = "127.0.0.1:0"});
  ASSERT_TRUE(listener.ok()) << listener.status();
  EXPECT_GT(base::ParseListenAddress(listener->address).value().port, 0);
  const auto channel = grpc::CreateChannel(listener->address,
                                           grpc::InsecureChannelCredentials());
  EXPECT_TRUE(channel->WaitForConnected(std::chrono::system_clock::now() +
                                        std::chrono::seconds(60)));
  EXPECT_NE(listener->server->GetHealthCheckService(), nullptr);
}

TEST_F(GrpcListenerTest, DoesNotShareAPort) {
  const auto first = Start({.listen = "127.0.0.1:0"});
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = Start({.listen = first->address});
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr(first->address));
}

TEST_F(GrpcListenerTest, RefusesWhatIsNoAddress) {
  EXPECT_TRUE(absl::IsInvalidArgument(Start({.listen = "nowhere"}).status()));
}

// Counts the servers that have it.
class CountingPlugin final : public grpc::ServerBuilderPlugin {
 public:
  static void Enable() {
    ++enabled;
    grpc::ServerBuilder::InternalAddPluginFactory(
        []() -> std::unique_ptr<grpc::ServerBuilderPlugin> {
          return std::make_unique<CountingPlugin>();
        });
  }
  std::string name() override { return "counting"; }
  void InitServer(grpc::ServerInitializer* /*server*/) override { ++servers; }
  void Finish(grpc::ServerInitializer* /*server*/) override {}
  void ChangeArguments(const std::string& /*name*/, void* /*value*/) override {}

  inline static int enabled = 0;
  inline static int servers = 0;
};

TEST_F(GrpcListenerTest, HasThePluginsThatItNamesAlone) {
  for (int i = 1; i <= 2; ++i) {
    ASSERT_TRUE(Start({.listen = "127.0.0.1:0",
                       .plugins = {{"counting", &CountingPlugin::Enable}}})
                    .ok());
    EXPECT_EQ(CountingPlugin::servers, i);
    ASSERT_TRUE(Start({.listen = "127.0.0.1:0"}).ok());
    EXPECT_EQ(CountingPlugin::servers, i);
  }
  EXPECT_EQ(CountingPlugin::enabled, 1);
}

// Also where another listener of the process has it.
TEST_F(GrpcListenerTest, HasNoHealthServiceWhereItIsNotWanted) {
  const auto with = Start({.listen = "127.0.0.1:0"});
  const auto without =
      Start({.listen = "127.0.0.1:0", .default_health = false});
  ASSERT_TRUE(without.ok()) << without.status();
  EXPECT_EQ(without->server->GetHealthCheckService(), nullptr);
}

}  // namespace
}  // namespace treeline::grpc_server
