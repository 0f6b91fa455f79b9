#include "server/app/healthcheck.h"

#include <string>

#include "gtest/gtest.h"

namespace treeline::server_app {
namespace {

TEST(Healthcheck, EncodesTheServiceAsField1) {
  EXPECT_EQ(EncodeHealthRequest(""), "");
  EXPECT_EQ(EncodeHealthRequest("scene/a"), "\x0a\x07scene/a");
  // Lengths over 127 take two bytes.
  const std::string long_name(300, 'x');
  EXPECT_EQ(EncodeHealthRequest(long_name), "\x0a\xac\x02" + long_name);
}

TEST(Healthcheck, DecodesTheStatus) {
  EXPECT_EQ(*DecodeHealthResponse(""), 0);
  EXPECT_EQ(*DecodeHealthResponse("\x08\x01"), 1);
  EXPECT_EQ(*DecodeHealthResponse("\x08\x02"), 2);
  // A field that came later is passed over.
  EXPECT_EQ(*DecodeHealthResponse("\x12\x02hi\x08\x01"), 1);
}

TEST(Healthcheck, OtherBytesAreNoAnswer) {
  EXPECT_FALSE(DecodeHealthResponse("\x08").ok());
  EXPECT_FALSE(DecodeHealthResponse("\x12\x7fhi").ok());
  EXPECT_FALSE(DecodeHealthResponse("\xff\xff\xff\xff\xff\xff").ok());
  EXPECT_FALSE(DecodeHealthResponse(std::string("\x00\x01", 2)).ok());
}

TEST(Healthcheck, NobodyThereIsUnhealthy) {
  // Port 1 of loopback: nothing listens there.
  const absl::Status status =
      CheckHealth({.server = "127.0.0.1:1", .timeout_s = 30});
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
}

TEST(Healthcheck, MissingFilesAreNamed) {
  const absl::Status status = CheckHealth({.tls_ca = "/nowhere/ca.pem"});
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
}

}  // namespace
}  // namespace treeline::server_app
