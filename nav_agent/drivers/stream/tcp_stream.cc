#include "nav_agent/drivers/stream/tcp_stream.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "common/base/socket_address.h"
#include "common/base/status_macros.h"
#include "nav_agent/drivers/stream/descriptor_stream.h"

namespace treeline::stream {
namespace {

using std::chrono::milliseconds;
using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

std::string NameOf(const std::string& host, int port) {
  const bool brackets = host.find(':') != std::string::npos;
  return absl::StrCat("tcp:", brackets ? "[" : "", host, brackets ? "]" : "",
                      ":", port);
}

absl::StatusOr<Addresses> LookUp(const std::string& host, int port, int flags) {
  addrinfo hints = {};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  const int error =
      getaddrinfo(host.c_str(), absl::StrCat(port).c_str(), &hints, &found);
  if (error != 0) {
    return absl::UnavailableError(
        absl::StrCat("no address for ", host, ": ", gai_strerror(error)));
  }
  return Addresses(found, &freeaddrinfo);
}

// Small frames go out at once. A peer that no longer answers is probed after
// two seconds of silence and given up after five.
void TuneSocket(int fd) {
  const auto set = [fd](int level, int option, int value) {
    // None of them is worth failing for.
    [[maybe_unused]] const int ignored =
        setsockopt(fd, level, option, &value, sizeof(value));
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 2);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 5000);
}

absl::StatusOr<std::unique_ptr<ByteStream>> ConnectTo(
    const addrinfo& address, const TcpStreamOptions& options,
    const std::stop_token& stop) {
  const std::string name = NameOf(options.host, options.port);
  const auto failed = [&name](int error) {
    return SystemError(absl::StatusCode::kUnavailable,
                       absl::StrCat("connecting to ", name), error);
  };
  const int fd =
      socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return failed(errno);
  absl::Cleanup close_it = [fd] { close(fd); };
  if (connect(fd, address.ai_addr, address.ai_addrlen) < 0) {
    if (errno != EINPROGRESS) return failed(errno);
    const milliseconds timeout(
        static_cast<int64_t>(options.connect_timeout_s * 1e3));
    TL_ASSIGN_OR_RETURN(const WaitOutcome outcome,
                        WaitForDescriptor(fd, POLLOUT, timeout, stop));
    if (outcome == WaitOutcome::kStopped) return absl::CancelledError(name);
    if (outcome == WaitOutcome::kTimedOut) return failed(ETIMEDOUT);
    int error = 0;
    socklen_t size = sizeof(error);
    if (getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) < 0) error = errno;
    if (error != 0) return failed(error);
  }
  TuneSocket(fd);
  std::move(close_it).Cancel();
  return MakeDescriptorStream(fd, name);
}

int PortOf(int fd) {
  sockaddr_storage address = {};
  socklen_t size = sizeof(address);
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) < 0) {
    return -1;
  }
  return base::PortOf(address);
}

}  // namespace

absl::Status TcpStreamOptions::Validate() const {
  if (host.empty()) return absl::InvalidArgumentError("TCP: there is no host");
  if (port < 1 || port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat("TCP: ", port, " is no port (1 to 65535)"));
  }
  if (!(connect_timeout_s > 0 && connect_timeout_s <= 3600)) {
    return absl::InvalidArgumentError(
        "TCP: connect_timeout_s must be positive, and at most an hour");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<ByteStream>> ConnectTcp(
    const TcpStreamOptions& options, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  TL_ASSIGN_OR_RETURN(const Addresses addresses,
                      LookUp(options.host, options.port, 0));
  // A name may stand for several; the last one's reason is told.
  absl::Status status = absl::UnavailableError(options.host);
  for (const addrinfo* address = addresses.get(); address != nullptr;
       address = address->ai_next) {
    auto stream = ConnectTo(*address, options, stop);
    if (stream.ok() || absl::IsCancelled(stream.status())) return stream;
    status = stream.status();
  }
  return status;
}

absl::StatusOr<std::unique_ptr<ByteStream>> TcpOpener::Open(
    const std::stop_token& stop) {
  return ConnectTcp(options_, stop);
}

std::string TcpOpener::Name() const {
  return NameOf(options_.host, options_.port);
}

absl::StatusOr<std::unique_ptr<TcpListener>> TcpListener::Listen(
    int port, const std::string& address) {
  if (port < 0 || port > 65535) {
    return absl::InvalidArgumentError(absl::StrCat(port, " is no TCP port"));
  }
  TL_ASSIGN_OR_RETURN(const Addresses addresses,
                      LookUp(address, port, AI_PASSIVE | AI_NUMERICHOST));
  const addrinfo& first = *addresses;
  const int fd =
      socket(first.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const auto failed = [&](int error) {
    return SystemError(absl::StatusCode::kUnavailable,
                       absl::StrCat("listening on ", NameOf(address, port)),
                       error);
  };
  if (fd < 0) return failed(errno);
  absl::Cleanup close_it = [fd] { close(fd); };
  const int on = 1;
  if (setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) < 0 ||
      bind(fd, first.ai_addr, first.ai_addrlen) < 0 || listen(fd, 4) < 0) {
    return failed(errno);
  }
  std::move(close_it).Cancel();
  return std::unique_ptr<TcpListener>(new TcpListener(fd, PortOf(fd)));
}

absl::StatusOr<std::unique_ptr<ByteStream>> TcpListener::Accept(
    milliseconds timeout, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const WaitOutcome outcome,
                      WaitForDescriptor(fd_.get(), POLLIN, timeout, stop));
  if (outcome != WaitOutcome::kReady) return nullptr;
  const int fd = accept4(fd_.get(), nullptr, nullptr, SOCK_CLOEXEC);
  if (fd < 0) {
    // The caller gave up between poll() and here.
    if (errno == EAGAIN || errno == ECONNABORTED || errno == EINTR) {
      return nullptr;
    }
    return SystemError(absl::StatusCode::kUnavailable, "accept", errno);
  }
  TuneSocket(fd);
  return MakeDescriptorStream(fd, absl::StrCat("caller of port ", port_));
}

}  // namespace treeline::stream
