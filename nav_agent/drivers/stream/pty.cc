#include "nav_agent/drivers/stream/pty.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/drivers/stream/descriptor_stream.h"

namespace treeline::stream {
namespace {

absl::Status Failed(absl::string_view what) {
  return SystemError(absl::StatusCode::kUnavailable, what, errno);
}

// Where the symlink leads; empty if it is none.
std::string TargetOf(const std::string& symlink) {
  char target[4096];
  const ssize_t size = readlink(symlink.c_str(), target, sizeof(target));
  return size < 0 ? "" : std::string(target, static_cast<size_t>(size));
}

absl::Status MakeSymlink(const std::string& device,
                         const std::string& symlink) {
  struct stat status = {};
  if (lstat(symlink.c_str(), &status) == 0) {
    if (!S_ISLNK(status.st_mode)) {
      return absl::AlreadyExistsError(
          absl::StrCat(symlink, " exists and is not a symlink"));
    }
    if (unlink(symlink.c_str()) < 0) {
      return Failed(absl::StrCat("replacing ", symlink));
    }
  }
  if (::symlink(device.c_str(), symlink.c_str()) < 0) {
    return Failed(absl::StrCat("making the symlink ", symlink));
  }
  return absl::OkStatus();
}

}  // namespace

Pty::Pty(std::unique_ptr<ByteStream> stream, int terminal_fd,
         std::string device, std::string symlink)
    : stream_(std::move(stream)),
      terminal_(terminal_fd),
      device_(std::move(device)),
      symlink_(std::move(symlink)),
      path_(symlink_.empty() ? device_ : symlink_) {}

Pty::~Pty() {
  // Another emulator may have taken the name over meanwhile.
  if (!symlink_.empty() && TargetOf(symlink_) == device_) {
    unlink(symlink_.c_str());
  }
}

absl::StatusOr<std::unique_ptr<Pty>> Pty::Open(const std::string& symlink) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (master < 0) return Failed("opening a pseudo terminal");
  absl::Cleanup close_master = [master] { close(master); };
  char name[128];
  if (grantpt(master) < 0 || unlockpt(master) < 0 ||
      ptsname_r(master, name, sizeof(name)) != 0) {
    return Failed("setting a pseudo terminal up");
  }
  const std::string device = name;
  const int terminal = open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (terminal < 0) return Failed(absl::StrCat("opening ", device));
  absl::Cleanup close_terminal = [terminal] { close(terminal); };
  // Raw from the start, so that nothing is echoed before a driver sets it up.
  struct termios settings = {};
  if (tcgetattr(terminal, &settings) < 0) return Failed(device);
  cfmakeraw(&settings);
  if (tcsetattr(terminal, TCSANOW, &settings) < 0) return Failed(device);
  if (!symlink.empty()) TL_RETURN_IF_ERROR(MakeSymlink(device, symlink));
  std::move(close_master).Cancel();
  TL_ASSIGN_OR_RETURN(auto stream, MakeDescriptorStream(master, device));
  std::move(close_terminal).Cancel();
  return std::unique_ptr<Pty>(
      new Pty(std::move(stream), terminal, device, symlink));
}

absl::StatusOr<size_t> Pty::Read(std::span<uint8_t> buffer,
                                 std::chrono::milliseconds timeout,
                                 const std::stop_token& stop) {
  return stream_->Read(buffer, timeout, stop);
}

absl::StatusOr<size_t> Pty::WriteSome(std::span<const uint8_t> bytes,
                                      std::chrono::milliseconds timeout) {
  return stream_->WriteSome(bytes, timeout);
}

}  // namespace treeline::stream
