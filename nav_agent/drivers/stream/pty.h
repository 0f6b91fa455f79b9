// Pseudo terminals: a serial port whose other end is a program. For emulators
// and tests.
#ifndef NAV_AGENT_DRIVERS_STREAM_PTY_H_
#define NAV_AGENT_DRIVERS_STREAM_PTY_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/base/descriptor.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::stream {

// The device's end. Programs open path() as a serial port, one after another
// as they like. Destroying it is pulling the plug: they find the port gone.
//
// Nobody can tell from this end whether a program has the port open: what is
// written meanwhile waits for the next one until the system's buffer (20 KiB
// of Linux 6.18) is full, and of what is written then only a part may fit.
class Pty final : public ByteStream {
 public:
  // `symlink`, unless empty, is made to lead to the terminal, such as
  // /tmp/ttyLaser; a link that is there already is replaced, anything else is
  // ALREADY_EXISTS. UNAVAILABLE with the system's reason.
  static absl::StatusOr<std::unique_ptr<Pty>> Open(
      const std::string& symlink = "");
  ~Pty() override;

  // The symlink if there is one, else /dev/pts/N.
  const std::string& path() const { return path_; }

  absl::StatusOr<size_t> Read(std::span<uint8_t> buffer,
                              std::chrono::milliseconds timeout,
                              const std::stop_token& stop) override;
  absl::StatusOr<size_t> WriteSome(std::span<const uint8_t> bytes,
                                   std::chrono::milliseconds timeout) override;
  std::string Name() const override { return path_; }

 private:
  Pty(std::unique_ptr<ByteStream> stream, int terminal_fd, std::string device,
      std::string symlink);

  std::unique_ptr<ByteStream> stream_;
  // Held open, since otherwise the first program that closes the port would
  // hang it up for good.
  base::Descriptor terminal_;
  std::string device_;
  std::string symlink_;
  std::string path_;
};

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_PTY_H_
