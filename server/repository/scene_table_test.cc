#include "server/repository/scene_table.h"

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/repository/load_failure.h"
#include "server/repository/scene_table_fixture.h"

namespace treeline::repository {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
// clang-tidy 14 does not see that literals use them.
using std::chrono_literals::operator""s;   // NOLINT(misc-unused-using-decls)
using std::chrono_literals::operator""ms;  // NOLINT(misc-unused-using-decls)

TEST_F(SceneTableTest, AVersionIsLoadedWhenItIsFirstAskedFor) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kUnloaded);
  EXPECT_THAT(RunLoads(), ElementsAre());
  const auto asked = Ask("kitchen");
  EXPECT_FALSE(asked->answered);
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kLoading);
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/1"));
  ASSERT_TRUE(asked->answered);
  EXPECT_EQ((*asked->scene)->localizer->info().dataset, "good");
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kReady);
  EXPECT_TRUE(Ask("kitchen")->answered);
}

TEST_F(SceneTableTest, AllWhoWaitShareOneLoad) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto a = Ask("kitchen");
  const auto b = Ask("kitchen", "1");
  const auto c = Load("kitchen");
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/1"));
  EXPECT_EQ(a->scene.value(), b->scene.value());
  EXPECT_EQ(a->scene.value(), c->scene.value());
}

TEST_F(SceneTableTest, TheNewestAnswersUnlessOneIsNamed) {
  for (const char* version : {"9", "10", "1"}) {
    source_.Put("kitchen", version, "good");
  }
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "10");
  EXPECT_EQ(Answer("kitchen", "9"), "9");
  EXPECT_EQ(Answer("kitchen"), "10");
}

TEST_F(SceneTableTest, AnOldVersionAskedForByNameDoesNotServeTheOthers) {
  source_.Put("kitchen", "1", "good");
  source_.Put("kitchen", "2", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen", "1"), "1");
  EXPECT_EQ(Answer("kitchen"), "2");
}

TEST_F(SceneTableTest, ACorruptNewestLeavesTheServingToTheNextOne) {
  source_.Put("kitchen", "1", "good");
  source_.Put("kitchen", "2", "half copied");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kFailed);
  const auto status = Ask("kitchen", "2")->scene.status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(base::ErrorInfoOf(status).reason, kModelCorrupt);
  EXPECT_EQ(base::ErrorInfoOf(status).metadata.at("version"), "2");
  EXPECT_THAT(std::string(status.message()), HasSubstr("not a Treeline model"));
  const auto scene = table_.Get("kitchen");
  EXPECT_EQ(scene->state, SceneState::kReady);
  EXPECT_TRUE(scene->failure.ok());
}

TEST_F(SceneTableTest, FailuresHaveTheirCodesAndReasons) {
  const struct {
    const char* content;
    absl::StatusCode code;
    const char* reason;
    bool retry;
  } cases[] = {
      {"bad", absl::StatusCode::kDataLoss, kModelCorrupt, false},
      {"newer", absl::StatusCode::kFailedPrecondition, kModelTooNew, false},
      {"odd", absl::StatusCode::kFailedPrecondition, kSceneLoadFailed, false},
      {"away", absl::StatusCode::kUnavailable, kSceneLoadFailed, true},
  };
  for (const auto& c : cases) {
    source_.Put(c.content, "1", c.content);
    Rescan();
    const auto asked = Ask(c.content);
    RunLoads();
    ASSERT_TRUE(asked->answered);
    EXPECT_EQ(asked->scene.status().code(), c.code) << c.content;
    EXPECT_EQ(base::ErrorInfoOf(asked->scene.status()).reason, c.reason);
    EXPECT_EQ(base::RetryAfterOf(asked->scene.status()).has_value(), c.retry);
    EXPECT_EQ(table_.Get(c.content)->state, SceneState::kFailed);
  }
}

TEST_F(SceneTableTest, WhatIsNotThereIsNotFound) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto scene = Ask("attic")->scene.status();
  EXPECT_EQ(scene.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(base::ErrorInfoOf(scene).reason, kSceneNotFound);
  const auto version = Ask("kitchen", "2")->scene.status();
  EXPECT_EQ(version.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(base::ErrorInfoOf(version).reason, kVersionNotFound);
  EXPECT_EQ(Load("attic")->scene.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(table_.Get("attic").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(SceneTableTest, WhatFailsForNowIsTriedAgainLaterAndLater) {
  source_.Put("kitchen", "1", "away");
  Rescan();
  for (const auto wait : {1s, 2s, 4s, 8s, 16s, 32s, 64s, 64s}) {
    const auto asked = Ask("kitchen");
    EXPECT_EQ(RunLoads().size(), 1u);
    EXPECT_EQ(base::RetryAfterOf(asked->scene.status()), 1000ms * wait.count());
    clock_.Advance(wait - 1ms);
    EXPECT_EQ(base::RetryAfterOf(Ask("kitchen")->scene.status()), 1ms);
    EXPECT_THAT(RunLoads(), ElementsAre());
    clock_.Advance(1ms);
  }
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
}

TEST_F(SceneTableTest, WhatIsCorruptIsTriedAgainWhenItsFileChanges) {
  source_.Put("kitchen", "1", "half");
  Rescan();
  EXPECT_THAT(Answer("kitchen"), HasSubstr("DATA_LOSS"));
  clock_.Advance(3600s);
  Rescan();
  EXPECT_TRUE(Ask("kitchen")->answered);
  source_.Overwrite("kitchen", "1", "good now");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
}

TEST_F(SceneTableTest, LoadTriesAgainWhatFailed) {
  source_.Put("kitchen", "1", "bad");
  Rescan();
  EXPECT_THAT(Answer("kitchen"), HasSubstr("DATA_LOSS"));
  const auto asked = Load("kitchen");
  EXPECT_FALSE(asked->answered);
  EXPECT_EQ(RunLoads().size(), 1u);
  EXPECT_EQ(asked->scene.status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(SceneTableTest, LoadOfACorruptNewestSaysSoAlthoughTheOldOneServes) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Put("kitchen", "2", "bad");
  Rescan();
  const auto asked = Load("kitchen");
  RunLoads();
  EXPECT_EQ(asked->scene.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Answer("kitchen"), "1");
}

TEST_F(SceneTableTest, ANewVersionTakesOverWhenItIsReady) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto old = Ask("kitchen");
  RunLoads();
  source_.Put("kitchen", "2", "good", 5);
  Rescan();
  // Until it is loaded, and while it is, the old one answers.
  EXPECT_EQ((*Ask("kitchen")->scene)->version, "1");
  const auto job = Next();
  ASSERT_TRUE(job);
  EXPECT_EQ((*Ask("kitchen")->scene)->version, "1");
  Finish(*job);
  EXPECT_EQ((*Ask("kitchen")->scene)->version, "2");
  EXPECT_EQ(table_.Stats().swaps, 1u);
  // The old one stays for whoever has it, and then goes.
  EXPECT_EQ(StateOf("kitchen", 1), SceneState::kUnloaded);
  EXPECT_EQ(resident_, 6u);
  EXPECT_EQ((*old->scene)->localizer->info().dataset, "good");
  old->scene = absl::UnknownError("let go");
  EXPECT_EQ(resident_, 5u);
}

TEST_F(SceneTableTest, ANewVersionOfWhatIsNotInMemoryIsNotLoaded) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  source_.Put("kitchen", "2", "good");
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre());
}

TEST_F(SceneTableTest, ACorruptNewVersionIsRefusedAndTriedAgainWhenItChanges) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Put("kitchen", "2", "half");
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/2"));
  EXPECT_EQ(Answer("kitchen"), "1");
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kFailed);
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre());
  source_.Overwrite("kitchen", "2", "good");
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/2"));
  EXPECT_EQ(Answer("kitchen"), "2");
}

TEST_F(SceneTableTest, AVersionThatIsNamedStaysWhenAnotherTakesOver) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen", "1"), "1");
  source_.Put("kitchen", "2", "good");
  Rescan();
  RunLoads();
  EXPECT_EQ(Answer("kitchen"), "2");
  EXPECT_TRUE(Ask("kitchen", "1")->answered);
  EXPECT_THAT(RunLoads(), ElementsAre());
}

TEST_F(SceneTableTest, WhatVanishesServesFromMemoryUntilItIsUnloaded) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Remove("kitchen", "1");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  EXPECT_EQ(Answer("kitchen", "1"), "1");
  EXPECT_FALSE(table_.Get("kitchen")->versions.at(0).listed);
  Unload("kitchen");
  EXPECT_FALSE(table_.Get("kitchen").ok());
  EXPECT_THAT(Answer("kitchen"), HasSubstr("NOT_FOUND"));
}

TEST_F(SceneTableTest, WhenTheNewestIsTakenAwayTheOneBeforeTakesOver) {
  source_.Put("kitchen", "1", "good");
  source_.Put("kitchen", "2", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "2");
  source_.Remove("kitchen", "2");
  Rescan();
  EXPECT_EQ((*Ask("kitchen")->scene)->version, "2");
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/1"));
  EXPECT_EQ((*Ask("kitchen")->scene)->version, "1");
}

TEST_F(SceneTableTest, WhatWasNeverLoadedAndVanishesIsForgotten) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  source_.Remove("kitchen", "1");
  Rescan();
  EXPECT_TRUE(table_.List().empty());
}

TEST_F(SceneTableTest, WhatVanishesBeforeItIsLoadedAnswersThoseWhoWait) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto newest = Ask("kitchen");
  const auto named = Ask("kitchen", "1");
  source_.Remove("kitchen", "1");
  Rescan();
  RunLoads();
  EXPECT_EQ(newest->scene.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(named->scene.status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(table_.List().empty());
}

TEST_F(SceneTableTest, AFileRenamedIntoPlaceTakesOverWhenItIsReady) {
  source_.Put("kitchen", "1", "good old");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Put("kitchen", "1", "good new");
  Rescan();
  EXPECT_EQ((*Ask("kitchen")->scene)->localizer->info().dataset, "good old");
  RunLoads();
  EXPECT_EQ((*Ask("kitchen")->scene)->localizer->info().dataset, "good new");
}

TEST_F(SceneTableTest, ACorruptFileRenamedIntoPlaceIsRefusedAndReported) {
  source_.Put("kitchen", "1", "good old");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Put("kitchen", "1", "bad");
  Rescan();
  RunLoads();
  EXPECT_EQ((*Ask("kitchen")->scene)->localizer->info().dataset, "good old");
  const auto version = table_.Get("kitchen")->versions.at(0);
  EXPECT_EQ(version.state, SceneState::kReady);
  EXPECT_EQ(version.failure.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(RunLoads(), ElementsAre());
}

// What is in memory is a copy that was verified.
TEST_F(SceneTableTest, AFileWrittenOverServesFromMemoryUntilTheNewOneIsGood) {
  source_.Put("kitchen", "1", "good old");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Overwrite("kitchen", "1", "half");
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/1"));
  EXPECT_EQ((*Ask("kitchen")->scene)->localizer->info().dataset, "good old");
  EXPECT_EQ(table_.Get("kitchen")->versions.at(0).failure.code(),
            absl::StatusCode::kDataLoss);
  source_.Overwrite("kitchen", "1", "good new");
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/1"));
  EXPECT_EQ((*Ask("kitchen")->scene)->localizer->info().dataset, "good new");
  EXPECT_EQ(resident_, 1u);
}

TEST_F(SceneTableTest, AFileWrittenOverFailsItsSceneOnceItIsOutOfMemory) {
  source_.Put("kitchen", "1", "good old");
  source_.Put("office", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.Overwrite("kitchen", "1", "half");
  Unload("kitchen");
  Rescan();
  EXPECT_THAT(Answer("kitchen"), HasSubstr("DATA_LOSS"));
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kFailed);
  EXPECT_EQ(Answer("office"), "1");
}

TEST_F(SceneTableTest, AFileWrittenOverWhileItIsReadIsReadAgain) {
  source_.Put("kitchen", "1", "good old");
  Rescan();
  const auto asked = Ask("kitchen");
  const auto job = Next();
  source_.Overwrite("kitchen", "1", "good new");
  Rescan();
  // What was read had the checksum of its header: it serves until then.
  Finish(*job);
  EXPECT_TRUE(asked->answered);
  EXPECT_THAT(RunLoads(), ElementsAre("kitchen/1"));
  EXPECT_EQ((*Ask("kitchen")->scene)->localizer->info().dataset, "good new");
}

TEST_F(SceneTableTest, AFileHalfWrittenWhileItIsReadIsReadAgain) {
  source_.Put("kitchen", "1", "half");
  Rescan();
  const auto asked = Ask("kitchen");
  const auto job = Next();
  source_.Overwrite("kitchen", "1", "good new");
  // Between the listing and the read, as it were.
  const SceneTable::Job read = *job;
  SceneTable::Effects effects;
  table_.Apply(*source_.List(), clock_.Now(), effects);
  table_.Finish(read, absl::DataLossError("half"), 0, clock_.Now(), effects);
  Carry(effects);
  EXPECT_FALSE(asked->answered);
  RunLoads();
  EXPECT_EQ((*asked->scene)->localizer->info().dataset, "good new");
}

TEST_F(SceneTableTest, AnUnloadedSceneIsLoadedByTheNextQuery) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  EXPECT_EQ(Answer("kitchen"), "1");
  Unload("kitchen", "1");
  EXPECT_EQ(StateOf("kitchen", 0), SceneState::kUnloaded);
  EXPECT_EQ(resident_, 0u);
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre());
  EXPECT_EQ(Answer("kitchen"), "1");
  SceneTable::Effects effects;
  EXPECT_EQ(base::ErrorInfoOf(table_.Unload("attic", "", effects)).reason,
            kSceneNotFound);
  EXPECT_EQ(base::ErrorInfoOf(table_.Unload("kitchen", "7", effects)).reason,
            kVersionNotFound);
}

TEST_F(SceneTableTest, MetadataReachesWhatIsInMemoryAndWhatIsLoadedLater) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto before = Ask("kitchen");
  RunLoads();
  EXPECT_EQ((*before->scene)->metadata, nullptr);
  source_.SetJson("kitchen", R"({"display_name": "Kitchen"})");
  Rescan();
  EXPECT_THAT(RunLoads(), ElementsAre());
  const auto after = Ask("kitchen");
  EXPECT_EQ((*after->scene)->metadata->display_name, "Kitchen");
  EXPECT_EQ((*after->scene)->localizer, (*before->scene)->localizer);
  EXPECT_EQ(table_.Get("kitchen")->metadata->display_name, "Kitchen");
}

TEST_F(SceneTableTest, ABadSceneJsonIsAWarningAndTheLastGoodOneStays) {
  source_.Put("kitchen", "1", "good");
  source_.SetJson("kitchen", R"({"display_name": "Kitchen"})");
  Rescan();
  source_.SetJson("kitchen", R"({"display_nam": "Kitchen"})");
  Rescan();
  const auto status = table_.Get("kitchen");
  EXPECT_EQ(status->metadata->display_name, "Kitchen");
  EXPECT_THAT(std::string(status->metadata_problem.message()),
              HasSubstr("display_nam"));
  EXPECT_EQ(Answer("kitchen"), "1");
  source_.SetJson("kitchen", "{}");
  Rescan();
  EXPECT_TRUE(table_.Get("kitchen")->metadata_problem.ok());
  EXPECT_EQ(table_.Get("kitchen")->metadata->display_name, "");
}

TEST_F(SceneTableTest, CountsWhatHappens) {
  source_.Put("kitchen", "1", "good", 7);
  source_.Put("office", "1", "bad", 9);
  Rescan();
  Answer("kitchen");
  Answer("office");
  const RepositoryStats stats = table_.Stats();
  EXPECT_EQ(stats.counts.loads, 1u);
  EXPECT_EQ(stats.counts.load_failures, 1u);
  EXPECT_EQ(stats.load_times.count, 2u);
  EXPECT_EQ(stats.load_times.sum_s, 0.5);
  EXPECT_EQ(stats.load_times.last_s, 0.25);
  EXPECT_EQ(stats.load_times.counts[5], 2u);  // at most 0.25 s
  EXPECT_THAT(stats.scenes_by_state, ElementsAre(0, 0, 1, 1));
  ASSERT_EQ(stats.scenes.size(), 2u);
  EXPECT_EQ(stats.scenes[0].name, "kitchen");
  EXPECT_EQ(stats.scenes[0].resident_bytes, 7u);
  EXPECT_EQ(stats.scenes[1].counts.load_failures, 1u);
}

TEST_F(SceneTableTest, TellsWhatHappens) {
  source_.Put("kitchen", "1", "good");
  source_.SetJson("kitchen", "[]");
  Rescan();
  Answer("kitchen");
  source_.Put("kitchen", "2", "bad");
  Rescan();
  RunLoads();
  source_.Overwrite("kitchen", "1", "good");
  Rescan();
  Answer("kitchen");
  Unload("kitchen");
  EXPECT_THAT(events_,
              ElementsAre("BAD_METADATA kitchen/", "LOADED kitchen/1",
                          "TOOK_OVER kitchen/1", "LOAD_FAILED kitchen/2",
                          "OVERWRITTEN kitchen/1", "LOADED kitchen/1",
                          "UNLOADED kitchen/1"));
}

TEST_F(SceneTableTest, ACameraOfSceneJsonReplacesTheModels) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto without = Ask("kitchen");
  RunLoads();
  const camera::RgbdCalibration& model =
      (*without->scene)->localizer->info().calibration;
  EXPECT_FALSE(HasOwnCamera(**without->scene));
  EXPECT_EQ(QueryCalibration(**without->scene), model);
  source_.SetJson("kitchen", R"({"camera": {"model": "SIMPLE_PINHOLE",
      "width_px": 40, "height_px": 30, "parameters": [35, 20, 15]}})");
  Rescan();
  const auto with = Ask("kitchen");
  ASSERT_TRUE(HasOwnCamera(**with->scene));
  const camera::RgbdCalibration calibration = QueryCalibration(**with->scene);
  EXPECT_EQ(calibration.color, *(*with->scene)->metadata->camera);
  EXPECT_EQ(calibration.depth, model.depth);
}

TEST_F(SceneTableTest, ThoseWhoWaitAreTurnedAwayWhenItStops) {
  source_.Put("kitchen", "1", "good");
  Rescan();
  const auto asked = Ask("kitchen");
  SceneTable::Effects effects;
  table_.TurnAwayAll(effects);
  Carry(effects);
  EXPECT_EQ(asked->scene.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorInfoOf(asked->scene.status()).reason, kSceneNotLoaded);
}

TEST_F(SceneTableTest, AtTheStartWhatIsCorruptLeavesItToTheVersionBefore) {
  source_.Put("a", "1", "good");
  source_.Put("a", "2", "bad");
  Rescan();
  table_.LoadWhatFits(clock_.Now());
  EXPECT_THAT(RunLoads(), ElementsAre("a/2", "a/1"));
  EXPECT_EQ(table_.Get("a")->serving->version, "1");
}

}  // namespace
}  // namespace treeline::repository
