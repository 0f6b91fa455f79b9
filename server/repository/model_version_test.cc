#include "server/repository/model_version.h"

#include <chrono>
#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "server/repository/repository_test_util.h"

namespace treeline::repository {
namespace {

// clang-tidy 14 does not see that literals use it.
using std::chrono_literals::operator""s;  // NOLINT(misc-unused-using-decls)
using FileChange = ModelVersion::FileChange;

constexpr base::MonotonicTime kNow =
    base::MonotonicTime{} + std::chrono::hours(1);

ModelRef Ref(const std::string& fingerprint, const std::string& file_id = "") {
  return {.scene = "kitchen",
          .version = "1",
          .bytes = 5,
          .fingerprint = fingerprint,
          .file_id = file_id};
}

std::shared_ptr<const Scene> SomeScene(const std::string& content = "good") {
  return std::make_shared<const Scene>(
      Scene{"kitchen", "1", std::make_shared<const FakeLocalizer>(content)});
}

TEST(ModelVersion, IsUnloadedThenLoadingThenReady) {
  ModelVersion version(Ref("a"));
  EXPECT_EQ(version.state(), SceneState::kUnloaded);
  EXPECT_TRUE(version.MayLoad(kNow));
  EXPECT_TRUE(version.Queue(LoadPurpose::kWanted));
  EXPECT_FALSE(version.Queue(LoadPurpose::kWanted));
  EXPECT_EQ(version.state(), SceneState::kLoading);
  version.Begin();
  EXPECT_FALSE(version.Queue(LoadPurpose::kWanted));
  EXPECT_EQ(version.End(), LoadPurpose::kWanted);
  EXPECT_FALSE(version.is_loading());
  EXPECT_EQ(version.Install(SomeScene(), Ref("a"), 1), nullptr);
  EXPECT_EQ(version.state(), SceneState::kReady);
  EXPECT_EQ(version.resident_bytes(), 5u);
}

TEST(ModelVersion, WhoeverWaitsForAPreloadWantsIt) {
  for (const bool is_at_work : {false, true}) {
    ModelVersion version(Ref("a"));
    version.Queue(LoadPurpose::kIfItFits);
    if (is_at_work) version.Begin();
    version.Want();
    if (!is_at_work) version.Begin();
    EXPECT_EQ(version.End(), LoadPurpose::kWanted);
  }
  ModelVersion version(Ref("a"));
  version.Queue(LoadPurpose::kIfItFits);
  EXPECT_EQ(version.purpose(), LoadPurpose::kIfItFits);
  version.Drop();
  EXPECT_EQ(version.state(), SceneState::kUnloaded);
}

TEST(ModelVersion, WhatFailedForNowMayLoadLaterAndLater) {
  ModelVersion version(Ref("a"));
  for (const auto wait : {1s, 2s, 4s, 8s, 16s, 32s, 64s, 64s}) {
    version.Queue(LoadPurpose::kWanted);
    EXPECT_FALSE(version.has_failed());
    version.Begin();
    version.End();
    version.Fail(absl::UnavailableError("away"), kNow);
    EXPECT_EQ(version.state(), SceneState::kFailed);
    EXPECT_EQ(version.retry_at() - kNow, wait);
    EXPECT_FALSE(version.MayLoad(kNow + wait - 1s));
    EXPECT_TRUE(version.MayLoad(kNow + wait));
  }
  // A load that succeeds begins anew.
  version.Install(SomeScene(), Ref("a"), 1);
  EXPECT_FALSE(version.has_failed());
  version.Fail(absl::UnavailableError("away"), kNow);
  EXPECT_EQ(version.retry_at() - kNow, 1s);
}

TEST(ModelVersion, WhatIsCorruptMayLoadWhenItsFileHasChanged) {
  ModelVersion version(Ref("a"));
  version.Fail(absl::DataLossError("bad"), kNow);
  EXPECT_FALSE(version.MayLoad(kNow + std::chrono::hours(1)));
  EXPECT_EQ(version.List(Ref("a")), FileChange::kNone);
  EXPECT_FALSE(version.MayLoad(kNow));
  EXPECT_EQ(version.List(Ref("b")), FileChange::kReplaced);
  EXPECT_TRUE(version.MayLoad(kNow));
}

TEST(ModelVersion, TellsAFileWrittenOverFromAnotherInItsPlace) {
  ModelVersion version(Ref("a", "file 1"));
  EXPECT_EQ(version.List(Ref("a", "file 1")), FileChange::kNone);
  EXPECT_EQ(version.List(Ref("b", "file 1")), FileChange::kOverwritten);
  EXPECT_EQ(version.List(Ref("c", "file 2")), FileChange::kReplaced);
  EXPECT_EQ(version.model().fingerprint, "c");
}

TEST(ModelVersion, AnotherFileDoesNotEndALoad) {
  ModelVersion version(Ref("a"));
  version.Queue(LoadPurpose::kWanted);
  version.Begin();
  version.List(Ref("b"));
  EXPECT_TRUE(version.is_loading());
}

TEST(ModelVersion, HandsBackWhatGoesOutOfMemory) {
  ModelVersion version(Ref("a"));
  const auto first = SomeScene();
  const auto second = SomeScene();
  version.Install(first, Ref("a"), 1);
  version.SetNamed();
  EXPECT_EQ(version.Install(second, Ref("b"), 2), first);
  EXPECT_EQ(version.loaded().fingerprint, "b");
  EXPECT_TRUE(version.is_named());
  EXPECT_EQ(version.Release(), second);
  EXPECT_FALSE(version.is_resident());
  EXPECT_FALSE(version.is_named());
  EXPECT_EQ(version.resident_bytes(), 0u);
  EXPECT_EQ(version.Release(), nullptr);
}

TEST(ModelVersion, IsInUseWhileSomebodyHasTheSceneOrItsModel) {
  ModelVersion version(Ref("a"));
  EXPECT_FALSE(version.IsInUse());
  version.Install(SomeScene(), Ref("a"), 1);
  EXPECT_FALSE(version.IsInUse());
  std::shared_ptr<const Scene> scene = version.Use(7);
  EXPECT_EQ(version.last_use(), 7u);
  EXPECT_TRUE(version.IsInUse());
  std::shared_ptr<const localizer::Localizer> localizer = scene->localizer;
  scene.reset();
  EXPECT_TRUE(version.IsInUse());
  localizer.reset();
  EXPECT_FALSE(version.IsInUse());
}

TEST(ModelVersion, OtherMetadataIsPutToTheSameModel) {
  ModelVersion version(Ref("a"));
  version.Install(SomeScene(), Ref("a"), 1);
  const auto metadata = std::make_shared<const SceneMetadata>();
  const auto before = version.SetMetadata(metadata);
  EXPECT_EQ(before->metadata, nullptr);
  EXPECT_EQ(version.scene()->metadata, metadata);
  EXPECT_EQ(version.scene()->localizer, before->localizer);
}

TEST(ModelVersion, AFailureBesideWhatIsInMemoryIsReported) {
  ModelVersion version(Ref("a"));
  version.Install(SomeScene(), Ref("a"), 1);
  version.Unlist();
  version.Fail(absl::DataLossError("bad"), kNow);
  const VersionStatus status = version.status();
  EXPECT_EQ(status.version, "1");
  EXPECT_EQ(status.state, SceneState::kReady);
  EXPECT_TRUE(absl::IsDataLoss(status.failure));
  EXPECT_EQ(status.resident_bytes, 5u);
  EXPECT_FALSE(status.listed);
}

}  // namespace
}  // namespace treeline::repository
