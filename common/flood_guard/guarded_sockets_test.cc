// The functions that stand before libc's, on real sockets.
#include "common/flood_guard/guarded_sockets.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/base/descriptor.h"
#include "common/flood_guard/testing_frames.h"

namespace treeline::flood_guard {
namespace {

class GuardedSocketsTest : public ::testing::Test {
 protected:
  GuardedSocketsTest()
      : listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(listener_.get(), reinterpret_cast<sockaddr*>(&address),
                   sizeof(address)),
              0);
    EXPECT_EQ(listen(listener_.get(), 16), 0);
    socklen_t size = sizeof(address_);
    getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address_), &size);
  }

  // The client's end.
  int Connect() const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&address_),
                      sizeof(address_)),
              0);
    return fd;
  }
  int Accept() const {
    return accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC);
  }
  static ssize_t Receive(int fd) {
    std::array<char, 100> first = {};
    std::array<char, 1 << 16> rest = {};
    std::array<iovec, 2> pieces = {
        {{first.data(), first.size()}, {rest.data(), rest.size()}}};
    msghdr message = {};
    message.msg_iov = pieces.data();
    message.msg_iovlen = pieces.size();
    return recvmsg(fd, &message, 0);
  }
  static void Send(int fd, const std::string& bytes) {
    ASSERT_EQ(send(fd, bytes.data(), bytes.size(), 0),
              static_cast<ssize_t>(bytes.size()));
  }
  void Guard() {
    port_ = std::make_unique<GuardedPort>(ntohs(address_.sin_port), guard_);
  }

  const base::Descriptor listener_;
  sockaddr_in address_ = {};
  const base::SteadyClock clock_{};
  const std::shared_ptr<FloodGuard> guard_ = std::make_shared<FloodGuard>(
      FloodLimits{.calls_per_s = 100, .connections = 3}, clock_);
  std::unique_ptr<GuardedPort> port_;
};

std::string Flood() {
  std::string frames;
  for (int i = 0; i < 500; ++i) {
    frames += TestFrame(kTestHeaders, kTestEndHeaders, 2 * i + 1, "block");
  }
  return frames;
}

TEST_F(GuardedSocketsTest, StandBeforeTheSystems) {
  EXPECT_TRUE(GuardedPort::Works());
}

TEST_F(GuardedSocketsTest, WhatIsOrdinaryIsHandedOn) {
  Guard();
  const base::Descriptor client(Connect());
  const base::Descriptor server(Accept());
  ASSERT_GE(server.get(), 0);
  const std::string bytes =
      kTestPreface + TestFrame(kTestHeaders, kTestEndHeaders, 1, "block");
  Send(client.get(), bytes);
  EXPECT_EQ(Receive(server.get()), static_cast<ssize_t>(bytes.size()));
}

TEST_F(GuardedSocketsTest, AFloodLooksLikeAReset) {
  Guard();
  const base::Descriptor client(Connect());
  const base::Descriptor server(Accept());
  Send(client.get(), kTestPreface + Flood());
  EXPECT_EQ(Receive(server.get()), -1);
  EXPECT_EQ(errno, ECONNRESET);
  Send(client.get(), "more");
  EXPECT_EQ(Receive(server.get()), -1);
  // And whoever comes back at once is not even accepted.
  const base::Descriptor again(Connect());
  EXPECT_EQ(Accept(), -1);
  EXPECT_EQ(errno, EAGAIN);
  EXPECT_EQ(Receive(again.get()), 0);
}

// gRPC asks for nothing now and then, which is not the end.
TEST_F(GuardedSocketsTest, WhoReadsNothingIsStillWatched) {
  Guard();
  const base::Descriptor client(Connect());
  const base::Descriptor server(Accept());
  Send(client.get(), kTestPreface + Flood());
  msghdr nothing = {};
  EXPECT_EQ(recvmsg(server.get(), &nothing, 0), 0);
  EXPECT_EQ(Receive(server.get()), -1);
  EXPECT_EQ(errno, ECONNRESET);
}

TEST_F(GuardedSocketsTest, OtherPortsAreNotWatched) {
  const base::Descriptor client(Connect());
  const base::Descriptor server(Accept());
  port_ = std::make_unique<GuardedPort>(1, guard_);
  Send(client.get(), kTestPreface + Flood());
  EXPECT_GT(Receive(server.get()), 0);
  EXPECT_EQ(guard_->cuts(CutReason::kCalls), 0u);
}

// A socket with the number of one that was cut, which nobody has seen close.
TEST_F(GuardedSocketsTest, ANumberIsNotASocket) {
  Guard();
  const base::Descriptor client(Connect());
  const int server = Accept();
  Send(client.get(), kTestPreface + Flood());
  EXPECT_EQ(Receive(server), -1);
  std::array<int, 2> pair = {};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()), 0);
  const base::Descriptor ours(pair[0]);
  ASSERT_EQ(dup2(pair[1], server), server);
  const base::Descriptor theirs(pair[1]);
  const base::Descriptor reused(server);
  Send(ours.get(), "hello");
  EXPECT_EQ(Receive(reused.get()), 5);
}

TEST_F(GuardedSocketsTest, ConnectionsThatEndMakeRoom) {
  Guard();
  for (int i = 0; i < 10; ++i) {
    const base::Descriptor client(Connect());
    const base::Descriptor server(Accept());
    ASSERT_GE(server.get(), 0) << i;
  }
  EXPECT_EQ(guard_->cuts(CutReason::kConnections), 0u);
}

TEST_F(GuardedSocketsTest, OnePeerHasSoManyConnections) {
  Guard();
  const base::Descriptor a(Connect());
  const base::Descriptor b(Connect());
  const base::Descriptor c(Connect());
  const base::Descriptor d(Connect());
  const base::Descriptor first(Accept());
  const base::Descriptor second(Accept());
  const base::Descriptor third(Accept());
  EXPECT_GE(third.get(), 0);
  EXPECT_EQ(Accept(), -1);
  EXPECT_EQ(Receive(d.get()), 0);
}

}  // namespace
}  // namespace treeline::flood_guard
