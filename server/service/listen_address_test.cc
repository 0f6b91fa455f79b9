#include "common/base/listen_address.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/grpc_server.h"

namespace treeline::service {
namespace {

using ::testing::HasSubstr;

TEST(ListenAddress, ParsesAndPrints) {
  for (const char* text :
       {"127.0.0.1:50051", "localhost:0", "[::1]:65535", "0.0.0.0:80"}) {
    const auto address = base::ParseListenAddress(text);
    ASSERT_TRUE(address.ok()) << address.status();
    EXPECT_EQ(address->ToString(), text);
  }
  EXPECT_EQ(base::ParseListenAddress("[::1]:7")->host, "::1");
  EXPECT_EQ(base::ParseListenAddress("[::1]:7")->port, 7);
}

TEST(ListenAddress, RefusesWhatIsNone) {
  for (const char* text :
       {"", "127.0.0.1", ":50051", "127.0.0.1:", "127.0.0.1:x",
        "127.0.0.1:65536", "127.0.0.1:-1", "::1:50051", "[::1:50051"}) {
    const auto address = base::ParseListenAddress(text);
    EXPECT_EQ(address.status().code(), absl::StatusCode::kInvalidArgument)
        << text;
    EXPECT_THAT(std::string(address.status().message()),
                HasSubstr("127.0.0.1:50051"))
        << text;
  }
}

TEST(ListenAddress, KnowsWhatOnlyThisMachineReaches) {
  for (const char* text :
       {"127.0.0.1:1", "127.8.9.10:1", "[::1]:1", "localhost:1"}) {
    EXPECT_TRUE(base::IsLoopback(*base::ParseListenAddress(text))) << text;
  }
  for (const char* text : {"0.0.0.0:1", "192.168.1.5:1", "[::]:1",
                           "[fe80::1]:1", "example.org:1", "128.0.0.1:1"}) {
    EXPECT_FALSE(base::IsLoopback(*base::ParseListenAddress(text))) << text;
  }
}

TEST(ListenAddress, OtherMachinesOnlyIfAskedFor) {
  GrpcServerOptions options{.listen = "0.0.0.0:50051"};
  EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("--insecure-any-address"));
  options.insecure_any_address = true;
  EXPECT_TRUE(options.Validate().ok());
}

TEST(ListenAddress, OptionsOutOfRangeAreRefused) {
  for (const GrpcServerOptions& bad :
       {GrpcServerOptions{.listen = "x"},
        GrpcServerOptions{.max_message_mib = 0},
        GrpcServerOptions{.max_message_mib = 1025},
        GrpcServerOptions{.max_buffered_mib = -1},
        GrpcServerOptions{.max_connection_age_s = -1},
        GrpcServerOptions{.connection_grace_s = 0}}) {
    EXPECT_EQ(bad.Validate().code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_TRUE(GrpcServerOptions{}.Validate().ok());
}

TEST(ListenAddress, SaysWhyAPortCannotBeBound) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  ASSERT_GE(fd, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(any);
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&any), length), 0);
  ASSERT_EQ(listen(fd, 1), 0);
  ASSERT_EQ(getsockname(fd, reinterpret_cast<sockaddr*>(&any), &length), 0);
  const base::ListenAddress taken{.host = "127.0.0.1",
                                  .port = ntohs(any.sin_port)};
  const absl::Status status = base::TryBind(taken);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr(taken.ToString()));
  EXPECT_THAT(std::string(status.message()), HasSubstr("in use"));
  close(fd);
  EXPECT_TRUE(base::TryBind({.host = "127.0.0.1", .port = 0}).ok());
}

}  // namespace
}  // namespace treeline::service
