#include "server/access/key_store.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/access/fake_clocks.h"
#include "server/access/token_maker.h"

namespace treeline::access {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class KeyStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/keys-" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    path_ = folder_ + "/jwks.json";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Put(const std::string& path, const std::string& bytes) {
    ASSERT_TRUE(base::WriteFileAtomically(path, bytes).ok());
  }

  absl::StatusOr<std::unique_ptr<KeyStore>> Open(const std::string& path) {
    return KeyStore::Open(
        {.path = path,
         .algorithms = {JwtAlgorithm::kEs256, JwtAlgorithm::kHs256}},
        clock_, [this](TrustSeverity, const std::string& message) {
          log_.push_back(message);
        });
  }

  static std::vector<std::string> Ids(KeyStore& store) {
    std::vector<std::string> ids;
    for (const JwtKey& key : store.Current().keys->keys()) {
      ids.push_back(key.id);
    }
    return ids;
  }

  std::string folder_;
  std::string path_;
  FakeClock clock_;
  std::vector<std::string> log_;
  const std::string a_ = EcJwk(MakeEcPrivateKey(), "a");
  const std::string b_ = EcJwk(MakeEcPrivateKey(), "b");
};

TEST_F(KeyStoreTest, TakesNewKeysAndDropsOldOnesWithinTheInterval) {
  Put(path_, Jwks({a_}));
  const auto store = Open(path_);
  ASSERT_TRUE(store.ok()) << store.status();
  const KeyStore::Snapshot old = (*store)->Current();
  EXPECT_THAT(Ids(**store), ElementsAre("a"));

  Put(path_, Jwks({b_}));
  clock_.Advance(milliseconds(999));
  EXPECT_THAT(Ids(**store), ElementsAre("a"));
  clock_.Advance(milliseconds(1));
  EXPECT_THAT(Ids(**store), ElementsAre("b"));
  EXPECT_NE((*store)->Current().generation, old.generation);
  // Who still works with the old keys can.
  EXPECT_EQ(old.keys->keys()[0].id, "a");
  EXPECT_THAT(log_, ElementsAre(HasSubstr("read again")));
}

TEST_F(KeyStoreTest, KeepsTheGenerationWhileNothingChanges) {
  Put(path_, Jwks({a_}));
  const auto store = Open(path_);
  ASSERT_TRUE(store.ok());
  const uint64_t generation = (*store)->Current().generation;
  Put(path_, Jwks({a_}));
  clock_.Advance(seconds(2));
  EXPECT_EQ((*store)->Current().generation, generation);
  EXPECT_THAT(log_, IsEmpty());
}

TEST_F(KeyStoreTest, KeepsTheOldKeysWhenTheNewOnesAreBrokenAndSaysSoOnce) {
  Put(path_, Jwks({a_}));
  const auto store = Open(path_);
  ASSERT_TRUE(store.ok());
  Put(path_, Jwks({b_}).substr(0, 40));
  for (int i = 0; i < 3; ++i) {
    clock_.Advance(seconds(1));
    EXPECT_THAT(Ids(**store), ElementsAre("a"));
  }
  std::filesystem::remove(path_);
  clock_.Advance(seconds(1));
  EXPECT_THAT(Ids(**store), ElementsAre("a"));
  EXPECT_THAT(log_, ElementsAre(HasSubstr(path_), HasSubstr(path_)));

  Put(path_, Jwks({b_}));
  clock_.Advance(seconds(1));
  EXPECT_THAT(Ids(**store), ElementsAre("b"));
}

// The same size, and within what a file's time can tell apart.
TEST_F(KeyStoreTest, SeesAFileThatWasWrittenInPlaceAtOnce) {
  Put(path_, Jwks({a_}));
  const auto store = Open(path_);
  ASSERT_TRUE(store.ok());
  struct stat before = {};
  ASSERT_EQ(stat(path_.c_str(), &before), 0);
  ASSERT_EQ(Jwks({a_}).size(), Jwks({b_}).size());
  Put(path_, Jwks({b_}));
  const timespec times[] = {before.st_atim, before.st_mtim};
  ASSERT_EQ(utimensat(AT_FDCWD, path_.c_str(), times, 0), 0);
  clock_.Advance(seconds(1));
  EXPECT_THAT(Ids(**store), ElementsAre("b"));
}

TEST_F(KeyStoreTest, ReadsAFolderOfPublicKeys) {
  const std::string ec = PublicKeyOf(MakeEcPrivateKey());
  Put(folder_ + "/2026-11.pem", ec);
  Put(folder_ + "/README", "not a key");
  const auto store = Open(folder_);
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_THAT(Ids(**store), ElementsAre("2026-11"));

  Put(folder_ + "/2026-12.pem", PublicKeyOf(MakeEcPrivateKey()));
  clock_.Advance(seconds(1));
  EXPECT_THAT(Ids(**store), ElementsAre("2026-11", "2026-12"));
  std::filesystem::remove(folder_ + "/2026-11.pem");
  clock_.Advance(seconds(1));
  EXPECT_THAT(Ids(**store), ElementsAre("2026-12"));
}

TEST_F(KeyStoreTest, RefusesToStartWithoutUsableKeys) {
  EXPECT_EQ(Open(folder_ + "/none").status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(Open(folder_).status().code(), absl::StatusCode::kInvalidArgument);
  Put(path_, "nonsense");
  EXPECT_THAT(Open(path_).status().message(), HasSubstr(path_));
  Put(folder_ + "/mine.pem", MakeEcPrivateKey());
  EXPECT_THAT(Open(folder_).status().message(), HasSubstr("private key"));
}

TEST_F(KeyStoreTest, WarnsOfSecretsThatEveryoneMayRead) {
  Put(path_, Jwks({a_}));
  ASSERT_EQ(chmod(path_.c_str(), 0644), 0);
  ASSERT_TRUE(Open(path_).ok());
  EXPECT_THAT(log_, IsEmpty());  // public keys
  Put(path_, Jwks({SecretJwk(std::string(32, 's'), "h")}));
  ASSERT_EQ(chmod(path_.c_str(), 0644), 0);
  ASSERT_TRUE(Open(path_).ok());
  EXPECT_THAT(log_, ElementsAre(HasSubstr("chmod 600")));
}

TEST(KeyStoreOptions, NameWhatIsMissing) {
  EXPECT_FALSE(KeyStoreOptions{}.Validate().ok());
  EXPECT_TRUE(KeyStoreOptions{.path = "keys"}.Validate().ok());
  EXPECT_FALSE(
      KeyStoreOptions({.path = "k", .algorithms = {}}).Validate().ok());
  EXPECT_FALSE(KeyStoreOptions({.path = "k", .poll_interval = milliseconds(0)})
                   .Validate()
                   .ok());
}

}  // namespace
}  // namespace treeline::access
