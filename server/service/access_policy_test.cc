#include "server/service/access_policy.h"

#include "common/base/error_info.h"
#include "gtest/gtest.h"

namespace treeline::service {
namespace {

TEST(PeerWithoutPort, LeavesTheAddress) {
  EXPECT_EQ(PeerWithoutPort("ipv4:10.0.0.7:41234"), "ipv4:10.0.0.7");
  EXPECT_EQ(PeerWithoutPort("ipv6:%5B::1%5D:1234"), "ipv6:%5B::1%5D");
  EXPECT_EQ(PeerWithoutPort("ipv6:[fe80::2]:1234"), "ipv6:[fe80::2]");
}

TEST(PeerWithoutPort, DoesNotTakeTheEndOfAnAddressForAPort) {
  EXPECT_EQ(PeerWithoutPort("ipv4:10.0.0.7"), "ipv4:10.0.0.7");
  EXPECT_EQ(PeerWithoutPort("ipv6:%5Bfe80::2%5D"), "ipv6:%5Bfe80::2%5D");
  EXPECT_EQ(PeerWithoutPort("ipv6:[fe80::2]"), "ipv6:[fe80::2]");
  EXPECT_EQ(PeerWithoutPort("ipv6:fe80::2"), "ipv6:fe80::2");
}

TEST(PeerWithoutPort, LeavesWhatHasNoPort) {
  EXPECT_EQ(PeerWithoutPort("unix:/run/a:12"), "unix:/run/a:12");
  EXPECT_EQ(PeerWithoutPort("unix:"), "unix:");
  EXPECT_EQ(PeerWithoutPort("ipv6:"), "ipv6:");
  EXPECT_EQ(PeerWithoutPort(""), "");
}

TEST(OpenAccess, LetsEveryoneLocalizeAndSharesByAddress) {
  OpenAccess access;
  const auto client =
      access.Admit({.peer = "ipv4:10.0.0.7:41234"}, Scope::kLocalize);
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_EQ(client->id, "ipv4:10.0.0.7");
}

TEST(OpenAccess, ShowsNobodyWhatOthersAsked) {
  OpenAccess access;
  for (const bool admin_listener : {false, true}) {
    EXPECT_TRUE(
        absl::IsPermissionDenied(access
                                     .Admit({.peer = "ipv4:127.0.0.1:1",
                                             .admin_listener = admin_listener},
                                            Scope::kInspect)
                                     .status()));
  }
}

TEST(OpenAccess, LetsOperatorsInOnlyThroughTheirListener) {
  OpenAccess access;
  const auto refused = access.Admit({.peer = "ipv4:10.0.0.7:1"}, Scope::kAdmin);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(base::ErrorInfoOf(refused.status()).reason, "ADMIN_LISTENER_ONLY");
  EXPECT_TRUE(access
                  .Admit({.peer = "ipv4:10.0.0.7:1", .admin_listener = true},
                         Scope::kAdmin)
                  .ok());
}

}  // namespace
}  // namespace treeline::service
