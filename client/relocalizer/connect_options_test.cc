#include "client/relocalizer/connect_options.h"

#include "client/relocalizer/grpc_relocalizer.h"
#include "client/relocalizer/relocalizer.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::relocalizer {
namespace {

using ::testing::HasSubstr;

std::string Refusal(const ConnectOptions& options) {
  const absl::Status status = options.Validate();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  return std::string(status.message());
}

TEST(ConnectOptions, OutOfRangeIsRefused) {
  EXPECT_THAT(Refusal({}), HasSubstr("no server"));
  EXPECT_THAT(Refusal({.server = "x:1", .max_attempts = 0}),
              HasSubstr("max_attempts"));
  EXPECT_THAT(Refusal({.server = "x:1", .max_attempts = 6}),
              HasSubstr("max_attempts"));
  EXPECT_THAT(Refusal({.server = "x:1", .max_message_mib = 0}),
              HasSubstr("max_message_mib"));
  EXPECT_EQ(ConnectRelocalizer({}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(ConnectOptions, ListsBecomeTargetsOfTheirFamily) {
  EXPECT_EQ(GrpcTarget("robot:1").value(), "robot:1");
  EXPECT_EQ(GrpcTarget("dns:///robot:1").value(), "dns:///robot:1");
  EXPECT_EQ(GrpcTarget("127.0.0.1:1,10.0.0.2:2").value(),
            "ipv4:127.0.0.1:1,10.0.0.2:2");
  EXPECT_EQ(GrpcTarget("[::1]:1,[::2]:2").value(), "ipv6:[::1]:1,[::2]:2");
}

TEST(ConnectOptions, ListsOfWhatAreNoAddressesAreRefused) {
  EXPECT_THAT(Refusal({.server = "a:1,b:2"}), HasSubstr("dns:///"));
  EXPECT_THAT(Refusal({.server = "127.0.0.1:1,[::1]:2"}), HasSubstr("[::1]:2"));
  EXPECT_THAT(Refusal({.server = "127.0.0.1:1,127.0.0.1"}),
              HasSubstr("no port"));
  EXPECT_THAT(Refusal({.server = "127.0.0.1:1,127.0.0.1:0"}),
              HasSubstr("no port"));
  EXPECT_THAT(Refusal({.server = "127.0.0.1:1,"}), HasSubstr("no port"));
}

TEST(ConnectOptions, OneServerHasAPortAndIsNoWebAddress) {
  EXPECT_THAT(Refusal({.server = "127.0.0.1"}), HasSubstr("127.0.0.1:50051"));
  EXPECT_THAT(Refusal({.server = "robot:"}), HasSubstr("robot:50051"));
  EXPECT_THAT(Refusal({.server = "[::1]"}), HasSubstr("[::1]:50051"));
  EXPECT_THAT(Refusal({.server = "http://127.0.0.1:8080"}),
              HasSubstr("HOST:PORT"));
  EXPECT_THAT(Refusal({.server = "HTTPS://robot/"}), HasSubstr("web address"));
  for (const char* server : {"robot:1", "[::1]:1", "unix:/run/x", "unix:///x",
                             "dns:///robot", "ipv4:10.0.0.1:1"}) {
    EXPECT_TRUE(ConnectOptions{.server = server}.Validate().ok()) << server;
  }
}

TEST(ConnectOptions, KnowsThisMachine) {
  for (const char* server :
       {"127.0.0.1:1", "127.9.9.9:1,127.0.0.1:2", "localhost:1", "[::1]:1",
        "unix:/run/x", "dns:///localhost:1", "ipv4:127.0.0.1:1"}) {
    EXPECT_TRUE(IsOnThisMachine(server)) << server;
  }
  for (const char* server : {"10.0.0.1:1", "127.0.0.1:1,10.0.0.1:2", "robot:1",
                             "127.evil.org:1", "[::2]:1", "localhost.org:1",
                             "127.0.0.1:1@robot", "localhost:@robot"}) {
    EXPECT_FALSE(IsOnThisMachine(server)) << server;
  }
}

TEST(ConnectOptions, KnowsHostsOfUrls) {
  for (const char* host : {"127.0.0.1:80", "127.0.0.1", "localhost", "[::1]:80",
                           "[::1]", "127.9.9.9:1"}) {
    EXPECT_TRUE(IsUrlHostOnThisMachine(host)) << host;
  }
  // gRPC's names of this machine are hosts in a URL, or none.
  for (const char* host : {"robot", "robot.example:443", "unix:80", "dns:1"}) {
    EXPECT_TRUE(IsUrlHost(host)) << host;
    EXPECT_FALSE(IsUrlHostOnThisMachine(host)) << host;
  }
  for (const char* host :
       {"", ":80", "unix:", "unix:/run/x", "dns:///localhost:1",
        "ipv4:127.0.0.1:1", "127.0.0.1:80@robot", "127.0.0.1@robot",
        "127.0.0.1:1,127.0.0.1:2", "127.0.0.1?x", "127.0.0.1#x",
        "127.0.0.1\\@robot", "127.0.0.1:0", "[::1", "[robot]", "::1", "a b"}) {
    EXPECT_FALSE(IsUrlHost(host)) << host;
  }
}

TEST(ConnectOptions, TokensDoNotLeaveTheMachineInTheClear) {
  EXPECT_THAT(Refusal({.server = "robot:1", .token_file = "t"}),
              HasSubstr("in the clear"));
  EXPECT_THAT(Refusal({.server = "robot:1", .token_variable = "T"}),
              HasSubstr("in the clear"));
  EXPECT_TRUE(ConnectOptions({.server = "127.0.0.1:1", .token_file = "t"})
                  .Validate()
                  .ok());
  EXPECT_TRUE(ConnectOptions({.server = "robot:1",
                              .tls = {.ca_file = "ca.pem"},
                              .token_file = "t"})
                  .Validate()
                  .ok());
}

TEST(ConnectOptions, HalfACredentialIsRefused) {
  EXPECT_THAT(
      Refusal({.server = "x:1",
               .tls = {.ca_file = "ca.pem", .certificate_file = "c.pem"}}),
      HasSubstr("go together"));
  EXPECT_THAT(Refusal({.server = "x:1", .tls = {.server_name = "treeline"}}),
              HasSubstr("trusted"));
  EXPECT_THAT(
      Refusal(
          {.server = "127.0.0.1:1", .token_file = "t", .token_variable = "T"}),
      HasSubstr("two tokens"));
}

}  // namespace
}  // namespace treeline::relocalizer
