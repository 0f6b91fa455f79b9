// Bytes to a server without a client's library, for tests.
#ifndef COMMON_FLOOD_GUARD_TESTING_CONNECTION_H_
#define COMMON_FLOOD_GUARD_TESTING_CONNECTION_H_

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdint>
#include <string>

#include "common/base/listen_address.h"

namespace treeline::flood_guard {

// The descriptor of a connection to "127.0.0.1:PORT"; -1: there is none.
// Reading takes a minute at most: a test that would hang fails.
inline int ConnectForTest(const std::string& address) {
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(
      static_cast<uint16_t>(base::ParseListenAddress(address).value().port));
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  const timeval patience = {.tv_sec = 60, .tv_usec = 0};
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  if (connect(connection, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0) {
    return connection;
  }
  close(connection);
  return -1;
}

}  // namespace treeline::flood_guard

#endif  // COMMON_FLOOD_GUARD_TESTING_CONNECTION_H_
