// Puts a FloodGuard between gRPC and its clients.
#ifndef COMMON_FLOOD_GUARD_GUARDED_SOCKETS_H_
#define COMMON_FLOOD_GUARD_GUARDED_SOCKETS_H_

#include <memory>

#include "common/flood_guard/flood_guard.h"

namespace treeline::flood_guard {

// While it lives, connections that this process accepts with accept4() on a TCP
// port are watched: what arrives on them is counted before whoever asked for it
// gets it, and a connection that the guard does not let go on looks as if the
// client had reset it. Where the connection is TLS, what is counted is what
// OpenSSL has decrypted for HTTP/2 ("h2").
//
// gRPC has no place for that, so this library defines three functions which
// the dynamic linker then finds before those of libc and OpenSSL: accept4,
// recvmsg and SSL_read (ADR 68). Sockets of other ports are passed through.
class GuardedPort {
 public:
  // One guard for a port at a time.
  GuardedPort(int port, std::shared_ptr<FloodGuard> guard);
  ~GuardedPort();
  GuardedPort(const GuardedPort&) = delete;
  GuardedPort& operator=(const GuardedPort&) = delete;

  // Whether gRPC's calls of the three do come here. They do not in a program
  // that is linked otherwise, and then nothing is watched.
  static bool Works();

 private:
  const int port_;
};

}  // namespace treeline::flood_guard

#endif  // COMMON_FLOOD_GUARD_GUARDED_SOCKETS_H_
