#include "common/base/socket_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <cstdint>

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

sockaddr_storage V4(const char* text, uint16_t port) {
  sockaddr_storage address = {};
  auto& v4 = reinterpret_cast<sockaddr_in&>(address);
  v4.sin_family = AF_INET;
  v4.sin_port = htons(port);
  EXPECT_EQ(inet_pton(AF_INET, text, &v4.sin_addr), 1);
  return address;
}

sockaddr_storage V6(const char* text, uint16_t port) {
  sockaddr_storage address = {};
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  v6.sin6_family = AF_INET6;
  v6.sin6_port = htons(port);
  EXPECT_EQ(inet_pton(AF_INET6, text, &v6.sin6_addr), 1);
  return address;
}

TEST(AddressKeyTest, IsTheSameForWhatOneClientHas) {
  EXPECT_EQ(AddressKey(V4("192.0.2.1", 1)), AddressKey(V4("192.0.2.1", 2)));
  EXPECT_EQ(AddressKey(V6("2001:db8:1:2::9", 1)),
            AddressKey(V6("2001:db8:1:2:ffff::1", 2)));
  EXPECT_EQ(AddressKey(V6("::ffff:192.0.2.1", 1)),
            AddressKey(V4("192.0.2.1", 2)));
}

TEST(AddressKeyTest, IsAnotherForAnotherClient) {
  EXPECT_NE(AddressKey(V4("192.0.2.1", 1)), AddressKey(V4("192.0.2.2", 1)));
  EXPECT_NE(AddressKey(V6("2001:db8:1:2::9", 1)),
            AddressKey(V6("2001:db8:1:3::9", 1)));
  EXPECT_NE(AddressKey(V6("::ffff:192.0.2.1", 1)),
            AddressKey(V6("::ffff:192.0.2.2", 1)));
}

TEST(SocketAddressTest, OfAnotherFamilyHasNeitherKeyNorPort) {
  sockaddr_storage address = {};
  address.ss_family = AF_UNIX;
  EXPECT_EQ(AddressKey(address), "");
  EXPECT_EQ(PortOf(address), -1);
}

TEST(SocketAddressTest, HasItsPortInTheHostsOrder) {
  EXPECT_EQ(PortOf(V4("192.0.2.1", 50051)), 50051);
  EXPECT_EQ(PortOf(V6("::1", 8080)), 8080);
}

}  // namespace
}  // namespace treeline::base
