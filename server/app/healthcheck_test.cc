#include "server/app/healthcheck.h"

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace treeline::server_app {
namespace {

TEST(Healthcheck, EncodesTheServiceAsField1) {
  EXPECT_EQ(EncodeHealthRequest(""), "");
  EXPECT_EQ(EncodeHealthRequest("scene/a"), "\x0a\x07scene/a");
  // Lengths over 127 take two bytes.
  const std::string long_name(300, 'x');
  EXPECT_EQ(EncodeHealthRequest(long_name), "\x0a\xac\x02" + long_name);
}

TEST(Healthcheck, DecodesTheStatus) {
  EXPECT_EQ(*DecodeHealthResponse(""), 0);
  EXPECT_EQ(*DecodeHealthResponse("\x08\x01"), 1);
  EXPECT_EQ(*DecodeHealthResponse("\x08\x02"), 2);
  // A field that came later is passed over.
  EXPECT_EQ(*DecodeHealthResponse("\x12\x02hi\x08\x01"), 1);
}

TEST(Healthcheck, OtherBytesAreNoAnswer) {
  EXPECT_FALSE(DecodeHealthResponse("\x08").ok());
  EXPECT_FALSE(DecodeHealthResponse("\x12\x7fhi").ok());
  EXPECT_FALSE(DecodeHealthResponse("\xff\xff\xff\xff\xff\xff").ok());
  EXPECT_FALSE(DecodeHealthResponse(std::string("\x00\x01", 2)).ok());
}

TEST(Healthcheck, NobodyThereIsUnhealthy) {
  // Port 1 of loopback: nothing listens there.
  const absl::Status status =
      CheckHealth({.server = "127.0.0.1:1", .timeout_s = 30});
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
}

TEST(Healthcheck, AsksTheServerAndNoProxyOfTheEnvironment) {
  grpc::EnableDefaultHealthCheckService(true);
  int port = 0;
  grpc::CallbackGenericService other_calls;
  grpc::ServerBuilder builder;
  builder.RegisterCallbackGenericService(&other_calls);
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(),
                           &port);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  ASSERT_NE(server, nullptr);
  server->GetHealthCheckService()->SetServingStatus(true);
  setenv("http_proxy", "http://127.0.0.1:1", 1);
  const absl::Status status = CheckHealth(
      {.server = absl::StrCat("127.0.0.1:", port), .timeout_s = 30});
  unsetenv("http_proxy");
  EXPECT_TRUE(status.ok()) << status;
}

TEST(Healthcheck, MissingFilesAreNamed) {
  const absl::Status status = CheckHealth({.tls_ca = "/nowhere/ca.pem"});
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
}

}  // namespace
}  // namespace treeline::server_app
