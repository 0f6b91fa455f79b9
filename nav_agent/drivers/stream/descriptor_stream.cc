#include "nav_agent/drivers/stream/descriptor_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>

#include "absl/strings/str_cat.h"
#include "common/base/descriptor.h"
#include "common/base/status_macros.h"

namespace treeline::stream {
namespace {

using std::chrono::milliseconds;
using SteadyTime = std::chrono::steady_clock::time_point;

class DescriptorStream final : public ByteStream {
 public:
  DescriptorStream(int fd, bool is_socket, std::string name)
      : fd_(fd), is_socket_(is_socket), name_(std::move(name)) {}

  absl::StatusOr<size_t> Read(std::span<uint8_t> buffer, milliseconds timeout,
                              const std::stop_token& stop) override;
  absl::StatusOr<size_t> WriteSome(std::span<const uint8_t> bytes,
                                   milliseconds timeout) override;
  std::string Name() const override { return name_; }

 private:
  // Of one call; -1 with errno.
  ssize_t WriteOnce(std::span<const uint8_t> bytes) const;

  base::Descriptor fd_;
  bool is_socket_;
  std::string name_;
};

milliseconds Remaining(SteadyTime deadline) {
  const auto left = deadline - std::chrono::steady_clock::now();
  return std::max(milliseconds(0), std::chrono::ceil<milliseconds>(left));
}

// A terminal says EIO when its other end is closed or unplugged.
absl::Status Gone(absl::string_view name, absl::string_view doing, int error) {
  if (error == EIO) {
    return absl::UnavailableError(
        absl::StrCat(name, " is gone: unplugged, or closed at its other end"));
  }
  return SystemError(absl::StatusCode::kUnavailable,
                     absl::StrCat(doing, " ", name), error);
}

absl::StatusOr<size_t> DescriptorStream::Read(std::span<uint8_t> buffer,
                                              milliseconds timeout,
                                              const std::stop_token& stop) {
  const SteadyTime deadline = std::chrono::steady_clock::now() + timeout;
  while (!stop.stop_requested()) {
    const ssize_t count = read(fd_.get(), buffer.data(), buffer.size());
    if (count > 0) return static_cast<size_t>(count);
    if (count == 0) {
      return absl::UnavailableError(
          absl::StrCat(name_, " was closed by its other side"));
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) {
      return Gone(name_, "reading from", errno);
    }
    TL_ASSIGN_OR_RETURN(
        const WaitOutcome outcome,
        WaitForDescriptor(fd_.get(), POLLIN, Remaining(deadline), stop));
    if (outcome != WaitOutcome::kReady) return 0;
  }
  return 0;
}

ssize_t DescriptorStream::WriteOnce(std::span<const uint8_t> bytes) const {
  // A socket whose peer is gone must not raise SIGPIPE.
  if (is_socket_) {
    return send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  return write(fd_.get(), bytes.data(), bytes.size());
}

absl::StatusOr<size_t> DescriptorStream::WriteSome(
    std::span<const uint8_t> bytes, milliseconds timeout) {
  const SteadyTime deadline = std::chrono::steady_clock::now() + timeout;
  size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t count = WriteOnce(bytes.subspan(written));
    if (count > 0) {
      written += static_cast<size_t>(count);
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) {
      return Gone(name_, "writing to", errno);
    }
    TL_ASSIGN_OR_RETURN(
        const WaitOutcome outcome,
        WaitForDescriptor(fd_.get(), POLLOUT, Remaining(deadline), {}));
    if (outcome != WaitOutcome::kReady) break;
  }
  return written;
}

}  // namespace

absl::Status ByteStream::Write(std::span<const uint8_t> bytes,
                               milliseconds timeout) {
  TL_ASSIGN_OR_RETURN(const size_t written, WriteSome(bytes, timeout));
  if (written == bytes.size()) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat(Name(), " did not take ", bytes.size() - written,
                   " bytes within ", timeout.count(), " ms"));
}

absl::Status SystemError(absl::StatusCode code, absl::string_view message,
                         int error) {
  return {code, absl::StrCat(message, ": ", std::strerror(error))};
}

absl::StatusOr<std::unique_ptr<ByteStream>> MakeDescriptorStream(
    int fd, std::string name) {
  struct stat status = {};
  const int flags = fcntl(fd, F_GETFL);
  if (flags < 0 || fcntl(fd, F_SETFL, flags | O_NONBLOCK) < 0 ||
      fstat(fd, &status) < 0) {
    const int error = errno;
    close(fd);
    return SystemError(absl::StatusCode::kUnavailable, name, error);
  }
  return std::make_unique<DescriptorStream>(fd, S_ISSOCK(status.st_mode),
                                            std::move(name));
}

absl::StatusOr<
    std::pair<std::unique_ptr<ByteStream>, std::unique_ptr<ByteStream>>>
MakeStreamPair() {
  int fds[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds) < 0) {
    return SystemError(absl::StatusCode::kUnavailable, "socketpair", errno);
  }
  auto first = MakeDescriptorStream(fds[0], "first of a pair");
  auto second = MakeDescriptorStream(fds[1], "second of a pair");
  if (!first.ok()) return first.status();
  if (!second.ok()) return second.status();
  return std::make_pair(*std::move(first), *std::move(second));
}

absl::StatusOr<WaitOutcome> WaitForDescriptor(int fd, short events,
                                              milliseconds timeout,
                                              const std::stop_token& stop) {
  // A request to stop makes an event of its own, which ends poll(). Where none
  // can come, poll() is to ignore the second entry: a negative descriptor.
  const bool may_stop = stop.stop_possible();
  const base::Descriptor wake(may_stop ? eventfd(0, EFD_CLOEXEC) : -1);
  if (may_stop && wake.get() < 0) {
    return SystemError(absl::StatusCode::kUnavailable, "eventfd", errno);
  }
  const std::stop_callback on_stop(stop, [&wake] {
    const uint64_t one = 1;
    // An eventfd takes its first count whatever happens.
    [[maybe_unused]] const ssize_t written =
        write(wake.get(), &one, sizeof(one));
  });
  const SteadyTime deadline = std::chrono::steady_clock::now() + timeout;
  while (true) {
    struct pollfd polled[2] = {
        {.fd = fd, .events = events, .revents = 0},
        {.fd = wake.get(), .events = POLLIN, .revents = 0}};
    const auto wait_ms =
        std::min<int64_t>(Remaining(deadline).count(), 1'000'000'000);
    const int ready = poll(polled, 2, static_cast<int>(wait_ms));
    if (ready < 0) {
      if (errno == EINTR) continue;
      return SystemError(absl::StatusCode::kUnavailable, "poll", errno);
    }
    if (polled[1].revents != 0) return WaitOutcome::kStopped;
    if (polled[0].revents != 0) return WaitOutcome::kReady;
    if (ready == 0 && Remaining(deadline).count() == 0) {
      return WaitOutcome::kTimedOut;
    }
  }
}

bool StopRequestedWithin(std::chrono::nanoseconds duration,
                         const std::stop_token& stop) {
  // The one place where absl::Mutex does not serve: it knows no stop tokens.
  std::mutex mutex;
  std::condition_variable_any changed;
  std::unique_lock lock(mutex);
  changed.wait_for(lock, stop, duration, [] { return false; });
  return stop.stop_requested();
}

}  // namespace treeline::stream
