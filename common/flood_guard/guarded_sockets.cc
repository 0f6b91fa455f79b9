#include "common/flood_guard/guarded_sockets.h"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/socket_address.h"
#include "common/flood_guard/watched_connection.h"

namespace treeline::flood_guard {
namespace {

using Watched = std::shared_ptr<WatchedConnection>;

// As libc and OpenSSL define it.
template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

// Distinguishes a socket from a later one of the same number; 0: none.
ino_t InodeOf(int fd) {
  struct stat status = {};
  return fstat(fd, &status) == 0 ? status.st_ino : 0;
}

std::string PeerText(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text = {};
  if (address.ss_family == AF_INET6) {
    const in6_addr& v6 =
        reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
    if (IN6_IS_ADDR_V4MAPPED(&v6)) {
      inet_ntop(AF_INET, &v6.s6_addr[12], text.data(), text.size());
      return absl::StrCat(text.data(), ":", base::PortOf(address));
    }
    inet_ntop(AF_INET6, &v6, text.data(), text.size());
    return absl::StrCat("[", text.data(), "]:", base::PortOf(address));
  }
  inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in&>(address).sin_addr,
            text.data(), text.size());
  return absl::StrCat(text.data(), ":", base::PortOf(address));
}

// All watched connections of the process. Nobody tells it that a socket was
// closed: an entry whose number belongs to another socket now is dropped when
// it is met, and otherwise within a second of the next connection.
class Connections {
 public:
  static Connections& Get() {
    static Connections& connections = *new Connections;
    return connections;
  }

  bool active() const { return ports_.load(std::memory_order_relaxed) > 0; }

  void AddPort(int port, std::shared_ptr<FloodGuard> guard) {
    const absl::MutexLock lock(&mutex_);
    guards_[port] = std::move(guard);
    ++ports_;
  }

  void RemovePort(int port) {
    const absl::MutexLock lock(&mutex_);
    guards_.erase(port);
    --ports_;
  }

  // A socket that has just been accepted; false: it must be closed.
  bool Adopt(int fd) {
    sockaddr_storage local = {};
    sockaddr_storage peer = {};
    socklen_t local_size = sizeof(local);
    socklen_t peer_size = sizeof(peer);
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&local), &local_size) ||
        getpeername(fd, reinterpret_cast<sockaddr*>(&peer), &peer_size)) {
      return true;
    }
    std::shared_ptr<FloodGuard> guard = GuardOf(base::PortOf(local));
    if (guard == nullptr) return true;
    Watched watched = WatchedConnection::Open(
        std::move(guard), base::AddressKey(peer), PeerText(peer));
    if (watched == nullptr) return false;
    const absl::MutexLock lock(&mutex_);
    by_fd_[fd] = Entry{InodeOf(fd), std::move(watched), ""};
    return true;
  }

  // Null: not watched.
  Watched Find(int fd) {
    const absl::MutexLock lock(&mutex_);
    const auto found = by_fd_.find(fd);
    if (found == by_fd_.end()) return nullptr;
    if (IsOpen(*found)) return found->second.watched;
    by_fd_.erase(found);
    return nullptr;
  }

  // From now on FindTls finds it. False: its random bytes are another's.
  bool Claim(int fd, const Watched& watched) {
    std::string random = watched->client_random();
    const absl::MutexLock lock(&mutex_);
    for (const auto& each : by_fd_) {
      if (each.second.client_random == random && IsOpen(each)) return false;
    }
    by_fd_[fd].client_random = std::move(random);
    return true;
  }

  // The connection whose handshake began with this; null: none that is watched.
  Watched FindTls(absl::string_view client_random) {
    const absl::MutexLock lock(&mutex_);
    for (const auto& [fd, entry] : by_fd_) {
      if (entry.client_random == client_random) return entry.watched;
    }
    return nullptr;
  }

  // Its owner sees the end when it reads next.
  void ShutDown(const Watched& watched) {
    const absl::MutexLock lock(&mutex_);
    for (const auto& each : by_fd_) {
      if (each.second.watched == watched && IsOpen(each)) {
        shutdown(each.first, SHUT_RDWR);
      }
    }
  }

 private:
  struct Entry {
    ino_t inode = 0;
    Watched watched;
    // Of TLS, once it is known.
    std::string client_random;
  };

  static bool IsOpen(const std::pair<const int, Entry>& each) {
    return InodeOf(each.first) == each.second.inode;
  }

  // Drops old entries first, which count as connections of their addresses.
  std::shared_ptr<FloodGuard> GuardOf(int port) {
    const absl::MutexLock lock(&mutex_);
    const auto found = guards_.find(port);
    if (found == guards_.end()) return nullptr;
    const auto now = std::chrono::steady_clock::now();
    if (now - swept_ >= std::chrono::seconds(1)) {
      swept_ = now;
      absl::erase_if(by_fd_, [](const auto& each) { return !IsOpen(each); });
    }
    return found->second;
  }

  std::atomic<int> ports_ = 0;
  absl::Mutex mutex_;
  absl::flat_hash_map<int, std::shared_ptr<FloodGuard>> guards_
      ABSL_GUARDED_BY(mutex_);
  absl::flat_hash_map<int, Entry> by_fd_ ABSL_GUARDED_BY(mutex_);
  std::chrono::steady_clock::time_point swept_ ABSL_GUARDED_BY(mutex_);
};

// What recvmsg() has put into the first `size` bytes.
WatchedConnection::Verdict Receive(WatchedConnection& watched,
                                   const msghdr& message, size_t size) {
  auto verdict = WatchedConnection::Verdict::kGoOn;
  for (size_t i = 0; i < message.msg_iovlen && size > 0; ++i) {
    const iovec& piece = message.msg_iov[i];
    const size_t length = std::min(size, piece.iov_len);
    size -= length;
    const auto next = watched.Receive(
        absl::string_view(static_cast<const char*>(piece.iov_base), length));
    if (next == WatchedConnection::Verdict::kCut) return next;
    if (next != WatchedConnection::Verdict::kGoOn) verdict = next;
  }
  return verdict;
}

// Whether what was received may be handed on.
bool MayHandOn(int fd, const Watched& watched, const msghdr& message,
               size_t size) {
  switch (Receive(*watched, message, size)) {
    case WatchedConnection::Verdict::kGoOn:
      return true;
    case WatchedConnection::Verdict::kTlsBegins:
      if (Connections::Get().Claim(fd, watched)) return true;
      watched->Cut(CutReason::kHandshake);
      return false;
    case WatchedConnection::Verdict::kCut:
      return false;
  }
  return false;
}

// Which connection a TLS session belongs to, kept with the session.
class TlsSessions {
 public:
  static TlsSessions& Get() {
    static TlsSessions& sessions = *new TlsSessions;
    return sessions;
  }

  // Null: not watched. Only of a server whose handshake is over.
  Watched Find(SSL* ssl) const {
    if (auto* known = static_cast<Watched*>(SSL_get_ex_data(ssl, index_))) {
      return *known;
    }
    auto* found = new Watched(Search(ssl));
    if (SSL_set_ex_data(ssl, index_, found) != 1) delete found;
    return found == nullptr ? nullptr : *found;
  }

 private:
  TlsSessions()
      : index_(SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, &Free)) {}

  static void Free(void* /*ssl*/, void* known, CRYPTO_EX_DATA* /*data*/,
                   int /*index*/, long /*argl*/, void* /*argp*/) {
    delete static_cast<Watched*>(known);
  }

  static Watched Search(const SSL* ssl) {
    const unsigned char* protocol = nullptr;
    unsigned int length = 0;
    SSL_get0_alpn_selected(ssl, &protocol, &length);
    if (absl::string_view(reinterpret_cast<const char*>(protocol), length) !=
        "h2") {
      return nullptr;
    }
    std::array<unsigned char, SSL3_RANDOM_SIZE> random = {};
    const size_t size =
        SSL_get_client_random(ssl, random.data(), random.size());
    return Connections::Get().FindTls(
        absl::string_view(reinterpret_cast<const char*>(random.data()), size));
  }

  const int index_;
};

using Accept4 = int(int, sockaddr*, socklen_t*, int);
using Recvmsg = ssize_t(int, msghdr*, int);
using SslRead = int(SSL*, void*, int);

int NextAccept4(int fd, sockaddr* address, socklen_t* size, int flags) {
  static Accept4* const next = Next<Accept4>("accept4");
  return next(fd, address, size, flags);
}

ssize_t NextRecvmsg(int fd, msghdr* message, int flags) {
  static Recvmsg* const next = Next<Recvmsg>("recvmsg");
  return next(fd, message, flags);
}

int NextSslRead(SSL* ssl, void* buffer, int size) {
  static SslRead* const next = Next<SslRead>("SSL_read");
  return next(ssl, buffer, size);
}

}  // namespace

GuardedPort::GuardedPort(int port, std::shared_ptr<FloodGuard> guard)
    : port_(port) {
  Connections::Get().AddPort(port_, std::move(guard));
}

GuardedPort::~GuardedPort() { Connections::Get().RemovePort(port_); }

bool GuardedPort::Works() {
  // What every library of the process is bound to.
  return dlsym(RTLD_DEFAULT, "accept4") == reinterpret_cast<void*>(&accept4) &&
         dlsym(RTLD_DEFAULT, "recvmsg") == reinterpret_cast<void*>(&recvmsg) &&
         dlsym(RTLD_DEFAULT, "SSL_read") == reinterpret_cast<void*>(&SSL_read);
}

}  // namespace treeline::flood_guard

// NOLINTBEGIN(readability-identifier-naming,bugprone-reserved-identifier)

extern "C" int accept4(int fd, sockaddr* address, socklen_t* size, int flags) {
  using treeline::flood_guard::Connections;
  const socklen_t room = size == nullptr ? 0 : *size;
  while (true) {
    if (size != nullptr) *size = room;
    const int accepted =
        treeline::flood_guard::NextAccept4(fd, address, size, flags);
    if (accepted < 0 || !Connections::Get().active() ||
        Connections::Get().Adopt(accepted)) {
      return accepted;
    }
    // The next one, then; a listener that never waits ends this.
    close(accepted);
  }
}

extern "C" ssize_t recvmsg(int fd, msghdr* message, int flags) {
  using treeline::flood_guard::Connections;
  const ssize_t size = treeline::flood_guard::NextRecvmsg(fd, message, flags);
  if (!Connections::Get().active() ||
      (flags & (MSG_PEEK | MSG_ERRQUEUE)) != 0) {
    return size;
  }
  if (size <= 0) return size;
  const auto watched = Connections::Get().Find(fd);
  if (watched == nullptr) return size;
  if (treeline::flood_guard::MayHandOn(fd, watched, *message,
                                       static_cast<size_t>(size))) {
    return size;
  }
  errno = ECONNRESET;
  return -1;
}

extern "C" int SSL_read(SSL* ssl, void* buffer, int size) {
  using treeline::flood_guard::Connections;
  const int read = treeline::flood_guard::NextSslRead(ssl, buffer, size);
  if (read <= 0 || !Connections::Get().active() || SSL_is_server(ssl) != 1) {
    return read;
  }
  const auto watched = treeline::flood_guard::TlsSessions::Get().Find(ssl);
  if (watched == nullptr ||
      watched->Decrypted(absl::string_view(static_cast<const char*>(buffer),
                                           static_cast<size_t>(read)))) {
    return read;
  }
  Connections::Get().ShutDown(watched);
  // What else is there is of no use; OpenSSL then says truly that it has
  // nothing more, and whoever asked waits for the socket.
  int more = read;
  while (more > 0) {
    more = treeline::flood_guard::NextSslRead(ssl, buffer, size);
  }
  return more;
}

// NOLINTEND(readability-identifier-naming,bugprone-reserved-identifier)
