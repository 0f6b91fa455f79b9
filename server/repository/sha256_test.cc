#include "server/repository/sha256.h"

#include <string>

#include "common/base/file.h"
#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

// FIPS 180-2, appendix B.1 and B.2.
constexpr char kAbc[] =
    "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr char kTwoBlocks[] =
    "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1";

TEST(Sha256, IsThatOfTheStandard) {
  Sha256 hash;
  hash.Update("abc");
  EXPECT_EQ(hash.Finish(), kAbc);
  hash.Update("abcdbcdecdefdefgefghfghighij");
  hash.Update("hijkijkljklmklmnlmnomnopnopq");
  EXPECT_EQ(hash.Finish(), kTwoBlocks);
}

TEST(Sha256, KnowsItsOwnForm) {
  EXPECT_TRUE(IsSha256(kAbc));
  EXPECT_FALSE(IsSha256(std::string(kAbc).substr(1)));
  EXPECT_FALSE(IsSha256(std::string(kAbc).replace(0, 1, "B")));
  EXPECT_FALSE(IsSha256(std::string(kAbc).replace(0, 1, "/")));
}

TEST(Sha256, OfAFile) {
  const std::string path = testing::TempDir() + "/sha256_test";
  ASSERT_TRUE(base::WriteFileAtomically(path, "abc").ok());
  uint64_t told = 0;
  const auto digest =
      DigestOfFile(path, {}, [&](uint64_t bytes) { told += bytes; });
  ASSERT_TRUE(digest.ok()) << digest.status();
  EXPECT_EQ(digest->sha256, kAbc);
  EXPECT_EQ(digest->bytes, 3u);
  EXPECT_EQ(told, 3u);
  EXPECT_EQ(DigestOfFile(path + "no", {}).status().code(),
            absl::StatusCode::kNotFound);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(DigestOfFile(path, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline::repository
