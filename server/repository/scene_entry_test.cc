#include "server/repository/scene_entry.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/repository/repository_test_util.h"

namespace treeline::repository {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class SceneEntryTest : public testing::Test {
 protected:
  // What is listed: versions of which all bytes are those of their file.
  void List(const std::vector<std::string>& versions,
            const std::string& fingerprint = "f") {
    entry_.UnlistAll();
    for (const std::string& version : versions) {
      entry_.List(Ref(version, fingerprint), effects_);
    }
    entry_.EndListing({}, kNow, effects_);
  }
  static ModelRef Ref(const std::string& version,
                      const std::string& fingerprint = "f") {
    return {.scene = "kitchen",
            .version = version,
            .bytes = 3,
            .fingerprint = fingerprint};
  }
  // Begins and ends the first load of the queue; returns its version.
  std::string RunLoad(const absl::Status& failure = absl::OkStatus()) {
    const std::string version = shared_.queue.front().version;
    shared_.queue.pop_front();
    ModelVersion& loading = entry_.loading(version);
    loading.Begin();
    absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer =
        std::make_shared<const FakeLocalizer>("good");
    if (!failure.ok()) localizer = failure;
    entry_.Finish(loading.model(), std::move(localizer), 0.5, kNow, effects_);
    return version;
  }
  std::vector<std::string> Queued() const {
    std::vector<std::string> versions;
    for (const LoadKey& key : shared_.queue) versions.push_back(key.version);
    return versions;
  }
  void Acquire(const std::string& version = "") {
    entry_.Acquire(version, Note(), kNow, effects_);
  }
  AcquireDone Note() {
    return [this](SceneAnswer answer) {
      answers_.push_back(
          answer.ok() ? (*answer)->version
                      : absl::StatusCodeToString(answer.status().code()));
    };
  }
  // Calls who has been answered, and returns the answers.
  std::vector<std::string> Answers() {
    for (const auto& answer : std::exchange(effects_.answers, {})) answer();
    return std::exchange(answers_, {});
  }

  static constexpr base::MonotonicTime kNow = {};
  SharedByScenes shared_;
  SceneEntry entry_{"kitchen", shared_};
  TableEffects effects_;
  std::vector<std::string> answers_;
};

TEST_F(SceneEntryTest, AQueryWaitsForTheNewestListed) {
  List({"1", "2"});
  Acquire();
  EXPECT_THAT(Queued(), ElementsAre("2"));
  EXPECT_THAT(Answers(), IsEmpty());
  RunLoad();
  EXPECT_THAT(Answers(), ElementsAre("2"));
  EXPECT_EQ(entry_.Model()->version, "2");
}

TEST_F(SceneEntryTest, WhenTheNewestFailsTheOneBeforeAnswers) {
  List({"1", "2"});
  Acquire();
  RunLoad(absl::DataLossError("bad"));
  EXPECT_THAT(Answers(), IsEmpty());
  EXPECT_THAT(Queued(), ElementsAre("1"));
  RunLoad();
  EXPECT_THAT(Answers(), ElementsAre("1"));
}

TEST_F(SceneEntryTest, WhoAskedForAVersionIsNotAnsweredWithAnother) {
  List({"1", "2"});
  Acquire("2");
  Acquire("3");
  EXPECT_THAT(Answers(), ElementsAre("NOT_FOUND"));
  RunLoad(absl::DataLossError("bad"));
  EXPECT_THAT(Answers(), ElementsAre("DATA_LOSS"));
  EXPECT_THAT(Queued(), IsEmpty());
}

TEST_F(SceneEntryTest, APreloadThatFailsGoesOnWithTheOneBefore) {
  List({"1", "2"});
  entry_.LoadIfItFits(kNow);
  EXPECT_EQ(entry_.loading("2").purpose(), LoadPurpose::kIfItFits);
  RunLoad(absl::DataLossError("bad"));
  EXPECT_THAT(Queued(), ElementsAre("1"));
  EXPECT_EQ(entry_.loading("1").purpose(), LoadPurpose::kIfItFits);
  RunLoad();
  entry_.LoadIfItFits(kNow);
  EXPECT_THAT(Queued(), IsEmpty());
}

TEST_F(SceneEntryTest, AQueryMakesAPreloadWanted) {
  List({"1"});
  entry_.LoadIfItFits(kNow);
  Acquire();
  EXPECT_THAT(Queued(), ElementsAre("1"));
  EXPECT_EQ(entry_.loading("1").purpose(), LoadPurpose::kWanted);
}

TEST_F(SceneEntryTest, ANewerVersionIsLoadedOnlyBesideOneThatServes) {
  List({"1"});
  List({"1", "2"});
  EXPECT_THAT(Queued(), IsEmpty());
  Acquire();
  RunLoad();
  List({"1", "2", "3"});
  EXPECT_THAT(Queued(), ElementsAre("3"));
  Acquire();
  EXPECT_THAT(Answers(), ElementsAre("2", "2"));
  RunLoad();
  EXPECT_EQ(shared_.swaps, 1u);
  ASSERT_EQ(effects_.released.size(), 1u);
  EXPECT_EQ(effects_.released[0]->version, "2");
}

TEST_F(SceneEntryTest, WhatCannotEvenBeginAnswersWhoWaits) {
  List({"1"});
  Acquire();
  shared_.queue.clear();
  entry_.Refuse("1", absl::DataLossError("no"), kNow, effects_);
  EXPECT_THAT(Answers(), ElementsAre("DATA_LOSS"));
  EXPECT_EQ(entry_.stats().counts.load_failures, 1u);
  EXPECT_EQ(shared_.counts.load_failures, 1u);
}

TEST_F(SceneEntryTest, AnEvictedVersionIsLoadedAgainByTheNextQuery) {
  List({"1"});
  Acquire();
  RunLoad();
  EXPECT_THAT(Answers(), ElementsAre("1"));
  ASSERT_EQ(entry_.Resident().size(), 1u);
  entry_.Evict(*entry_.Resident()[0], effects_);
  EXPECT_THAT(entry_.Resident(), IsEmpty());
  EXPECT_EQ(entry_.state(), SceneState::kUnloaded);
  EXPECT_EQ(effects_.events.back().kind, RepositoryEvent::Kind::kEvicted);
  EXPECT_EQ(effects_.events.back().bytes, 3u);
  Acquire();
  EXPECT_THAT(Queued(), ElementsAre("1"));
}

TEST_F(SceneEntryTest, IsForgottenWhenNothingIsListedInMemoryOrOnItsWay) {
  List({"1"});
  Acquire();
  List({});
  EXPECT_FALSE(entry_.empty());
  EXPECT_THAT(Answers(), ElementsAre("NOT_FOUND"));
  RunLoad();
  EXPECT_FALSE(entry_.empty());
  EXPECT_TRUE(entry_.Unload("", effects_).ok());
  EXPECT_TRUE(entry_.empty());
  EXPECT_FALSE(entry_.Model().has_value());
}

TEST_F(SceneEntryTest, AFileThatChangedDuringItsLoadIsLoadedAgain) {
  List({"1"});
  Acquire();
  shared_.queue.clear();
  entry_.loading("1").Begin();
  List({"1"}, "other");
  entry_.Finish(Ref("1"), absl::DataLossError("half"), 0.5, kNow, effects_);
  EXPECT_THAT(Queued(), ElementsAre("1"));
  EXPECT_EQ(entry_.stats().counts.load_failures, 0u);
  RunLoad();
  EXPECT_THAT(Answers(), ElementsAre("1"));
}

TEST_F(SceneEntryTest, TurnsAwayAllWhoWait) {
  List({"1"});
  Acquire();
  Acquire("1");
  entry_.TurnAwayAll(effects_);
  EXPECT_THAT(Answers(), ElementsAre("UNAVAILABLE", "UNAVAILABLE"));
  entry_.TurnAwayAll(effects_);
  EXPECT_THAT(Answers(), IsEmpty());
}

}  // namespace
}  // namespace treeline::repository
