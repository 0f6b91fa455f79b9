#include "common/http/http_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <openssl/err.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

#include "common/http/request_head.h"

namespace treeline::http {
namespace {

constexpr size_t kBufferBytes = 16384;
// Before that nothing is said about how fast a request arrives.
constexpr std::chrono::milliseconds kTimeToJudge{1000};

using NameOfEnd = int (*)(int, sockaddr*, socklen_t*);

void IpAndPort(int fd, NameOfEnd name_of_end, std::string& ip, int& port) {
  sockaddr_storage address{};
  socklen_t length = sizeof(address);
  if (name_of_end(fd, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    return;
  }
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.ss_family == AF_INET) {
    const auto* v4 = reinterpret_cast<const sockaddr_in*>(&address);
    inet_ntop(AF_INET, &v4->sin_addr, text.data(), text.size());
    port = ntohs(v4->sin_port);
  } else if (address.ss_family == AF_INET6) {
    const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&address);
    inet_ntop(AF_INET6, &v6->sin6_addr, text.data(), text.size());
    port = ntohs(v6->sin6_port);
  }
  ip = text.data();
}

}  // namespace

HttpStream::HttpStream(int fd, UniqueSsl ssl, const StreamLimits& limits,
                       const base::Clock& clock)
    : fd_(fd),
      ssl_(std::move(ssl)),
      limits_(limits),
      clock_(clock),
      buffer_(kBufferBytes) {
  fcntl(fd_, F_SETFL, fcntl(fd_, F_GETFL) | O_NONBLOCK);
  if (ssl_ != nullptr) {
    SSL_set_mode(ssl_.get(), SSL_MODE_ENABLE_PARTIAL_WRITE |
                                 SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    SSL_set_fd(ssl_.get(), fd_);
  }
}

bool HttpStream::Handshake() {
  if (ssl_ == nullptr) return true;
  deadline_ = clock_.Now() + limits_.head_timeout;
  for (;;) {
    // SSL_get_error() looks at what is left of earlier failures too.
    ERR_clear_error();
    const int result = SSL_accept(ssl_.get());
    if (result == 1) return true;
    if (!WaitForTls(result)) return false;
  }
}

bool HttpStream::WaitForRequest(std::chrono::milliseconds patience) {
  if (begin_ < end_) return true;
  deadline_ = clock_.Now() + patience;
  const ssize_t received = Receive(buffer_.data(), buffer_.size());
  if (received <= 0) return false;
  begin_ = 0;
  end_ = static_cast<size_t>(received);
  return true;
}

void HttpStream::Enter(Phase phase) {
  phase_bytes_ = 0;
  phase_start_ = clock_.Now();
  phase_ = phase;
}

void HttpStream::BeginHead() {
  Enter(Phase::kHead);
  failure_ = StreamFailure::kNone;
  has_written_ = false;
  deadline_ = clock_.Now() + limits_.head_timeout;
}

absl::string_view HttpStream::ReadHead() {
  // To the front, so that all of the buffer is there for it.
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  HeadScanner scanner;
  for (;;) {
    const absl::string_view bytes(buffer_.data(), end_);
    switch (scanner.Scan(bytes.substr(0, limits_.head_bytes))) {
      case HeadScanner::Verdict::kComplete:
        return bytes.substr(0, scanner.end());
      case HeadScanner::Verdict::kMalformed:
        failure_ = StreamFailure::kMalformed;
        return {};
      case HeadScanner::Verdict::kIncomplete:
        break;
    }
    if (end_ >= limits_.head_bytes) {
      failure_ = StreamFailure::kHeadTooLarge;
      return {};
    }
    if (end_ == buffer_.size()) buffer_.resize(2 * buffer_.size());
    const ssize_t got = Receive(buffer_.data() + end_, buffer_.size() - end_);
    if (got <= 0) return {};
    end_ += static_cast<size_t>(got);
    phase_bytes_ += static_cast<size_t>(got);
  }
}

void HttpStream::BeginBody() {
  Enter(Phase::kBody);
  phase_deadline_ = clock_.Now() + limits_.body_timeout;
  ExpectNextPiece();
}

void HttpStream::ExpectNextPiece() {
  const std::chrono::duration<double> for_bytes(
      static_cast<double>(phase_bytes_) / limits_.min_body_bytes_per_s);
  deadline_ = std::min(
      phase_deadline_,
      phase_start_.load() + limits_.body_rate_grace +
          std::chrono::duration_cast<base::MonotonicTime::duration>(for_bytes));
}

void HttpStream::BeginHandling() { Enter(Phase::kHandling); }

void HttpStream::BeginPart() {
  Enter(Phase::kResponse);
  deadline_ = clock_.Now() + limits_.write_timeout;
}

std::optional<double> HttpStream::ArrivalRate(base::MonotonicTime now) const {
  const Phase phase = phase_;
  const auto elapsed = now - phase_start_.load();
  if ((phase != Phase::kHead && phase != Phase::kBody) ||
      elapsed < kTimeToJudge) {
    return std::nullopt;
  }
  return static_cast<double>(phase_bytes_) /
         std::chrono::duration<double>(elapsed).count();
}

bool HttpStream::AwaitsClient() const {
  const Phase phase = phase_;
  return waits_ || phase == Phase::kHead || phase == Phase::kBody;
}

void HttpStream::Linger(std::chrono::milliseconds patience) {
  if (ssl_ != nullptr) SSL_shutdown(ssl_.get());
  shutdown(fd_, SHUT_WR);
  deadline_ = clock_.Now() + patience;
  for (;;) {
    const ssize_t received = recv(fd_, buffer_.data(), buffer_.size(), 0);
    if (received > 0) {
      if (clock_.Now() >= deadline_) return;
    } else if (received == 0 || (errno != EAGAIN && errno != EINTR) ||
               !Wait(POLLIN)) {
      return;
    }
  }
}

ssize_t HttpStream::read(char* ptr, size_t size) {
  if (failure_ != StreamFailure::kNone) return -1;
  ssize_t got = 0;
  if (begin_ == end_ && size >= kBufferBytes) {
    got = Receive(ptr, size);
    if (got <= 0) return got;
  } else {
    if (begin_ == end_) {
      const ssize_t received = Receive(buffer_.data(), buffer_.size());
      if (received <= 0) return received;
      begin_ = 0;
      end_ = static_cast<size_t>(received);
    }
    const size_t taken = std::min(size, end_ - begin_);
    std::memcpy(ptr, buffer_.data() + begin_, taken);
    begin_ += taken;
    got = static_cast<ssize_t>(taken);
  }
  if (phase_ == Phase::kBody) {
    phase_bytes_ += static_cast<size_t>(got);
    ExpectNextPiece();
  }
  return got;
}

ssize_t HttpStream::ReadAvailable(char* ptr, size_t size) {
  if (failure_ != StreamFailure::kNone) return -1;
  if (phase_ == Phase::kBody && clock_.Now() >= deadline_) {
    failure_ = StreamFailure::kTimedOut;
    return -1;
  }
  ssize_t got = 0;
  if (begin_ < end_) {
    const size_t taken = std::min(size, end_ - begin_);
    std::memcpy(ptr, buffer_.data() + begin_, taken);
    begin_ += taken;
    got = static_cast<ssize_t>(taken);
  } else {
    got = TryReceive(ptr, size);
    if (got < 0) return -1;
  }
  if (phase_ == Phase::kBody) {
    phase_bytes_ += static_cast<size_t>(got);
    ExpectNextPiece();
  }
  return got;
}

bool HttpStream::HasBuffered() const {
  return begin_ < end_ || (ssl_ != nullptr && SSL_pending(ssl_.get()) > 0);
}

bool HttpStream::WriteBetween(absl::string_view bytes) {
  const Phase phase = phase_;
  const base::MonotonicTime phase_start = phase_start_;
  const size_t phase_bytes = phase_bytes_;
  const base::MonotonicTime begin = clock_.Now();
  BeginPart();
  const bool is_sent = write(bytes.data(), bytes.size()) >= 0;
  if (phase == Phase::kBody) {
    const auto taken = clock_.Now() - begin;
    phase_deadline_ += taken;
    phase_bytes_ = phase_bytes;
    phase_start_ = phase_start + taken;
    phase_ = phase;
    ExpectNextPiece();
  }
  return is_sent;
}

ssize_t HttpStream::TryReceive(char* ptr, size_t size) {
  if (ssl_ != nullptr) {
    ERR_clear_error();
    const int result = SSL_read(
        ssl_.get(), ptr, static_cast<int>(std::min<size_t>(size, INT_MAX)));
    if (result > 0) return result;
    const int error = SSL_get_error(ssl_.get(), result);
    if (error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE) return 0;
  } else {
    const ssize_t result = recv(fd_, ptr, size, 0);
    if (result > 0) return result;
    if (result < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  }
  failure_ = StreamFailure::kClosed;
  return -1;
}

ssize_t HttpStream::write(const char* ptr, size_t size) {
  if (failure_ == StreamFailure::kClosed) return -1;
  if (phase_ != Phase::kResponse) BeginPart();
  size_t sent = 0;
  while (sent < size) {
    const ssize_t result = Send(ptr + sent, size - sent);
    if (result <= 0) return -1;
    sent += static_cast<size_t>(result);
    has_written_ = true;
  }
  return static_cast<ssize_t>(sent);
}

void HttpStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  IpAndPort(fd_, &getpeername, ip, port);
}

void HttpStream::get_local_ip_and_port(std::string& ip, int& port) const {
  IpAndPort(fd_, &getsockname, ip, port);
}

ssize_t HttpStream::Receive(char* ptr, size_t size) {
  for (;;) {
    // Also where bytes keep coming: a steady trickle never has to wait.
    if (clock_.Now() >= deadline_) {
      failure_ = StreamFailure::kTimedOut;
      return -1;
    }
    if (ssl_ != nullptr) {
      ERR_clear_error();
      const int result = SSL_read(
          ssl_.get(), ptr, static_cast<int>(std::min<size_t>(size, INT_MAX)));
      if (result > 0) return result;
      if (!WaitForTls(result)) return -1;
      continue;
    }
    const ssize_t result = recv(fd_, ptr, size, 0);
    if (result > 0) return result;
    if (result < 0 && errno == EINTR) continue;
    if (result == 0 || errno != EAGAIN) {
      failure_ = StreamFailure::kClosed;
      return result;
    }
    if (!Wait(POLLIN)) return -1;
  }
}

ssize_t HttpStream::Send(const char* ptr, size_t size) {
  for (;;) {
    if (ssl_ != nullptr) {
      ERR_clear_error();
      const int result = SSL_write(
          ssl_.get(), ptr, static_cast<int>(std::min<size_t>(size, INT_MAX)));
      if (result > 0) return result;
      if (!WaitForTls(result)) return -1;
      continue;
    }
    const ssize_t result = send(fd_, ptr, size, MSG_NOSIGNAL);
    if (result >= 0) return result;
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !Wait(POLLOUT)) return -1;
  }
}

bool HttpStream::Wait(short events) {
  for (;;) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline_ - clock_.Now());
    if (left.count() <= 0) {
      failure_ = StreamFailure::kTimedOut;
      return false;
    }
    pollfd polled{.fd = fd_, .events = events, .revents = 0};
    waits_ = true;
    const int result = poll(
        &polled, 1, static_cast<int>(std::min<int64_t>(left.count(), INT_MAX)));
    waits_ = false;
    if (result > 0) return true;
    if (result < 0 && errno != EINTR) return false;
  }
}

bool HttpStream::WaitForTls(int result) {
  switch (SSL_get_error(ssl_.get(), result)) {
    case SSL_ERROR_WANT_READ:
      return Wait(POLLIN);
    case SSL_ERROR_WANT_WRITE:
      return Wait(POLLOUT);
    default:
      failure_ = StreamFailure::kClosed;
      return false;
  }
}

}  // namespace treeline::http
