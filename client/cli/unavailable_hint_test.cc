#include "client/cli/unavailable_hint.h"

#include <cstdlib>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::client_cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// gRPC 1.51's messages.
TEST(UnavailableHint, NamesWhatAnswersInstead) {
  for (const char* message : {
           "connections to all backends failing; last error: INTERNAL: "
           "ipv4:127.0.0.1:8080: Trying to connect an http1.x server",
           "last error: UNAVAILABLE: ipv4:127.0.0.1:80: Failed parsing HTTP/2",
       }) {
    EXPECT_THAT(UnavailableHint(message, "127.0.0.1:8080"),
                HasSubstr("\"listening on\""));
  }
  EXPECT_THAT(
      UnavailableHint("Tls handshake failed: SSL_ERROR_SSL: error:0A00010B:SSL "
                      "routines::wrong version number",
                      "127.0.0.1:50051"),
      HasSubstr("leave --tls-ca out"));
  EXPECT_THAT(UnavailableHint("Connection refused", "127.0.0.1:1"),
              HasSubstr("running at 127.0.0.1:1"));
}

TEST(UnavailableHint, NamesTheProxyThatIsAsked) {
  setenv("https_proxy", "http://user:secret@proxy:3128", 1);
  const std::string far = UnavailableHint("Connection refused", "robot:50051");
  const std::string here =
      UnavailableHint("Connection refused", "127.0.0.1:50051");
  unsetenv("https_proxy");
  EXPECT_THAT(far, HasSubstr("proxy of https_proxy"));
  EXPECT_THAT(far, Not(HasSubstr("secret")));
  EXPECT_THAT(here, Not(HasSubstr("proxy")));
  EXPECT_THAT(UnavailableHint("Connection refused", "robot:50051"),
              Not(HasSubstr("proxy")));
}

}  // namespace
}  // namespace treeline::client_cli
