// Where a server listens: "HOST:PORT".
#ifndef COMMON_BASE_LISTEN_ADDRESS_H_
#define COMMON_BASE_LISTEN_ADDRESS_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

struct ListenAddress {
  // Without brackets.
  std::string host;
  int port = 0;

  // "HOST:PORT" again, with brackets where they are needed.
  std::string ToString() const;
};

// From "127.0.0.1:50051", "[::1]:0" or "localhost:50051". INVALID_ARGUMENT: no
// host, no port, or a port outside 0..65535.
absl::StatusOr<ListenAddress> ParseListenAddress(absl::string_view text);

// Whether only this machine reaches it: 127.0.0.0/8, ::1 or "localhost".
bool IsLoopback(const ListenAddress& address);

// Why `address` cannot be bound now, from the system: UNAVAILABLE, naming the
// address. OK if it can be bound.
absl::Status TryBind(const ListenAddress& address);

}  // namespace treeline::base

#endif  // COMMON_BASE_LISTEN_ADDRESS_H_
