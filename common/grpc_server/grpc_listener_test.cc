#include "common/grpc_server/grpc_listener.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/health_check_service_interface.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "common/base/listen_address.h"

namespace treeline::grpc_server {
namespace {

using ::testing::HasSubstr;

void AddNothing(grpc::ServerBuilder& /*builder*/) {}

TEST(GrpcListener, TellsWhichPortItTook) {
  const auto listener =
      StartGrpcListener({.listen = "127.0.0.1:0"}, AddNothing);
  ASSERT_TRUE(listener.ok()) << listener.status();
  EXPECT_GT(base::ParseListenAddress(listener->address).value().port, 0);
  const auto channel = grpc::CreateChannel(listener->address,
                                           grpc::InsecureChannelCredentials());
  EXPECT_TRUE(channel->WaitForConnected(std::chrono::system_clock::now() +
                                        std::chrono::seconds(60)));
  EXPECT_NE(listener->server->GetHealthCheckService(), nullptr);
}

TEST(GrpcListener, DoesNotShareAPort) {
  const auto first = StartGrpcListener({.listen = "127.0.0.1:0"}, AddNothing);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = StartGrpcListener({.listen = first->address}, AddNothing);
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr(first->address));
}

TEST(GrpcListener, RefusesWhatIsNoAddress) {
  EXPECT_TRUE(absl::IsInvalidArgument(
      StartGrpcListener({.listen = "nowhere"}, AddNothing).status()));
}

}  // namespace
}  // namespace treeline::grpc_server
