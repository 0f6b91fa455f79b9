#include "server/tools/publish.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "server/repository/folder_source.h"

namespace treeline::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr char kDigestOfAbc[] =
    "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

class PublishTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = absl::StrCat(
        testing::TempDir(), "/publish-", getpid(), "-",
        testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Put(const std::string& path, const std::string& contents) const {
    const std::string whole = absl::StrCat(folder_, "/", path);
    ASSERT_TRUE(base::MakeParentFolder(whole).ok());
    ASSERT_TRUE(base::WriteFileAtomically(whole, contents).ok());
  }

  absl::StatusOr<repository::ModelIndex> Index(
      const std::string& base_url = "") const {
    repository::FolderSource source(folder_);
    return IndexModels(source, {.base_url = base_url, .quiet = true}, {});
  }

  std::string folder_ = {};
};

TEST_F(PublishTest, NamesEveryModelWithSizeDigestAndPlace) {
  Put("hall/2/model.treeline", "abc");
  Put("kitchen/7/model.treeline", "model");
  Put("kitchen/scene.json", R"({"display_name":"Kitchen"})");
  Put("kitchen/notes.txt", "not a model");
  const auto index = Index();
  ASSERT_TRUE(index.ok()) << index.status();
  ASSERT_THAT(index->models, SizeIs(2));
  EXPECT_EQ(index->models[0].scene, "hall");
  EXPECT_EQ(index->models[0].version, "2");
  EXPECT_EQ(index->models[0].bytes, 3u);
  EXPECT_EQ(index->models[0].sha256, kDigestOfAbc);
  EXPECT_EQ(index->models[0].url, "hall/2/model.treeline");
  EXPECT_THAT(index->scene_json, SizeIs(1));
  const auto again =
      repository::ParseModelIndex(repository::ModelIndexJson(*index).value());
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->models[1].url, "kitchen/7/model.treeline");
}

TEST_F(PublishTest, ABaseUrlGoesInFront) {
  Put("hall/2/model.treeline", "abc");
  EXPECT_EQ(Index("https://cdn/m/")->models[0].url,
            "https://cdn/m/hall/2/model.treeline");
  EXPECT_TRUE(absl::IsInvalidArgument(Index("https://cdn/m").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(Index("cdn/m/").status()));
}

TEST_F(PublishTest, AnEmptyFolderIsAMistake) {
  EXPECT_TRUE(absl::IsNotFound(Index().status()));
}

TEST_F(PublishTest, ASceneJsonThatIsNoneIsNamed) {
  Put("hall/2/model.treeline", "abc");
  Put("hall/scene.json", "{");
  const auto index = Index();
  EXPECT_TRUE(absl::IsInvalidArgument(index.status()));
  EXPECT_THAT(std::string(index.status().message()),
              HasSubstr("hall/scene.json"));
}

}  // namespace
}  // namespace treeline::tools
