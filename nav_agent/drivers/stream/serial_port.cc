#include "nav_agent/drivers/stream/serial_port.h"

#include <fcntl.h>
#include <grp.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/drivers/stream/descriptor_stream.h"

namespace treeline::stream {
namespace {

std::optional<speed_t> SpeedOf(int baud) {
  switch (baud) {
    case 9600:
      return B9600;
    case 19200:
      return B19200;
    case 38400:
      return B38400;
    case 57600:
      return B57600;
    case 115200:
      return B115200;
    case 230400:
      return B230400;
    case 460800:
      return B460800;
    case 500000:
      return B500000;
    case 576000:
      return B576000;
    case 921600:
      return B921600;
    case 1000000:
      return B1000000;
    case 1500000:
      return B1500000;
    case 2000000:
      return B2000000;
    case 3000000:
      return B3000000;
    case 4000000:
      return B4000000;
    default:
      return std::nullopt;
  }
}

// The group that the device belongs to, which a user must be in.
std::string GroupOf(const std::string& path) {
  struct stat status = {};
  if (stat(path.c_str(), &status) < 0) return "dialout";
  struct group entry = {};
  struct group* found = nullptr;
  char buffer[4096];
  if (getgrgid_r(status.st_gid, &entry, buffer, sizeof(buffer), &found) != 0 ||
      found == nullptr) {
    return absl::StrCat("with number ", status.st_gid);
  }
  return found->gr_name;
}

absl::Status OpenError(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return absl::NotFoundError(absl::StrCat(
          "there is no ", path,
          ": is the device plugged in and switched on? `ls /dev/serial/by-id` "
          "lists what is"));
    case EACCES:
    case EPERM:
      return absl::PermissionDeniedError(absl::StrCat(
          "may not open ", path, ": its users must be in the group ",
          GroupOf(path), " (`sudo usermod -aG ", GroupOf(path),
          " $USER`, then log in again)"));
    case EBUSY:
      return absl::UnavailableError(
          absl::StrCat("another program has ", path, " open"));
    default:
      return SystemError(absl::StatusCode::kUnavailable,
                         absl::StrCat("opening ", path), error);
  }
}

// Linux' pseudo terminals have the major numbers 136 to 143.
bool IsPseudoTerminal(int fd) {
  struct stat status = {};
  return fstat(fd, &status) == 0 && major(status.st_rdev) >= 136 &&
         major(status.st_rdev) <= 143;
}

// The lock is one that other careful programs look for (picocom, pyserial);
// the exclusive mode keeps out those that do not, unless they run as root. It
// would outlive a killed driver on a pseudo terminal that its emulator keeps
// open, so there it is left out.
absl::Status Lock(int fd, const std::string& path) {
  if (flock(fd, LOCK_EX | LOCK_NB) < 0 && errno == EWOULDBLOCK) {
    return OpenError(path, EBUSY);
  }
  if (!IsPseudoTerminal(fd) && ioctl(fd, TIOCEXCL) < 0) {
    return SystemError(absl::StatusCode::kUnavailable,
                       absl::StrCat("locking ", path), errno);
  }
  return absl::OkStatus();
}

absl::Status MakeRaw(int fd, const SerialPortOptions& options) {
  struct termios settings = {};
  if (tcgetattr(fd, &settings) < 0) {
    return SystemError(absl::StatusCode::kUnavailable,
                       absl::StrCat("reading the settings of ", options.path),
                       errno);
  }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | CRTSCTS);
  settings.c_iflag &= ~static_cast<tcflag_t>(IXOFF | IXANY);
  // A read returns what there is; 0 bytes then mean that the port is gone.
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  const speed_t speed = SpeedOf(options.baud).value_or(B115200);
  if (cfsetispeed(&settings, speed) < 0 || cfsetospeed(&settings, speed) < 0 ||
      tcsetattr(fd, TCSANOW, &settings) < 0) {
    return SystemError(
        absl::StatusCode::kInvalidArgument,
        absl::StrCat(options.path, " does not know ", options.baud, " baud"),
        errno);
  }
  return absl::OkStatus();
}

// As good as it gets: what cannot be set is no reason to fail.
void AskForLowLatency(int fd) {
  struct serial_struct serial = {};
  if (ioctl(fd, TIOCGSERIAL, &serial) < 0) return;
  serial.flags |= ASYNC_LOW_LATENCY;
  [[maybe_unused]] const int ignored = ioctl(fd, TIOCSSERIAL, &serial);
}

}  // namespace

absl::Status SerialPortOptions::Validate() const {
  if (path.empty()) {
    return absl::InvalidArgumentError("the serial port has no path");
  }
  if (!SpeedOf(baud)) {
    return absl::InvalidArgumentError(
        absl::StrCat(baud, " baud is not a usual rate (9600 to 4000000)"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<ByteStream>> OpenSerialPort(
    const SerialPortOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  // Non-blocking, or else open() would wait for a modem's carrier.
  const int fd =
      open(options.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    if (errno == EISDIR) {
      return absl::InvalidArgumentError(
          absl::StrCat(options.path, " is a folder, not a serial port"));
    }
    return OpenError(options.path, errno);
  }
  absl::Cleanup close_it = [fd] { close(fd); };
  if (isatty(fd) == 0) {
    // EIO: the other end went away since open().
    if (errno == EIO) return OpenError(options.path, ENODEV);
    return absl::InvalidArgumentError(
        absl::StrCat(options.path, " is not a serial port"));
  }
  TL_RETURN_IF_ERROR(Lock(fd, options.path));
  TL_RETURN_IF_ERROR(MakeRaw(fd, options));
  if (options.low_latency) AskForLowLatency(fd);
  tcflush(fd, TCIOFLUSH);
  std::move(close_it).Cancel();
  return MakeDescriptorStream(fd, options.path);
}

absl::StatusOr<std::unique_ptr<ByteStream>> SerialPortOpener::Open(
    const std::stop_token& stop) {
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  return OpenSerialPort(options_);
}

}  // namespace treeline::stream
