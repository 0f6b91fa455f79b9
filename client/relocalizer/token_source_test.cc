#include "client/relocalizer/token_source.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::relocalizer {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class TokenSourceTest : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  void Put(const std::string& text) const {
    ASSERT_TRUE(base::WriteFileAtomically(path_, text).ok());
  }

  const std::string path_ =
      testing::TempDir() + "/token-" + std::to_string(getpid());
};

TEST_F(TokenSourceTest, WhiteSpaceAroundTheTokenIsNotOfIt) {
  Put("  abc.def-ghi\n");
  EXPECT_EQ(TokenSource::FromFile(path_).value()->Get(), "abc.def-ghi");
}

TEST_F(TokenSourceTest, ANewTokenIsUsedAtOnce) {
  Put("first");
  const auto source = TokenSource::FromFile(path_).value();
  EXPECT_EQ(source->Get(), "first");
  Put("other");
  EXPECT_EQ(source->Get(), "other");
}

TEST_F(TokenSourceTest, WhatIsNoTokenLeavesTheLastOne) {
  Put("first");
  const auto source = TokenSource::FromFile(path_).value();
  Put("");
  EXPECT_EQ(source->Get(), "first");
  Put("two words");
  EXPECT_EQ(source->Get(), "first");
  std::filesystem::remove(path_);
  EXPECT_EQ(source->Get(), "first");
  Put("second");
  EXPECT_EQ(source->Get(), "second");
}

TEST_F(TokenSourceTest, WhatIsNoTokenIsRefusedWithoutSayingWhatItWas) {
  Put("my secret words");
  const absl::Status status = TokenSource::FromFile(path_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), Not(HasSubstr("secret")));
  Put(" \n");
  EXPECT_EQ(TokenSource::FromFile(path_).status().code(),
            absl::StatusCode::kInvalidArgument);
  std::filesystem::remove(path_);
  EXPECT_EQ(TokenSource::FromFile(path_).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(TokenSourceTest, ComesFromTheEnvironmentToo) {
  ASSERT_EQ(setenv("TREELINE_TEST_TOKEN", "abc", 1), 0);
  EXPECT_EQ(TokenSource::FromEnvironment("TREELINE_TEST_TOKEN").value()->Get(),
            "abc");
  ASSERT_EQ(unsetenv("TREELINE_TEST_TOKEN"), 0);
  EXPECT_EQ(TokenSource::FromEnvironment("TREELINE_TEST_TOKEN").status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::relocalizer
