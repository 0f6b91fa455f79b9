#include "common/http/http_server.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "common/base/listen_address.h"
#include "common/base/socket_address.h"
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
// Who asks how the server is has no more to say than that.
constexpr std::chrono::milliseconds kProbeHeadTimeout{2000};
// A connection that is younger, and has said nothing yet, is not idle: it has
// just been made.
constexpr double kFresh_s = 1;

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
  address.port = base::PortOf(bound);
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

absl::Status CheckRange(absl::string_view name, int value, int low, int high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; it must be ", low, "..", high));
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
  TL_RETURN_IF_ERROR(
      CheckRange("largest HTTP body (MiB)", max_body_mib, 1, 1024));
  TL_RETURN_IF_ERROR(
      CheckRange("number of HTTP connections", max_connections, 1, 10000));
  TL_RETURN_IF_ERROR(CheckRange("number of HTTP connections of a client",
                                max_connections_per_client, 0, 10000));
  TL_RETURN_IF_ERROR(CheckRange("number of HTTP connections for probes",
                                max_probe_connections, 0, 1000));
  TL_RETURN_IF_ERROR(CheckRange("rate of HTTP bodies (B/s)",
                                stream.min_body_bytes_per_s, 1, 1 << 30));
  if (stream.head_bytes < 1024 || stream.head_bytes > 1 << 20) {
    return absl::InvalidArgumentError(
        absl::StrCat("size of HTTP headers is ", stream.head_bytes,
                     "; it must be 1024..1048576"));
  }
  TL_RETURN_IF_ERROR(CheckPositive("HTTP idle time-out", idle_timeout));
  TL_RETURN_IF_ERROR(
      CheckPositive("HTTP header time-out", stream.head_timeout));
  TL_RETURN_IF_ERROR(CheckPositive("HTTP body time-out", stream.body_timeout));
  TL_RETURN_IF_ERROR(CheckPositive("grace of the rate of HTTP bodies",
                                   stream.body_rate_grace));
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
    // See base::AddressKey.
    std::string client;
    bool only_probes = false;
    base::MonotonicTime accepted;
    // Told to end, to make room.
    bool is_leaving = false;
    // While its thread serves; to ask how fast its request arrives.
    const HttpStream* stream = nullptr;
  };
  using Connections = std::map<int64_t, Connection>;

  void AcceptAll();
  void Admit(int fd, const sockaddr_storage& address);
  // Whether there is room for one more, and for what.
  enum class Room { kNone, kProbesOnly, kAll };
  Room FindRoom(const std::string& client)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Runs in the connection's thread.
  void Serve(int64_t id, int fd, bool only_probes);
  void ServeRequests(int64_t id, HttpStream& stream, int fd, bool only_probes);
  void SetStream(int64_t id, const HttpStream* stream);
  // Marks the connection as idle or not. False: it is to be closed.
  bool SetIdle(int64_t id, bool idle);
  // Joins threads that have ended.
  void Reap();
  // Connections that are to stay, by client.
  using Crowds = std::map<std::string, int>;
  // How well a connection can be missed: the least of these best.
  enum class Kind { kIdle, kSlow, kOfACrowd, kFresh };
  using Worth = std::tuple<Kind, double, double>;
  // Ends the connection that is missed least. Of `client` alone, if `is_alone`;
  // else also those of others. False: there is none.
  bool MakeRoom(const std::string& client, bool is_alone)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Crowds CountCrowds() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // nullopt: it stays. `lead`: how many connections more its client has than
  // the one for whom room is made; nullopt: it is the same client.
  std::optional<Worth> WorthOf(const Connection& connection,
                               std::optional<int> lead) const;
  bool MakeRoomForProbe() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static void End(Connection& connection, int how);
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
  // Of these, the ones for probes alone.
  int open_for_probes_ ABSL_GUARDED_BY(mutex_) = 0;
  // The others of each client.
  std::map<std::string, int> open_of_client_ ABSL_GUARDED_BY(mutex_);
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
    sockaddr_storage address{};
    socklen_t length = sizeof(address);
    const int fd = accept4(listener_, reinterpret_cast<sockaddr*>(&address),
                           &length, SOCK_CLOEXEC);
    if (fd >= 0) {
      Admit(fd, address);
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS ||
               errno == ENOMEM) {
      poll(&polled[1], 1, kAcceptPauseMs);
    }
    // Everything else concerns one connection that has gone already.
  }
}

void HttpServer::Impl::Admit(int fd, const sockaddr_storage& address) {
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  const std::string client = base::AddressKey(address);
  const absl::MutexLock lock(&mutex_);
  const Room room = FindRoom(client);
  if (room == Room::kNone) {
    if (context_ == nullptr) {
      [[maybe_unused]] const ssize_t sent =
          send(fd, kBusy.data(), kBusy.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    }
    close(fd);
    return;
  }
  const int64_t id = next_id_++;
  Connection& connection = connections_[id];
  connection.fd = fd;
  connection.client = client;
  connection.only_probes = room == Room::kProbesOnly;
  connection.accepted = clock_.Now();
  connection.idle_since = connection.accepted;
  try {
    connection.thread =
        std::thread([this, id, fd, only_probes = connection.only_probes] {
          Serve(id, fd, only_probes);
        });
  } catch (const std::system_error&) {
    // No more threads: as if there were no more connections.
    connections_.erase(id);
    close(fd);
    return;
  }
  ++open_;
  if (connection.only_probes) {
    ++open_for_probes_;
  } else {
    ++open_of_client_[client];
  }
}

HttpServer::Impl::Room HttpServer::Impl::FindRoom(const std::string& client) {
  bool is_full = open_ - open_for_probes_ >= options_.max_connections &&
                 !MakeRoom(client, /*is_alone=*/false);
  const auto of_client = open_of_client_.find(client);
  if (!is_full && options_.max_connections_per_client > 0 &&
      of_client != open_of_client_.end() &&
      of_client->second >= options_.max_connections_per_client) {
    is_full = !MakeRoom(client, /*is_alone=*/true);
  }
  if (!is_full) return Room::kAll;
  if (options_.max_probe_connections == 0 ||
      (open_for_probes_ >= options_.max_probe_connections &&
       !MakeRoomForProbe())) {
    return Room::kNone;
  }
  return Room::kProbesOnly;
}

HttpServer::Impl::Crowds HttpServer::Impl::CountCrowds() const {
  Crowds crowds;
  for (const auto& [id, connection] : connections_) {
    if (connection.fd < 0 || connection.is_leaving || connection.only_probes) {
      continue;
    }
    ++crowds[connection.client];
  }
  return crowds;
}

std::optional<HttpServer::Impl::Worth> HttpServer::Impl::WorthOf(
    const Connection& connection, std::optional<int> lead) const {
  const base::MonotonicTime now = clock_.Now();
  const double age_s = base::SecondsBetween(connection.idle_since, now);
  if (connection.idle) {
    const bool is_fresh =
        connection.idle_since == connection.accepted && age_s < kFresh_s;
    if (!is_fresh) return Worth(Kind::kIdle, -age_s, 0);
    // Whoever makes many at once must not push out those of others.
    if (lead.value_or(1) < 1) return std::nullopt;
    return Worth(Kind::kFresh, -lead.value_or(0), -age_s);
  }
  if (connection.stream == nullptr) return std::nullopt;
  const auto rate = connection.stream->ArrivalRate(now);
  if (rate.has_value() && *rate < options_.stream.min_body_bytes_per_s) {
    return Worth(Kind::kSlow, *rate, 0);
  }
  if (lead.value_or(0) > 1 && connection.stream->AwaitsClient()) {
    return Worth(Kind::kOfACrowd, -*lead, -age_s);
  }
  return std::nullopt;
}

bool HttpServer::Impl::MakeRoom(const std::string& client, bool is_alone) {
  Crowds crowds = CountCrowds();
  const int of_newcomer = crowds[client];
  Connection* least = nullptr;
  Worth least_worth;
  for (auto& [id, connection] : connections_) {
    if (connection.fd < 0 || connection.is_leaving || connection.only_probes ||
        (is_alone && connection.client != client)) {
      continue;
    }
    std::optional<int> lead;
    if (connection.client != client) {
      lead = crowds[connection.client] - of_newcomer;
    }
    const auto worth = WorthOf(connection, lead);
    if (worth.has_value() && (least == nullptr || *worth < least_worth)) {
      least = &connection;
      least_worth = *worth;
    }
  }
  if (least == nullptr) return false;
  // Who does not read would keep what is written to it waiting.
  End(*least,
      std::get<Kind>(least_worth) == Kind::kOfACrowd ? SHUT_RDWR : SHUT_RD);
  return true;
}

bool HttpServer::Impl::MakeRoomForProbe() {
  Connection* oldest = nullptr;
  for (auto& [id, connection] : connections_) {
    if (connection.fd < 0 || connection.is_leaving || !connection.only_probes) {
      continue;
    }
    if (oldest == nullptr || connection.accepted < oldest->accepted) {
      oldest = &connection;
    }
  }
  if (oldest == nullptr) return false;
  End(*oldest, SHUT_RD);
  return true;
}

void HttpServer::Impl::End(Connection& connection, int how) {
  shutdown(connection.fd, how);
  // Not found again; its thread is about to end.
  connection.is_leaving = true;
}

void HttpServer::Impl::Serve(int64_t id, int fd, bool only_probes) {
  UniqueSsl ssl;
  if (context_ != nullptr) ssl.reset(SSL_new(context_.get()));
  if (context_ == nullptr || ssl != nullptr) {
    StreamLimits limits = options_.stream;
    if (only_probes) {
      limits.head_timeout = std::min(limits.head_timeout, kProbeHeadTimeout);
    }
    HttpStream stream(fd, std::move(ssl), limits, clock_);
    SetStream(id, &stream);
    ServeRequests(id, stream, fd, only_probes);
    SetStream(id, nullptr);
  }
  const absl::MutexLock lock(&mutex_);
  close(fd);
  Connection& connection = connections_[id];
  connection.fd = -1;
  ended_.push_back(id);
  --open_;
  if (only_probes) {
    --open_for_probes_;
  } else if (--open_of_client_[connection.client] == 0) {
    open_of_client_.erase(connection.client);
  }
}

void HttpServer::Impl::SetStream(int64_t id, const HttpStream* stream) {
  const absl::MutexLock lock(&mutex_);
  connections_[id].stream = stream;
}

void HttpServer::Impl::ServeRequests(int64_t id, HttpStream& stream, int fd,
                                     bool only_probes) {
  if (!stream.Handshake()) return;
  HttpEngine::Connection connection{
      .socket = fd,
      .max_body_bytes = static_cast<size_t>(options_.max_body_mib) << 20,
      .only_probes = only_probes,
      .budget = options_.budget,
      .answers = options_.answers,
      .mark_idle = [this, id](bool idle) { return SetIdle(id, idle); }};
  if (options_.tls.has_value() && options_.tls->client_names) {
    connection.certificate_names = options_.tls->client_names(stream.ssl());
  }
  HttpEngine engine(handler_, stream, std::move(connection), clock_);
  // The first request must come as soon as its head must end.
  auto patience =
      only_probes ? kProbeHeadTimeout : options_.stream.head_timeout;
  do {
    if (!stream.WaitForRequest(patience)) return;
    if (!SetIdle(id, false)) return;
    bool last = only_probes;
    {
      const absl::MutexLock lock(&mutex_);
      last = last || stopping_;
    }
    if (!engine.ServeOne(last)) return;
    patience = options_.idle_timeout;
  } while (SetIdle(id, true));
}

bool HttpServer::Impl::SetIdle(int64_t id, bool idle) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_ && idle) return false;
  Connection& connection = connections_[id];
  if (connection.is_leaving) return false;
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
