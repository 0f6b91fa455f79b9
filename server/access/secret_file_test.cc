#include "server/access/secret_file.h"

#include <sys/stat.h>

#include <string>
#include <vector>

#include "common/base/file.h"
#include "gtest/gtest.h"

namespace treeline::access {
namespace {

class SecretFileTest : public testing::Test {
 protected:
  SecretFileTest() : path_(testing::TempDir() + "/secret") {
    EXPECT_TRUE(base::WriteFileAtomically(path_, "hush").ok());
  }

  std::string path_;
  std::vector<std::string> warnings_;
  TrustLog log_ = [this](TrustSeverity /*severity*/,
                         const std::string& message) {
    warnings_.push_back(message);
  };
};

TEST_F(SecretFileTest, WarnsOfAFileThatEveryoneMayRead) {
  ASSERT_EQ(chmod(path_.c_str(), 0644), 0);
  const auto secret = ReadSecretFile(path_, log_);
  ASSERT_TRUE(secret.ok());
  EXPECT_EQ(*secret, "hush");
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find(path_), std::string::npos);
  EXPECT_EQ(warnings_[0].find("hush"), std::string::npos);
}

TEST_F(SecretFileTest, IsQuietAboutOneThatFewMayRead) {
  ASSERT_EQ(chmod(path_.c_str(), 0640), 0);
  EXPECT_TRUE(ReadSecretFile(path_, log_).ok());
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(SecretFileTest, ReportsOneThatIsNotThere) {
  EXPECT_EQ(ReadSecretFile(path_ + "-none", log_).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::access
