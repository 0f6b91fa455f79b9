#include "nav_agent/drivers/stream/stream_address.h"

#include <string>

#include "gtest/gtest.h"

namespace treeline::stream {
namespace {

std::string NameOf(absl::string_view text, int default_port = 10940) {
  const auto opener = ParseStreamAddress(text, 115200, default_port);
  return opener.ok() ? (*opener)->Name()
                     : std::string(opener.status().message());
}

TEST(StreamAddressTest, UnderstandsSerialPorts) {
  EXPECT_EQ(NameOf("/dev/ttyACM0"), "/dev/ttyACM0");
  EXPECT_EQ(NameOf("/dev/ttyUSB0@460800"), "/dev/ttyUSB0");
  EXPECT_EQ(NameOf("/dev/serial/by-id/usb-a@b-if00"),
            "/dev/serial/by-id/usb-a@b-if00");
}

TEST(StreamAddressTest, UnderstandsTcp) {
  EXPECT_EQ(NameOf("tcp:192.168.0.10"), "tcp:192.168.0.10:10940");
  EXPECT_EQ(NameOf("tcp:laser.local:4000"), "tcp:laser.local:4000");
  EXPECT_EQ(NameOf("tcp:[::1]:4000"), "tcp:[::1]:4000");
  EXPECT_EQ(NameOf("tcp:[::1]"), "tcp:[::1]:10940");
}

TEST(StreamAddressTest, SaysWhatIsWrong) {
  for (const char* text :
       {"", "ttyACM0", "tcp:", "tcp::10", "tcp:a:b", "tcp:a:0", "tcp:a:65536",
        "tcp:[::1", "tcp:[::1]10", "/dev/ttyUSB0@17", "udp:a:1"}) {
    const auto opener = ParseStreamAddress(text, 115200, 10940);
    EXPECT_EQ(opener.status().code(), absl::StatusCode::kInvalidArgument)
        << text;
  }
  EXPECT_FALSE(ParseStreamAddress("tcp:host", 115200).ok());
}

}  // namespace
}  // namespace treeline::stream
