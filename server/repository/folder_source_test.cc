#include "server/repository/folder_source.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

class FolderSourceTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("source-" + std::to_string(getpid()) + "-" +
             testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path ModelPath(const std::string& scene, const std::string& version) {
    return root_ / scene / version / "model.treeline";
  }
  void Put(const std::string& scene, const std::string& version,
           const std::string& content) {
    fs::create_directories(ModelPath(scene, version).parent_path());
    std::ofstream(ModelPath(scene, version)) << content;
  }
  SourceListing MustList() {
    auto listing = source_().List();
    EXPECT_TRUE(listing.ok()) << listing.status();
    return *std::move(listing);
  }
  ModelRef Only() {
    const SourceListing listing = MustList();
    EXPECT_EQ(listing.models.size(), 1u);
    return listing.models.at(0);
  }
  FolderSource source_() { return FolderSource(root_.string()); }

  fs::path root_;
};

std::vector<std::string> NamesOf(const SourceListing& listing) {
  std::vector<std::string> names;
  for (const ModelRef& model : listing.models) {
    names.push_back(model.scene + "/" + model.version);
  }
  return names;
}

TEST_F(FolderSourceTest, ListsEveryModelWithItsSize) {
  Put("kitchen", "1", "good");
  Put("kitchen", "2", "good!");
  Put("office", "a", "");
  const SourceListing listing = MustList();
  EXPECT_THAT(NamesOf(listing),
              UnorderedElementsAre("kitchen/1", "kitchen/2", "office/a"));
  for (const ModelRef& model : listing.models) {
    EXPECT_EQ(model.bytes, model.scene == "office" ? 0u
                           : model.version == "2"  ? 5u
                                                   : 4u);
  }
}

TEST_F(FolderSourceTest, WhatIsNoSceneIsPassedOver) {
  Put("kitchen", "1", "good");
  Put(".hidden", "1", "good");
  Put("with space", "1", "good");
  Put("kitchen", ".tmp-2", "good");
  fs::create_directories(root_ / "no-versions");
  fs::create_directories(root_ / "no-model" / "1");
  fs::create_directories(ModelPath("folder-as-model", "1"));
  std::ofstream(root_ / "README.md") << "not a scene";
  EXPECT_THAT(NamesOf(MustList()), ElementsAre("kitchen/1"));
}

TEST_F(FolderSourceTest, AnEmptyFolderHasNoModels) {
  EXPECT_TRUE(MustList().models.empty());
}

TEST_F(FolderSourceTest, AMissingFolderIsAnErrorThatNamesIt) {
  const std::string missing = (root_ / "missing").string();
  const auto listing = FolderSource(missing).List();
  EXPECT_EQ(listing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(listing.status().message()), HasSubstr(missing));
}

TEST_F(FolderSourceTest, AFileInPlaceOfTheFolderIsAnError) {
  std::ofstream(root_ / "file") << "x";
  EXPECT_FALSE(FolderSource((root_ / "file").string()).List().ok());
}

TEST_F(FolderSourceTest, AFileLeftAloneKeepsItsFingerprint) {
  Put("kitchen", "1", "good");
  EXPECT_EQ(Only().fingerprint, Only().fingerprint);
}

TEST_F(FolderSourceTest, AFileRenamedIntoPlaceIsAnotherFile) {
  Put("kitchen", "1", "good");
  const ModelRef before = Only();
  std::ofstream(root_ / "new") << "good";
  fs::rename(root_ / "new", ModelPath("kitchen", "1"));
  const ModelRef after = Only();
  EXPECT_NE(before.fingerprint, after.fingerprint);
  EXPECT_NE(before.file_id, after.file_id);
}

TEST_F(FolderSourceTest, AFileWrittenOverIsTheSameFileWithAnotherFingerprint) {
  Put("kitchen", "1", "good");
  const ModelRef before = Only();
  Put("kitchen", "1", "good and longer");
  const ModelRef after = Only();
  EXPECT_NE(before.fingerprint, after.fingerprint);
  EXPECT_EQ(before.file_id, after.file_id);
  // Of the same length, later.
  fs::last_write_time(
      ModelPath("kitchen", "1"),
      fs::last_write_time(ModelPath("kitchen", "1")) + std::chrono::seconds(1));
  EXPECT_NE(after.fingerprint, Only().fingerprint);
}

TEST_F(FolderSourceTest, SceneJsonIsListedWithItsScene) {
  Put("kitchen", "1", "good");
  std::ofstream(root_ / "kitchen" / "scene.json") << "{}";
  // A scene without a model is none.
  fs::create_directories(root_ / "attic");
  std::ofstream(root_ / "attic" / "scene.json") << "{}";
  const SourceListing listing = MustList();
  EXPECT_EQ(listing.scene_json.size(), 1u);
  EXPECT_EQ(listing.scene_json.at("kitchen"), "{}");
  EXPECT_TRUE(listing.scene_json_errors.empty());
}

TEST_F(FolderSourceTest, ASceneJsonThatCannotBeReadIsReported) {
  Put("kitchen", "1", "good");
  fs::create_directories(root_ / "kitchen" / "scene.json");
  Put("office", "1", "good");
  std::ofstream(root_ / "office" / "scene.json") << std::string(70000, ' ');
  const SourceListing listing = MustList();
  EXPECT_TRUE(listing.scene_json.empty());
  EXPECT_EQ(listing.scene_json_errors.size(), 2u);
  EXPECT_EQ(listing.scene_json_errors.at("office").code(),
            absl::StatusCode::kResourceExhausted);
}

TEST_F(FolderSourceTest, FetchGivesThePathOrSaysThatItHasGone) {
  Put("kitchen", "1", "good");
  const ModelRef model = Only();
  const auto path = source_().Fetch(model, {});
  ASSERT_TRUE(path.ok()) << path.status();
  EXPECT_EQ(*path, ModelPath("kitchen", "1").string());
  fs::remove(ModelPath("kitchen", "1"));
  EXPECT_EQ(source_().Fetch(model, {}).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(FolderSourceTest, ModelsThatLieElsewhereAreNamed) {
  Put("room", "1", "good");
  Put("my room", "1", "blank in its name");
  Put("hall", ".2.tmp", "on its way");
  std::ofstream(root_ / "room" / "1" / "other.treeline") << "another name";
  std::ofstream(root_ / "room" / "model.treeline") << "no version";
  std::ofstream(root_ / "room.treeline") << "no folder";
  EXPECT_THAT(MisplacedModels(root_.string(), 9),
              ElementsAre("my room/1/model.treeline", "room.treeline",
                          "room/1/other.treeline", "room/model.treeline"));
  EXPECT_EQ(MisplacedModels(root_.string(), 2).size(), 2u);
  EXPECT_TRUE(MisplacedModels((root_ / "none").string(), 9).empty());
}

}  // namespace
}  // namespace treeline::repository
