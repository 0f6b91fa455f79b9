#include "server/repository/scene_repository.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A localizer that knows where it came from.
class FakeLocalizer final : public Localizer {
 public:
  explicit FakeLocalizer(std::string content) {
    info_.dataset = std::move(content);
  }
  absl::StatusOr<PoseEstimate> Localize(const Frame&,
                                        const LocalizeOptions&) const override {
    return PoseEstimate{};
  }
  const ModelInfo& info() const override { return info_; }

 private:
  ModelInfo info_;
};

// Opens what says "good"; everything else is corrupt, but for what was written
// by a newer version.
absl::StatusOr<std::unique_ptr<Localizer>> OpenFake(const std::string& path) {
  const auto content = ReadFile(path);
  if (!content.ok()) return content.status();
  if (*content == "newer") return absl::UnimplementedError("format 99");
  if (content->substr(0, 4) != "good") {
    return absl::DataLossError(path + ": not a Treeline model");
  }
  return std::make_unique<FakeLocalizer>(*content);
}

class SceneRepositoryTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("repository-" + std::to_string(getpid()) + "-" +
             testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  void Put(const std::string& scene, const std::string& version,
           const std::string& content) {
    const fs::path folder = root_ / scene / version;
    fs::create_directories(folder);
    std::ofstream(folder / "model.treeline") << content;
  }
  std::unique_ptr<SceneRepository> MustOpen() {
    auto repository = SceneRepository::Open(root_.string(), OpenFake);
    EXPECT_TRUE(repository.ok()) << repository.status();
    return *std::move(repository);
  }

  fs::path root_;
};

std::vector<std::string> NamesOf(const std::vector<SceneStatus>& list) {
  std::vector<std::string> names;
  for (const SceneStatus& status : list) names.push_back(status.name);
  return names;
}

TEST_F(SceneRepositoryTest, LoadsEveryScene) {
  Put("kitchen", "1", "good kitchen");
  Put("office", "1", "good office");
  const auto repository = MustOpen();
  EXPECT_THAT(NamesOf(repository->List()), ElementsAre("kitchen", "office"));
  const auto scene = repository->Acquire("office", "");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->name, "office");
  EXPECT_EQ((*scene)->version, "1");
  EXPECT_EQ((*scene)->localizer->info().dataset, "good office");
}

TEST_F(SceneRepositoryTest, TheNewestVersionAnswersUnlessOneIsNamed) {
  for (const char* version : {"9", "10", "1"}) {
    Put("kitchen", version, std::string("good ") + version);
  }
  const auto repository = MustOpen();
  EXPECT_EQ((*repository->Acquire("kitchen", ""))->version, "10");
  EXPECT_EQ((*repository->Acquire("kitchen", "9"))->version, "9");
  const auto status = repository->Get("kitchen");
  ASSERT_TRUE(status.ok());
  std::vector<std::string> versions;
  for (const auto& version : status->versions) {
    versions.push_back(version.version);
    EXPECT_EQ(version.state, SceneState::kReady);
  }
  EXPECT_THAT(versions, ElementsAre("10", "9", "1"));
  EXPECT_EQ(status->serving->version, "10");
}

TEST_F(SceneRepositoryTest, ACorruptSceneIsFailedAndTheOthersServe) {
  Put("kitchen", "1", "good");
  Put("office", "1", "garbage");
  const auto repository = MustOpen();
  const auto status = repository->Get("office");
  ASSERT_TRUE(status.ok());
  EXPECT_EQ(status->state, SceneState::kFailed);
  EXPECT_EQ(status->failure.code(), absl::StatusCode::kDataLoss);
  // Not where the server keeps its files.
  EXPECT_EQ(status->failure.message(), "not a Treeline model");
  EXPECT_EQ(status->serving, nullptr);
  for (const char* version : {"", "1"}) {
    const auto scene = repository->Acquire("office", version);
    EXPECT_EQ(scene.status().code(), absl::StatusCode::kDataLoss);
    EXPECT_THAT(std::string(scene.status().message()),
                HasSubstr("not a Treeline model"));
  }
  EXPECT_TRUE(repository->Acquire("kitchen", "").ok());
}

TEST_F(SceneRepositoryTest, ACorruptNewVersionLeavesTheOldOneServing) {
  Put("kitchen", "1", "good");
  Put("kitchen", "2", "half copied");
  const auto repository = MustOpen();
  EXPECT_EQ((*repository->Acquire("kitchen", ""))->version, "1");
  EXPECT_EQ(repository->Acquire("kitchen", "2").status().code(),
            absl::StatusCode::kDataLoss);
  const auto status = repository->Get("kitchen");
  EXPECT_EQ(status->state, SceneState::kReady);
  EXPECT_TRUE(status->failure.ok());
  EXPECT_EQ(status->versions[0].state, SceneState::kFailed);
  EXPECT_EQ(status->versions[0].failure.code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(status->versions[1].state, SceneState::kReady);
}

// UNIMPLEMENTED would tell a client that the server lacks the method.
TEST_F(SceneRepositoryTest, AModelOfANewerFormatIsAFailedPrecondition) {
  Put("kitchen", "1", "newer");
  const auto repository = MustOpen();
  EXPECT_EQ(repository->Get("kitchen")->failure.code(),
            absl::StatusCode::kUnimplemented);
  const auto scene = repository->Acquire("kitchen", "");
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("format 99"));
}

TEST_F(SceneRepositoryTest, UnknownScenesAndVersionsAreNotFound) {
  Put("kitchen", "1", "good");
  const auto repository = MustOpen();
  EXPECT_EQ(repository->Acquire("attic", "").status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(repository->Acquire("kitchen", "2").status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(repository->Get("attic").status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(SceneRepositoryTest, NamesThatArePathsAreRefused) {
  Put("kitchen", "1", "good");
  const auto repository = MustOpen();
  for (const char* name : {"", "..", "../kitchen", "kitchen/1", ".kitchen"}) {
    EXPECT_EQ(repository->Acquire(name, "").status().code(),
              absl::StatusCode::kInvalidArgument)
        << name;
    EXPECT_EQ(repository->Get(name).status().code(),
              absl::StatusCode::kInvalidArgument)
        << name;
  }
  EXPECT_EQ(repository->Acquire("kitchen", "../1").status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(SceneRepositoryTest, WhatIsNoSceneIsPassedOver) {
  Put("kitchen", "1", "good");
  Put(".hidden", "1", "good");
  Put("with space", "1", "good");
  Put("kitchen", ".tmp-2", "good");
  fs::create_directories(root_ / "no-versions");
  fs::create_directories(root_ / "no-model" / "1");
  fs::create_directories(root_ / "folder-as-model" / "1" / "model.treeline");
  std::ofstream(root_ / "README.md") << "not a scene";
  const auto repository = MustOpen();
  EXPECT_THAT(NamesOf(repository->List()), ElementsAre("kitchen"));
  EXPECT_EQ(repository->Get("kitchen")->versions.size(), 1u);
}

TEST_F(SceneRepositoryTest, AnEmptyFolderIsARepositoryWithoutScenes) {
  EXPECT_TRUE(MustOpen()->List().empty());
}

TEST_F(SceneRepositoryTest, AMissingFolderIsAnErrorThatNamesIt) {
  const std::string missing = (root_ / "missing").string();
  const auto repository = SceneRepository::Open(missing, OpenFake);
  EXPECT_EQ(repository.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(repository.status().message()), HasSubstr(missing));
}

TEST_F(SceneRepositoryTest, AFileInPlaceOfTheFolderIsAnError) {
  std::ofstream(root_ / "file") << "x";
  EXPECT_FALSE(SceneRepository::Open((root_ / "file").string(), OpenFake).ok());
}

TEST_F(SceneRepositoryTest, OpensEachVersionOnce) {
  for (int i = 0; i < 20; ++i) {
    Put("scene-" + std::to_string(i), "1", "good");
    Put("scene-" + std::to_string(i), "2", "good");
  }
  std::atomic<int> opened{0};
  const auto repository =
      SceneRepository::Open(root_.string(), [&](const std::string& path) {
        ++opened;
        return OpenFake(path);
      });
  ASSERT_TRUE(repository.ok());
  EXPECT_EQ(opened, 40);
  EXPECT_EQ((*repository)->List().size(), 20u);
}

}  // namespace
}  // namespace treeline
