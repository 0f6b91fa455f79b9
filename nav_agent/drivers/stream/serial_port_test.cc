#include "nav_agent/drivers/stream/serial_port.h"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "common/base/descriptor.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/stream/pty.h"
#include "nav_agent/drivers/stream/testing_streams.h"

namespace treeline::stream {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr milliseconds kSoon(10'000);

std::unique_ptr<Pty> OpenPty(const std::string& symlink = "") {
  auto pty = Pty::Open(symlink);
  EXPECT_TRUE(pty.ok()) << pty.status();
  return pty.ok() ? *std::move(pty) : nullptr;
}

std::unique_ptr<ByteStream> OpenPort(const std::string& path,
                                     int baud = 460800) {
  auto port = OpenSerialPort({.path = path, .baud = baud});
  EXPECT_TRUE(port.ok()) << port.status();
  return port.ok() ? *std::move(port) : nullptr;
}

std::string FreshFolder() {
  const std::string path =
      testing::TempDir() + "/serial_port_test_" + std::to_string(getpid());
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

TEST(SerialPortTest, CarriesEveryByteBothWaysUnchanged) {
  const auto pty = OpenPty();
  const auto port = OpenPort(pty->path());
  std::string all;
  for (int value = 0; value < 256; ++value) {
    all += static_cast<char>(value);
  }
  ASSERT_TRUE(port->Write(AsBytes(all), kSoon).ok());
  EXPECT_EQ(ReadExactly(*pty, all.size()), all);
  ASSERT_TRUE(pty->Write(AsBytes(all), kSoon).ok());
  EXPECT_EQ(ReadExactly(*port, all.size()), all);
}

TEST(SerialPortTest, IsRawAtTheRateAskedFor) {
  const auto pty = OpenPty();
  const auto port = OpenPort(pty->path(), 460800);
  const base::Descriptor fd(open(pty->path().c_str(), O_RDWR | O_NOCTTY));
  struct termios settings = {};
  ASSERT_EQ(tcgetattr(fd.get(), &settings), 0);
  EXPECT_EQ(cfgetospeed(&settings), static_cast<speed_t>(B460800));
  EXPECT_EQ(cfgetispeed(&settings), static_cast<speed_t>(B460800));
  EXPECT_EQ(settings.c_cflag & static_cast<tcflag_t>(CSIZE),
            static_cast<tcflag_t>(CS8));
  EXPECT_EQ(settings.c_cflag & static_cast<tcflag_t>(PARENB | CSTOPB), 0u);
  EXPECT_EQ(settings.c_lflag & static_cast<tcflag_t>(ECHO | ICANON), 0u);
}

TEST(SerialPortTest, ReadsNothingWhenNothingComes) {
  const auto pty = OpenPty();
  const auto port = OpenPort(pty->path());
  std::vector<uint8_t> buffer(16);
  const auto count = port->Read(buffer, milliseconds(1), {});
  ASSERT_TRUE(count.ok()) << count.status();
  EXPECT_EQ(*count, 0u);
}

TEST(SerialPortTest, AStopEndsTheWait) {
  const auto pty = OpenPty();
  const auto port = OpenPort(pty->path());
  size_t count = 99;
  {
    std::jthread reader([&](const std::stop_token& stop) {
      std::vector<uint8_t> buffer(16);
      const auto read = port->Read(buffer, std::chrono::hours(1), stop);
      count = read.ok() ? *read : 98;
    });
  }
  EXPECT_EQ(count, 0u);
}

TEST(SerialPortTest, SaysThatTheDeviceWasUnplugged) {
  auto pty = OpenPty();
  const auto port = OpenPort(pty->path());
  pty.reset();
  std::vector<uint8_t> buffer(16);
  const auto count = port->Read(buffer, kSoon, {});
  EXPECT_EQ(count.status().code(), absl::StatusCode::kUnavailable);
  const absl::Status written = port->Write(AsBytes("BM\n"), kSoon);
  EXPECT_EQ(written.code(), absl::StatusCode::kUnavailable);
}

TEST(SerialPortTest, AWriteThatNobodyTakesEndsInTime) {
  const auto pty = OpenPty();
  const std::string much(100'000, 'x');
  const absl::Status status = pty->Write(AsBytes(much), milliseconds(0));
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("did not take"));
}

TEST(SerialPortTest, ForgetsWhatWaitedBeforeItWasOpened) {
  const auto pty = OpenPty();
  ASSERT_TRUE(pty->Write(AsBytes("of an earlier session"), kSoon).ok());
  const auto port = OpenPort(pty->path());
  ASSERT_TRUE(pty->Write(AsBytes("fresh"), kSoon).ok());
  EXPECT_EQ(ReadExactly(*port, 5), "fresh");
}

TEST(SerialPortTest, IsOpenInOneProgramOnly) {
  const auto pty = OpenPty();
  auto port = OpenPort(pty->path());
  const auto second = OpenSerialPort({.path = pty->path()});
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("another program"));
  port.reset();
  EXPECT_TRUE(OpenSerialPort({.path = pty->path()}).ok());
}

TEST(SerialPortTest, SaysWhatIsWrongWithThePath) {
  const std::string folder = FreshFolder();
  const auto missing = OpenSerialPort({.path = folder + "/ttyACM7"});
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.status().message()), HasSubstr("plugged in"));
  const auto is_folder = OpenSerialPort({.path = folder});
  EXPECT_EQ(is_folder.status().code(), absl::StatusCode::kInvalidArgument);
  const auto no_port = OpenSerialPort({.path = "/dev/null"});
  EXPECT_EQ(no_port.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(no_port.status().message()),
              HasSubstr("not a serial port"));
  EXPECT_EQ(
      OpenSerialPort({.path = "/dev/null", .baud = 12345}).status().code(),
      absl::StatusCode::kInvalidArgument);
}

TEST(PtyTest, ItsSymlinkComesAndGoesWithIt) {
  const std::string link = FreshFolder() + "/ttyLaser";
  auto pty = OpenPty(link);
  EXPECT_EQ(pty->path(), link);
  EXPECT_NE(OpenPort(link), nullptr);
  pty.reset();
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(link)));
}

TEST(PtyTest, ReplacesTheLinkOfOneThatDiedAndLeavesItsSuccessorsAlone) {
  const std::string link = FreshFolder() + "/ttyLaser";
  std::filesystem::create_symlink("/dev/pts/99999", link);
  auto first = OpenPty(link);
  auto second = OpenPty(link);
  const std::string target = std::filesystem::read_symlink(link);
  first.reset();
  EXPECT_EQ(std::filesystem::read_symlink(link), target);
}

TEST(PtyTest, OverwritesNoFile) {
  const std::string file = FreshFolder() + "/precious";
  std::filesystem::create_directory(file);
  EXPECT_EQ(Pty::Open(file).status().code(), absl::StatusCode::kAlreadyExists);
}

TEST(PtyTest, ServesOneProgramAfterAnother) {
  const auto pty = OpenPty();
  for (const char* text : {"first", "again"}) {
    const auto port = OpenPort(pty->path());
    ASSERT_TRUE(port->Write(AsBytes(text), kSoon).ok());
    EXPECT_EQ(ReadExactly(*pty, 5), text);
  }
}

}  // namespace
}  // namespace treeline::stream
