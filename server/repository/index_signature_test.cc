#include "server/repository/index_signature.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "server/repository/testing_index_keys.h"

namespace treeline::repository {
namespace {

ModelIndex Promised() {
  return {.models = {{.scene = "kitchen",
                      .version = "7",
                      .bytes = 12,
                      .sha256 = std::string(64, 'a'),
                      .url = "kitchen"},
                     {.scene = "attic",
                      .version = "1",
                      .bytes = 34,
                      .sha256 = std::string(64, 'b'),
                      .url = "attic"}},
          .scene_json = {{"kitchen", R"({"display_name":"Kitchen"})"}},
          .published_unix_s = 1764172800,
          .signature = {}};
}

ModelIndex Signed(const TestKeyPair& by) {
  ModelIndex index = Promised();
  const auto signer = IndexSigner::FromPem(by.secret);
  EXPECT_TRUE(signer.ok()) << signer.status();
  EXPECT_TRUE(signer->Sign(index).ok());
  return index;
}

std::string ReasonOf(const IndexKeys& keys, const ModelIndex& index) {
  return base::ErrorInfoOf(keys.Check(index)).reason;
}

TEST(IndexSignature, OneOfTheKeysIsEnough) {
  const TestKeyPair old_key = MakeTestKeyPair();
  const TestKeyPair new_key = MakeTestKeyPair();
  const auto both =
      IndexKeys::FromPem("# keys\n" + old_key.open + "\n" + new_key.open);
  ASSERT_TRUE(both.ok()) << both.status();
  EXPECT_TRUE(both->Check(Signed(old_key)).ok());
  EXPECT_TRUE(both->Check(Signed(new_key)).ok());
  EXPECT_EQ(ReasonOf(*both, Signed(MakeTestKeyPair())),
            "INDEX_SIGNATURE_WRONG");
  EXPECT_EQ(ReasonOf(*both, Promised()), "INDEX_UNSIGNED");
}

TEST(IndexSignature, WhatItPromisesCannotBeChanged) {
  const TestKeyPair key = MakeTestKeyPair();
  const IndexKeys keys = IndexKeys::FromPem(key.open).value();
  const std::vector<std::function<void(ModelIndex&)>> changes = {
      [](ModelIndex& index) { index.models[0].scene = "cellar"; },
      [](ModelIndex& index) { index.models[0].version = "8"; },
      [](ModelIndex& index) { index.models[0].bytes = 13; },
      [](ModelIndex& index) { index.models[0].sha256[5] = 'c'; },
      [](ModelIndex& index) {
        std::swap(index.models[0].sha256, index.models[1].sha256);
      },
      [](ModelIndex& index) { index.models.pop_back(); },
      [](ModelIndex& index) { index.models.push_back(index.models[0]); },
      [](ModelIndex& index) { index.published_unix_s += 1; },
      [](ModelIndex& index) { index.scene_json["kitchen"] = "{}"; },
      [](ModelIndex& index) { index.scene_json["attic"] = "{}"; },
      [](ModelIndex& index) { index.scene_json.clear(); },
      [](ModelIndex& index) { index.signature[17] ^= 1; },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    ModelIndex index = Signed(key);
    changes[i](index);
    EXPECT_EQ(ReasonOf(keys, index), "INDEX_SIGNATURE_WRONG") << i;
  }
}

TEST(IndexSignature, WhereFilesLieAndTheirOrderMayChange) {
  const TestKeyPair key = MakeTestKeyPair();
  ModelIndex index = Signed(key);
  std::swap(index.models[0], index.models[1]);
  index.models[0].url = "https://elsewhere/?X-Amz-Signature=abc";
  EXPECT_TRUE(IndexKeys::FromPem(key.open)->Check(index).ok());
}

TEST(IndexSignature, WhatIsNoKeyIsRefused) {
  const TestKeyPair key = MakeTestKeyPair();
  const TestKeyPair other = MakeTestKeyPair("X25519");
  EXPECT_FALSE(IndexKeys::FromPem("").ok());
  EXPECT_FALSE(IndexKeys::FromPem("nothing\n").ok());
  EXPECT_FALSE(IndexKeys::FromPem(key.secret).ok());
  EXPECT_FALSE(IndexKeys::FromPem(other.open).ok());
  EXPECT_FALSE(IndexKeys::FromPem(key.open + other.open).ok());
  // One that was cut off must not shorten the list without a word.
  EXPECT_FALSE(
      IndexKeys::FromPem(key.open + key.open.substr(0, key.open.size() / 2))
          .ok());
  EXPECT_FALSE(IndexSigner::FromPem("").ok());
  EXPECT_FALSE(IndexSigner::FromPem(key.open).ok());
  EXPECT_FALSE(IndexSigner::FromPem(other.secret).ok());
}

TEST(IndexSignature, SaysWhenItWasPublished) {
  ModelIndex index = Promised();
  index.published_unix_s = 0;
  EXPECT_TRUE(absl::IsInvalidArgument(
      IndexSigner::FromPem(MakeTestKeyPair().secret)->Sign(index)));
}

}  // namespace
}  // namespace treeline::repository
