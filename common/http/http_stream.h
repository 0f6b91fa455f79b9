// One connection as bytes: plain or TLS, with limits on time and size.
#ifndef COMMON_HTTP_HTTP_STREAM_H_
#define COMMON_HTTP_HTTP_STREAM_H_

#include <httplib.h>
#include <openssl/ssl.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/http/byte_source.h"
#include "common/http/stream_limits.h"

namespace treeline::http {

// Why reading a request ended early.
enum class StreamFailure {
  kNone,
  kClosed,
  kTimedOut,
  kHeadTooLarge,
  // Not a head of HTTP.
  kMalformed
};

struct SslDeleter {
  void operator()(SSL* ssl) const { SSL_free(ssl); }
};
using UniqueSsl = std::unique_ptr<SSL, SslDeleter>;

// What httplib reads requests from and writes responses to. Deadlines are for
// whole phases, not for single reads: a client that sends a byte at a time has
// no longer than others.
class HttpStream final : public httplib::Stream, public ByteSource {
 public:
  // Owns neither `fd`, which becomes non-blocking, nor `clock`. `ssl`: null
  // for a plain connection.
  HttpStream(int fd, UniqueSsl ssl, const StreamLimits& limits,
             const base::Clock& clock);

  // The TLS handshake, if there is one to do.
  bool Handshake();

  // Waits for the first byte of a request; false: none came in time, or the
  // connection was closed.
  bool WaitForRequest(std::chrono::milliseconds patience);
  // Phases of a request. Each sets the deadline of what follows.
  void BeginHead();
  // Waits for the whole head, which stays to be read; valid until then. Empty:
  // see failure().
  absl::string_view ReadHead();
  void BeginBody();
  // All has been read; nothing is written yet.
  void BeginHandling();
  // What is written from now on has the whole time for itself.
  void BeginPart();
  // Nothing more is read or written.
  void Abandon() { failure_ = StreamFailure::kClosed; }
  StreamFailure failure() const { return failure_; }
  bool has_written() const { return has_written_; }

  // Bytes per second of the head or the body that is arriving; nullopt: none
  // is, or not for long enough to say. From any thread.
  std::optional<double> ArrivalRate(base::MonotonicTime now) const;

  // Whether it is the client's turn: to send more of a request, or to take more
  // of an answer. From any thread.
  bool AwaitsClient() const;

  // What has arrived, without waiting: 0: nothing now; -1: see failure().
  ssize_t ReadAvailable(char* ptr, size_t size);
  // Whether ReadAvailable() has bytes that the system no longer has.
  bool HasBuffered() const;
  // Writes while a body goes on arriving, whose time stands still meanwhile.
  bool WriteBetween(absl::string_view bytes);
  // When what is being read must have gone on.
  base::MonotonicTime deadline() const { return deadline_; }

  // Says that no more will be written, and reads what still comes for up to
  // `patience`: closing with unread bytes would take the response back.
  void Linger(std::chrono::milliseconds patience);

  SSL* ssl() const { return ssl_.get(); }

  // ByteSource.
  ssize_t Read(char* to, size_t size) override { return read(to, size); }

  // httplib::Stream.
  using httplib::Stream::write;
  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* ptr, size_t size) override;
  ssize_t write(const char* ptr, size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  // Not the true one: httplib would refuse those from FD_SETSIZE on, for it
  // means to use select().
  socket_t socket() const override { return 0; }

 private:
  enum class Phase { kHead, kBody, kHandling, kResponse };

  void Enter(Phase phase);
  // Of bodies: when the next byte must have come.
  void ExpectNextPiece();

  // Bytes from the connection, at least one; 0 closed, -1 failed.
  ssize_t Receive(char* ptr, size_t size);
  // The same without waiting: 0: there are none now; -1: none will come.
  ssize_t TryReceive(char* ptr, size_t size);
  ssize_t Send(const char* ptr, size_t size);
  // Waits for poll events until the deadline.
  bool Wait(short events);
  // Waits for what SSL_get_error asks for; false: the connection is lost.
  bool WaitForTls(int result);

  const int fd_;
  const UniqueSsl ssl_;
  const StreamLimits limits_;
  const base::Clock& clock_;
  // These four are read by other threads.
  std::atomic<Phase> phase_ = Phase::kResponse;
  std::atomic<base::MonotonicTime> phase_start_ = base::MonotonicTime();
  std::atomic<size_t> phase_bytes_ = 0;
  std::atomic<bool> waits_ = false;
  // Of the whole phase, and of the read or write at hand.
  base::MonotonicTime phase_deadline_ = base::MonotonicTime::max();
  base::MonotonicTime deadline_ = base::MonotonicTime::max();
  StreamFailure failure_ = StreamFailure::kNone;
  bool has_written_ = false;
  // Read ahead: buffer_[begin_..end_). Grows to the largest head.
  std::vector<char> buffer_;
  size_t begin_ = 0;
  size_t end_ = 0;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_HTTP_STREAM_H_
