#include "common/http/http_server.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <system_error>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "common/http/http_engine.h"

namespace treeline::http {
namespace {

// Connections that the system holds until they are accepted.
constexpr int kBacklog = 512;
// After the grace: how long answers may still take on their way out.
constexpr absl::Duration kLastWords = absl::Seconds(1);
// Before accept() is tried again when descriptors have run out.
constexpr int kAcceptPauseMs = 10;

constexpr absl::string_view kBusy =
    "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\n"
    "Connection: close\r\nContent-Length: 0\r\n\r\n";

struct AddressListDeleter {
  void operator()(addrinfo* list) const { freeaddrinfo(list); }
};

struct SslContextDeleter {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
};
using UniqueSslContext = std::unique_ptr<SSL_CTX, SslContextDeleter>;

// A listening socket for `address`, whose port is set to the one it has got.
absl::StatusOr<int> Listen(base::ListenAddress& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const std::string what =
      absl::StrCat("cannot listen on ", address.ToString(), ": ");
  const int lookup =
      getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(),
                  &hints, &found);
  if (lookup != 0) {
    return absl::UnavailableError(absl::StrCat(what, gai_strerror(lookup)));
  }
  const std::unique_ptr<addrinfo, AddressListDeleter> list(found);
  const int fd = socket(found->ai_family,
                        found->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK,
                        found->ai_protocol);
  const int on = 1;
  sockaddr_storage bound{};
  socklen_t length = sizeof(bound);
  // Not SO_REUSEPORT: a second server would share the port in silence.
  if (fd < 0 ||
      setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) != 0 ||
      bind(fd, found->ai_addr, found->ai_addrlen) != 0 ||
      listen(fd, kBacklog) != 0 ||
      getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &length) != 0) {
    const int error = errno;
    if (fd >= 0) close(fd);
    return absl::UnavailableError(absl::StrCat(what, std::strerror(error)));
  }
  address.port =
      bound.ss_family == AF_INET6
          ? ntohs(reinterpret_cast<const sockaddr_in6*>(&bound)->sin6_port)
          : ntohs(reinterpret_cast<const sockaddr_in*>(&bound)->sin_port);
  return fd;
}

absl::StatusOr<UniqueSslContext> MakeContext(const ServerTls& tls) {
  UniqueSslContext context(SSL_CTX_new(TLS_server_method()));
  if (context == nullptr) return absl::InternalError("no TLS context");
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  if (!tls.configure(*context)) {
    return absl::InvalidArgumentError("TLS cannot be set up for HTTP");
  }
  return context;
}

absl::Status CheckPositive(absl::string_view name,
                           std::chrono::milliseconds value) {
  if (value.count() > 0 && value <= std::chrono::hours(1)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value.count(), " ms; it must be 1 ms..1 h"));
}

}  // namespace

absl::Status HttpServerOptions::Validate() const {
  TL_ASSIGN_OR_RETURN(const base::ListenAddress address,
                      base::ParseListenAddress(listen));
  if (!tls.has_value() && !insecure_any_address && !base::IsLoopback(address)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "refusing to listen for HTTP on ", address.ToString(),
        ", which other machines may reach: the connection is not encrypted. "
        "Give it a certificate, listen on 127.0.0.1, or accept the risk with "
        "--insecure-any-address"));
  }
  if (tls.has_value() && !tls->configure) {
    return absl::InvalidArgumentError("TLS without anything to set it up");
  }
  if (max_body_mib < 1 || max_body_mib > 1024) {
    return absl::InvalidArgumentError(absl::StrCat(
        "largest HTTP body is ", max_body_mib, " MiB; it must be 1..1024"));
  }
  if (max_connections < 1 || max_connections > 10000) {
    return absl::InvalidArgumentError(
        absl::StrCat("number of HTTP connections is ", max_connections,
                     "; it must be 1..10000"));
  }
  if (stream.head_bytes < 1024 || stream.head_bytes > 1 << 20) {
    return absl::InvalidArgumentError(
        absl::StrCat("size of HTTP headers is ", stream.head_bytes,
                     "; it must be 1024..1048576"));
  }
  TL_RETURN_IF_ERROR(CheckPositive("HTTP idle time-out", idle_timeout));
  TL_RETURN_IF_ERROR(
      CheckPositive("HTTP header time-out", stream.head_timeout));
  TL_RETURN_IF_ERROR(CheckPositive("HTTP body time-out", stream.body_timeout));
  return CheckPositive("HTTP write time-out", stream.write_timeout);
}

class HttpServer::Impl {
 public:
  Impl(const HttpServerOptions& options, HttpHandler& handler,
       const base::Clock& clock, UniqueSslContext context, int listener,
       std::string address)
      : options_(options),
        handler_(handler),
        clock_(clock),
        context_(std::move(context)),
        listener_(listener),
        address_(std::move(address)),
        wake_(eventfd(0, EFD_CLOEXEC)),
        acceptor_([this] { AcceptAll(); }) {}

  ~Impl() { close(wake_); }

  const std::string& address() const { return address_; }

  void Stop(std::chrono::milliseconds grace);

 private:
  struct Connection {
    std::thread thread;
    // -1 once it is closed.
    int fd = -1;
    // Waits for a request since then.
    bool idle = true;
    base::MonotonicTime idle_since;
  };
  using Connections = std::map<int64_t, Connection>;

  void AcceptAll();
  void Admit(int fd);
  // Runs in the connection's thread.
  void Serve(int64_t id, int fd);
  void ServeRequests(int64_t id, int fd);
  // Marks the connection as idle or not. False: it is to be closed.
  bool SetIdle(int64_t id, bool idle);
  // Joins threads that have ended.
  void Reap();
  bool MakeRoom() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Wakes every read of the connections, or every write too.
  void ShutDown(bool idle_only, int how) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool AllEnded() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return open_ == 0;
  }

  const HttpServerOptions options_;
  HttpHandler& handler_;
  const base::Clock& clock_;
  const UniqueSslContext context_;
  const int listener_;
  const std::string address_;
  const int wake_;

  absl::Mutex mutex_;
  Connections connections_ ABSL_GUARDED_BY(mutex_);
  std::vector<int64_t> ended_ ABSL_GUARDED_BY(mutex_);
  // Connections whose thread is at work.
  int open_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t next_id_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;

  // The last member: it uses all of them.
  std::thread acceptor_;
};

void HttpServer::Impl::AcceptAll() {
  std::array<pollfd, 2> polled{
      {{.fd = listener_, .events = POLLIN, .revents = 0},
       {.fd = wake_, .events = POLLIN, .revents = 0}}};
  for (;;) {
    if (poll(polled.data(), polled.size(), -1) < 0 && errno != EINTR) return;
    {
      const absl::MutexLock lock(&mutex_);
      if (stopping_) return;
    }
    Reap();
    const int fd = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (fd >= 0) {
      Admit(fd);
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS ||
               errno == ENOMEM) {
      poll(&polled[1], 1, kAcceptPauseMs);
    }
    // Everything else concerns one connection that has gone already.
  }
}

void HttpServer::Impl::Admit(int fd) {
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  const absl::MutexLock lock(&mutex_);
  if (open_ >= options_.max_connections && !MakeRoom()) {
    if (context_ == nullptr) {
      [[maybe_unused]] const ssize_t sent =
          send(fd, kBusy.data(), kBusy.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    }
    close(fd);
    return;
  }
  const int64_t id = next_id_++;
  ++open_;
  Connection& connection = connections_[id];
  connection.fd = fd;
  connection.idle_since = clock_.Now();
  try {
    connection.thread = std::thread([this, id, fd] { Serve(id, fd); });
  } catch (const std::system_error&) {
    // No more threads: as if there were no more connections.
    connections_.erase(id);
    --open_;
    close(fd);
  }
}

bool HttpServer::Impl::MakeRoom() {
  Connection* oldest = nullptr;
  for (auto& [id, connection] : connections_) {
    if (connection.fd >= 0 && connection.idle &&
        (oldest == nullptr || connection.idle_since < oldest->idle_since)) {
      oldest = &connection;
    }
  }
  if (oldest == nullptr) return false;
  shutdown(oldest->fd, SHUT_RD);
  // Not found again; its thread is about to end.
  oldest->idle = false;
  return true;
}

void HttpServer::Impl::Serve(int64_t id, int fd) {
  ServeRequests(id, fd);
  const absl::MutexLock lock(&mutex_);
  close(fd);
  connections_[id].fd = -1;
  ended_.push_back(id);
  --open_;
}

void HttpServer::Impl::ServeRequests(int64_t id, int fd) {
  UniqueSsl ssl;
  if (context_ != nullptr) {
    ssl.reset(SSL_new(context_.get()));
    if (ssl == nullptr) return;
  }
  HttpStream stream(fd, std::move(ssl), options_.stream, clock_);
  if (!stream.Handshake()) return;
  HttpEngine::Connection connection{
      .socket = fd,
      .max_body_bytes = static_cast<size_t>(options_.max_body_mib) << 20};
  if (options_.tls.has_value() && options_.tls->client_names) {
    connection.certificate_names = options_.tls->client_names(stream.ssl());
  }
  HttpEngine engine(handler_, stream, std::move(connection), clock_);
  // The first request must come as soon as its head must end.
  auto patience = options_.stream.head_timeout;
  do {
    if (!stream.WaitForRequest(patience)) return;
    if (!SetIdle(id, false)) return;
    bool last = false;
    {
      const absl::MutexLock lock(&mutex_);
      last = stopping_;
    }
    if (!engine.ServeOne(last)) return;
    patience = options_.idle_timeout;
  } while (SetIdle(id, true));
}

bool HttpServer::Impl::SetIdle(int64_t id, bool idle) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_ && idle) return false;
  Connection& connection = connections_[id];
  connection.idle = idle;
  connection.idle_since = clock_.Now();
  return true;
}

void HttpServer::Impl::Reap() {
  std::vector<std::thread> threads;
  {
    const absl::MutexLock lock(&mutex_);
    for (const int64_t id : ended_) {
      threads.push_back(std::move(connections_[id].thread));
      connections_.erase(id);
    }
    ended_.clear();
  }
  for (std::thread& thread : threads) thread.join();
}

void HttpServer::Impl::ShutDown(bool idle_only, int how) {
  for (auto& [id, connection] : connections_) {
    if (connection.fd >= 0 && (connection.idle || !idle_only)) {
      shutdown(connection.fd, how);
    }
  }
}

void HttpServer::Impl::Stop(std::chrono::milliseconds grace) {
  {
    const absl::MutexLock lock(&mutex_);
    if (stopping_) return;
    stopping_ = true;
  }
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t woken = write(wake_, &one, sizeof(one));
  acceptor_.join();
  close(listener_);
  {
    const absl::MutexLock lock(&mutex_);
    ShutDown(/*idle_only=*/true, SHUT_RD);
    const absl::Condition ended(this, &Impl::AllEnded);
    mutex_.AwaitWithTimeout(ended, absl::FromChrono(grace));
    ShutDown(/*idle_only=*/false, SHUT_RD);
    mutex_.AwaitWithTimeout(ended, kLastWords);
    ShutDown(/*idle_only=*/false, SHUT_RDWR);
    mutex_.Await(ended);
  }
  Reap();
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

HttpServer::~HttpServer() { Stop(std::chrono::milliseconds(0)); }

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(
    const HttpServerOptions& options, HttpHandler& handler,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(base::ListenAddress address,
                      base::ParseListenAddress(options.listen));
  UniqueSslContext context;
  if (options.tls.has_value()) {
    TL_ASSIGN_OR_RETURN(context, MakeContext(*options.tls));
  }
  TL_ASSIGN_OR_RETURN(const int listener, Listen(address));
  auto impl =
      std::make_unique<Impl>(options, handler, clock, std::move(context),
                             listener, address.ToString());
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

const std::string& HttpServer::address() const { return impl_->address(); }

void HttpServer::Stop(std::chrono::milliseconds grace) { impl_->Stop(grace); }

}  // namespace treeline::http
