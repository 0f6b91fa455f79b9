#include "simulation/emulators/emulator_server.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <thread>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/stream/stream_address.h"
#include "simulation/emulators/testing_laser.h"

namespace treeline::emulators {
namespace {

constexpr size_t kLine = 3372;

// Says a numbered line, as long as a scan, every 5 ms.
class Counter final : public EmulatedDevice {
 public:
  void Connect(base::MonotonicTime /*now*/) override {}
  void SetFaults(const ActiveFaults& /*faults*/,
                 base::MonotonicTime /*now*/) override {}
  void Receive(std::span<const uint8_t> /*bytes*/,
               base::MonotonicTime /*now*/) override {}
  std::string TakeOutput(base::MonotonicTime now) override {
    if (now < next_) return "";
    next_ = now + std::chrono::milliseconds(5);
    std::string line = absl::StrCat(++said, " ");
    line.resize(kLine - 1, 'x');
    return line + "\n";
  }
  base::MonotonicTime NextEvent() const override { return next_; }

  std::atomic<int> said = 0;

 private:
  base::MonotonicTime next_{};
};

// Beside other work a reader may be away for longer than the terminal's buffer
// holds what is said meanwhile.
TEST(EmulatorServerTest, ALateReaderMissesWholeLinesAndGetsNoneTorn) {
  const base::SteadyClock clock;
  Counter counter;
  auto server = EmulatorServer::Start({.listen = PtyAddress{}, .faults = {}},
                                      counter, clock);
  ASSERT_TRUE(server.ok()) << server.status();
  auto opener = stream::ParseStreamAddress((*server)->address(), 115200);
  ASSERT_TRUE(opener.ok()) << opener.status();
  auto port = (*opener)->Open({});
  ASSERT_TRUE(port.ok()) << port.status();
  // More than fits: the server waits for this reader in the middle of a line.
  ASSERT_TRUE(Eventually(
      [&] { return (*server)->sent() >= static_cast<int64_t>(5 * kLine); }));
  const int before = counter.said;
  ASSERT_TRUE(Eventually([&] { return counter.said >= before + 5; }));
  std::string text;
  while (text.size() < 40 * kLine) {
    std::array<uint8_t, 4096> buffer = {};
    const auto count =
        (*port)->Read(buffer, std::chrono::milliseconds(10000), {});
    ASSERT_TRUE(count.ok()) << count.status();
    ASSERT_GT(*count, 0u);
    text.append(reinterpret_cast<const char*>(buffer.data()), *count);
  }
  int last = 0;
  int missing = 0;
  size_t begin = text.find('\n') + 1;
  for (size_t end = text.find('\n', begin); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    const std::string line = text.substr(begin, end - begin);
    ASSERT_EQ(line.size(), kLine - 1);
    int number = 0;
    ASSERT_TRUE(absl::SimpleAtoi(line.substr(0, line.find(' ')), &number));
    if (last > 0) missing += number - last - 1;
    ASSERT_GT(number, last);
    last = number;
  }
  EXPECT_GT(missing, 0);
}

}  // namespace
}  // namespace treeline::emulators
