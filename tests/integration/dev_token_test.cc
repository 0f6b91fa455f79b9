// scripts/make-dev-token, as docs/reference/security.md shows it.
#include <ctime>
#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gtest/gtest.h"
#include "server/access/fake_clocks.h"
#include "server/access/token_maker.h"
#include "server/access/token_verifier.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

using MakeKey = std::string (*)();

class MakeDevToken : public testing::TestWithParam<MakeKey> {};

INSTANTIATE_TEST_SUITE_P(
    RsaAndEd25519, MakeDevToken,
    testing::Values(MakeKey([] { return access::MakeRsaPrivateKey(); }),
                    MakeKey(&access::MakeEd25519PrivateKey)));

TEST_P(MakeDevToken, MakesATokenThatTheServerTakes) {
  const std::string folder = testing::TempDir() + "/dev-token";
  std::filesystem::create_directories(folder + "/keys");
  const std::string key = GetParam()();
  ASSERT_TRUE(base::WriteFileAtomically(folder + "/mine.key", key).ok());
  ASSERT_TRUE(base::WriteFileAtomically(folder + "/keys/2026-11.pem",
                                        access::PublicKeyOf(key))
                  .ok());
  const ProgramResult made =
      RunProgram({TREELINE_MAKE_DEV_TOKEN, folder + "/mine.key", "2026-11",
                  "robot-7", "localize admin", "600"});
  ASSERT_EQ(made.exit_code, 0) << made.err;

  const access::FakeClock clock;
  const access::FakeWallClock wall(std::time(nullptr));
  const auto keys =
      access::KeyStore::Open({.path = folder + "/keys"}, clock, nullptr);
  ASSERT_TRUE(keys.ok()) << keys.status();
  access::TokenVerifier verifier({}, **keys, wall);
  const auto claims = verifier.Verify(made.out.substr(0, made.out.find('\n')));
  ASSERT_TRUE(claims.ok()) << claims.status();
  EXPECT_EQ(claims->subject, "robot-7");
  EXPECT_TRUE(claims->may_localize);
  EXPECT_TRUE(claims->may_administer);
  EXPECT_NEAR(static_cast<double>(claims->expires_unix_s - wall.UnixSeconds()),
              600, 60);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace treeline
