// What is asked of addresses of sockets.
#ifndef COMMON_BASE_SOCKET_ADDRESS_H_
#define COMMON_BASE_SOCKET_ADDRESS_H_

#include <sys/socket.h>

#include <string>

namespace treeline::base {

// The address without its port, as limits by client go by it: of IPv6 the first
// 64 bits, for who has one has all that share them. An IPv4 address in IPv6's
// form, as a dual-stack listener shows it, is IPv4. "": neither.
std::string AddressKey(const sockaddr_storage& address);

// -1: neither IPv4 nor IPv6.
int PortOf(const sockaddr_storage& address);

}  // namespace treeline::base

#endif  // COMMON_BASE_SOCKET_ADDRESS_H_
