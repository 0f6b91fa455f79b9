#include "server/repository/scene_repository.h"

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/repository/folder_source.h"
#include "server/repository/load_failure.h"
#include "server/repository/repository_test_util.h"

namespace treeline::repository {
namespace {

using ::testing::HasSubstr;

class SceneRepositoryTest : public testing::Test {
 protected:
  SceneRepositoryTest() : owned_(std::make_unique<FakeSource>()) {
    source_ = owned_.get();
  }
  // Once in each test.
  void Open(const RepositoryOptions& options = {},
            LocalizerOpener opener = OpenContent) {
    auto repository = SceneRepository::Open(std::move(owned_),
                                            std::move(opener), options, clock_);
    ASSERT_TRUE(repository.ok()) << repository.status();
    repository_ = *std::move(repository);
  }
  absl::StatusOr<SceneStatus> Load(const std::string& name,
                                   const std::string& version = "") {
    absl::StatusOr<SceneStatus> loaded;
    absl::Notification done;
    repository_->Load(name, version, [&](absl::StatusOr<SceneStatus> status) {
      loaded = std::move(status);
      done.Notify();
    });
    done.WaitForNotification();
    return loaded;
  }

  ManualClock clock_;
  std::unique_ptr<FakeSource> owned_;
  FakeSource* source_;
  std::unique_ptr<SceneRepository> repository_;
};

TEST_F(SceneRepositoryTest, ModelsCountWithWhatTheyTakeInMemory) {
  source_->Put("kitchen", "1", "good kitchen", 5);
  source_->Put("hall", "1", "good hall", 5);
  source_->Put("office", "1", "bad office", 5);
  RepositoryOptions options;
  options.memory_budget_bytes = 20;
  options.read_memory_bytes =
      [](const std::string& path) -> absl::StatusOr<uint64_t> {
    if (path == "bad office") return absl::DataLossError("no header");
    return path == "good hall" ? 21 : 15;
  };
  Open(options);
  ASSERT_TRUE(repository_->Acquire("kitchen", "").ok());
  EXPECT_EQ(repository_->Stats().resident_bytes, 15u);
  EXPECT_EQ(repository_->Get("kitchen")->resident_bytes, 15u);
  const auto hall = repository_->Acquire("hall", "");
  EXPECT_EQ(base::ErrorInfoOf(hall.status()).reason, kMemoryBudget);
  EXPECT_THAT(hall.status().ToString(), HasSubstr("21 bytes"));
  // What is wrong with a file, its opening says.
  EXPECT_EQ(
      base::ErrorInfoOf(repository_->Acquire("office", "").status()).reason,
      kModelCorrupt);
  EXPECT_TRUE(repository_->Acquire("kitchen", "").ok());
}

TEST_F(SceneRepositoryTest, LoadsAtFirstUse) {
  source_->Put("kitchen", "1", "good kitchen", 5);
  source_->Put("office", "1", "good office", 7);
  Open();
  EXPECT_EQ(repository_->Get("office")->state, SceneState::kUnloaded);
  const auto scene = repository_->Acquire("office", "");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->name, "office");
  EXPECT_EQ((*scene)->version, "1");
  EXPECT_EQ((*scene)->localizer->info().dataset, "good office");
  EXPECT_EQ(repository_->Get("kitchen")->state, SceneState::kUnloaded);
  EXPECT_EQ(repository_->Stats().resident_bytes, 7u);
  EXPECT_EQ(repository_->Stats().counts.loads, 1u);
}

TEST_F(SceneRepositoryTest, WhatIsInMemoryIsAnsweredBeforeTheCallReturns) {
  source_->Put("kitchen", "1", "good");
  Open();
  ASSERT_TRUE(repository_->Acquire("kitchen", "").ok());
  bool answered = false;
  repository_->AcquireAsync("kitchen", "",
                            [&](const auto& scene) { answered = scene.ok(); });
  EXPECT_TRUE(answered);
}

TEST_F(SceneRepositoryTest, LoadsAllAtTheStartIfAsked) {
  for (const char* scene : {"a", "b", "c"}) source_->Put(scene, "1", "good", 4);
  source_->Put("d", "1", "bad", 4);
  Open({.memory_budget_bytes = 10, .load_all_at_start = true});
  EXPECT_TRUE(repository_->WaitForLoads().ok());
  EXPECT_EQ(repository_->Stats().resident_bytes, 8u);
  EXPECT_EQ(repository_->Stats().counts.evictions, 0u);
}

TEST_F(SceneRepositoryTest, NamesThatArePathsAreRefused) {
  source_->Put("kitchen", "1", "good");
  Open();
  for (const char* name : {"", "..", "../kitchen", "kitchen/1", ".kitchen"}) {
    const auto status = repository_->Acquire(name, "").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << name;
    EXPECT_EQ(base::ErrorInfoOf(status).reason, kSceneNameInvalid) << name;
    EXPECT_EQ(repository_->Get(name).status().code(),
              absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(repository_->Unload(name, "").status().code(),
              absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(Load(name).status().code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_EQ(repository_->Acquire("kitchen", "../1").status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(SceneRepositoryTest, FailuresDoNotSayWhereTheModelLies) {
  source_->Put("kitchen", "1", "/srv/models/x");
  Open({},
       [](const std::string& path)
           -> absl::StatusOr<std::unique_ptr<localizer::Localizer>> {
         return base::WithReason(
             absl::DataLossError(path + ": checksum mismatch"), "R");
       });
  const auto status = repository_->Acquire("kitchen", "").status();
  EXPECT_EQ(status.message(),
            "scene 'kitchen' version '1' could not be loaded: checksum "
            "mismatch");
  // Who knows more has the say.
  EXPECT_EQ(base::ErrorInfoOf(status).reason, "R");
}

TEST_F(SceneRepositoryTest, ASourceThatCannotBeListedIsAnError) {
  source_->SetError(absl::NotFoundError("reading folder /x"));
  const auto repository =
      SceneRepository::Open(std::move(owned_), OpenContent, {}, clock_);
  EXPECT_EQ(repository.status().code(), absl::StatusCode::kNotFound);
}

TEST_F(SceneRepositoryTest, BadOptionsAreRefused) {
  EXPECT_FALSE(RepositoryOptions{.loader_threads = 0}.Validate().ok());
  EXPECT_FALSE(RepositoryOptions{.loader_threads = 65}.Validate().ok());
  EXPECT_FALSE(RepositoryOptions{.poll_interval = std::chrono::milliseconds(-1)}
                   .Validate()
                   .ok());
  EXPECT_TRUE(RepositoryOptions{}.Validate().ok());
}

TEST_F(SceneRepositoryTest, ASourceThatFailsLaterLeavesAllAsItWas) {
  source_->Put("kitchen", "1", "good");
  Open();
  source_->SetError(absl::UnavailableError("gone fishing"));
  EXPECT_EQ(repository_->Rescan().code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(repository_->Acquire("kitchen", "").ok());
  EXPECT_EQ(repository_->Stats().rescan_failures, 1u);
  EXPECT_EQ(repository_->Stats().last_rescan.message(), "gone fishing");
  EXPECT_EQ(Load("kitchen").status().code(), absl::StatusCode::kUnavailable);
}

TEST_F(SceneRepositoryTest, LoadLooksAtTheSourceFirst) {
  Open();
  source_->Put("kitchen", "1", "good", 5);
  const auto status = Load("kitchen");
  ASSERT_TRUE(status.ok()) << status.status();
  EXPECT_EQ(status->state, SceneState::kReady);
  EXPECT_EQ(status->serving->version, "1");
  EXPECT_EQ(status->resident_bytes, 5u);
  source_->Put("kitchen", "2", "bad");
  EXPECT_EQ(Load("kitchen").status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Load("attic").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(SceneRepositoryTest, UnloadFreesTheMemoryWhenTheLastQueryHasEnded) {
  source_->Put("kitchen", "1", "good", 5);
  Open();
  auto scene = repository_->Acquire("kitchen", "");
  const auto status = repository_->Unload("kitchen", "");
  ASSERT_TRUE(status.ok()) << status.status();
  EXPECT_EQ(status->state, SceneState::kUnloaded);
  EXPECT_EQ(repository_->Stats().resident_bytes, 5u);
  scene = absl::UnknownError("let go");
  EXPECT_EQ(repository_->Stats().resident_bytes, 0u);
}

TEST_F(SceneRepositoryTest, AModelMayOutliveTheRepository) {
  source_->Put("kitchen", "1", "good");
  Open();
  const auto scene = repository_->Acquire("kitchen", "");
  repository_.reset();
  EXPECT_EQ((*scene)->localizer->info().dataset, "good");
}

TEST_F(SceneRepositoryTest, PollingFindsANewVersion) {
  source_->Put("kitchen", "1", "good");
  Open({.poll_interval = std::chrono::milliseconds(1)});
  ASSERT_TRUE(repository_->Acquire("kitchen", "").ok());
  source_->Put("kitchen", "2", "good");
  while ((*repository_->Acquire("kitchen", ""))->version != "2") {
    std::this_thread::yield();
  }
}

// Opens "good" only after the test says so.
class GatedOpener {
 public:
  LocalizerOpener opener() {
    return [this](const std::string& content) {
      if (++opened_ == 1) started_.Notify();
      gate_.WaitForNotification();
      return OpenContent(content);
    };
  }
  void WaitUntilStarted() { started_.WaitForNotification(); }
  void LetGo() { gate_.Notify(); }
  int opened() const { return opened_; }

 private:
  std::atomic<int> opened_{0};
  absl::Notification started_;
  absl::Notification gate_;
};

TEST_F(SceneRepositoryTest, ManyWaitersShareOneLoadAndBlockNoThread) {
  source_->Put("kitchen", "1", "good");
  GatedOpener gated;
  Open({}, gated.opener());
  std::atomic<int> answered{0};
  for (int i = 0; i < 1000; ++i) {
    repository_->AcquireAsync("kitchen", "", [&](const auto& scene) {
      if (scene.ok()) ++answered;
    });
  }
  EXPECT_EQ(answered, 0);
  gated.LetGo();
  EXPECT_TRUE(repository_->Acquire("kitchen", "").ok());
  repository_->Stop();
  EXPECT_EQ(answered, 1000);
  EXPECT_EQ(gated.opened(), 1);
}

TEST_F(SceneRepositoryTest, WaitingEndsWhenTheCallerIsStopped) {
  source_->Put("kitchen", "1", "good");
  GatedOpener gated;
  Open({}, gated.opener());
  std::stop_source stop;
  std::jthread stopper([&] {
    gated.WaitUntilStarted();
    stop.request_stop();
  });
  EXPECT_EQ(
      repository_->Acquire("kitchen", "", stop.get_token()).status().code(),
      absl::StatusCode::kCancelled);
  EXPECT_EQ(repository_->WaitForLoads(stop.get_token()).code(),
            absl::StatusCode::kCancelled);
  gated.LetGo();
  repository_->Stop();  // the loader must be through before the gate goes
}

TEST_F(SceneRepositoryTest, ThoseWhoWaitAreAnsweredWhenItStops) {
  source_->Put("kitchen", "1", "good");
  GatedOpener gated;
  Open({.loader_threads = 1}, gated.opener());
  absl::Notification answered;
  absl::Status status;
  repository_->AcquireAsync("kitchen", "", [&](const auto& scene) {
    status = scene.status();
    answered.Notify();
  });
  gated.WaitUntilStarted();
  // A task behind the load that will not be reached.
  absl::Status loaded;
  repository_->Load("kitchen", "",
                    [&](const auto& scene) { loaded = scene.status(); });
  std::jthread stopper([&] { repository_->Stop(); });
  answered.WaitForNotification();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  gated.LetGo();
  stopper.join();
  EXPECT_EQ(loaded.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorInfoOf(loaded).reason, kSceneNotLoaded);
  EXPECT_EQ(repository_->Acquire("other", "").status().code(),
            absl::StatusCode::kNotFound);
}

// As an operator does it, with files.
TEST_F(SceneRepositoryTest, ServesAFolderAndFollowsIt) {
  namespace fs = std::filesystem;
  const fs::path root =
      fs::path(testing::TempDir()) / ("repository-" + std::to_string(getpid()));
  const auto put = [&](const std::string& version, const std::string& content) {
    fs::create_directories(root / "kitchen" / version);
    const fs::path file = root / "kitchen" / version / "model.treeline";
    ASSERT_TRUE(base::WriteFileAtomically(file.string(), content).ok());
  };
  put("1", "good one");
  auto opened = SceneRepository::Open(
      std::make_unique<FolderSource>(root.string()),
      [](const std::string& path)
          -> absl::StatusOr<std::unique_ptr<localizer::Localizer>> {
        const auto content = base::ReadFile(path);
        if (!content.ok()) return content.status();
        return OpenContent(*content);
      },
      {}, clock_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  repository_ = *std::move(opened);
  const auto serving = [&] {
    const auto scene = repository_->Acquire("kitchen", "");
    return scene.ok() ? (*scene)->localizer->info().dataset
                      : scene.status().ToString();
  };
  const auto rescan = [&] {
    ASSERT_TRUE(repository_->Rescan().ok());
    ASSERT_TRUE(repository_->WaitForLoads().ok());
  };
  EXPECT_EQ(serving(), "good one");
  put("2", "half");
  rescan();
  EXPECT_EQ(serving(), "good one");
  put("2", "good two");
  rescan();
  EXPECT_EQ(serving(), "good two");
  put("2", "good two, mended");
  rescan();
  EXPECT_EQ(serving(), "good two, mended");
  fs::remove_all(root / "kitchen" / "2");
  rescan();
  EXPECT_EQ(serving(), "good one");
  fs::remove_all(root / "kitchen");
  rescan();
  EXPECT_EQ(serving(), "good one");
  ASSERT_TRUE(repository_->Unload("kitchen", "").ok());
  EXPECT_THAT(serving(), HasSubstr("NOT_FOUND"));
  fs::remove_all(root);
}

// Everything at once, for ThreadSanitizer: 12 scenes in room for 4, of which
// versions come, go and break.
TEST_F(SceneRepositoryTest, StandsEverythingAtOnce) {
  constexpr int kScenes = 12;
  constexpr int kRounds = 150;
  const auto name = [](uint32_t i) { return "scene-" + std::to_string(i); };
  for (uint32_t i = 0; i < kScenes; ++i) source_->Put(name(i), "1", "good", 5);
  std::atomic<uint64_t> loaded{0};
  Open({.memory_budget_bytes = 20,
        .poll_interval = std::chrono::milliseconds(1),
        .loader_threads = 3,
        .load_all_at_start = true,
        .on_event = [&](const RepositoryEvent& event) {
          if (event.kind == RepositoryEvent::Kind::kLoaded) ++loaded;
        }});
  std::atomic<int> asked{0};
  std::atomic<int> answered{0};
  std::atomic<int> wrong{0};
  const auto query = [&](uint64_t seed) {
    base::Random random(seed, 1);
    for (int i = 0; i < kRounds; ++i) {
      const std::string scene = name(random.NextBelow(kScenes));
      ++asked;
      repository_->AcquireAsync(
          scene, "",
          [&, scene](const absl::StatusOr<std::shared_ptr<const Scene>>& got) {
            ++answered;
            // It may call the repository.
            if (repository_->Get(scene)->versions.empty()) ++wrong;
            if (!got.ok() || (*got)->name != scene ||
                (*got)->localizer->info().dataset != "good") {
              ++wrong;
            }
          });
      // One that lasts.
      const auto held = repository_->Acquire(scene, "");
      if (!held.ok() || (*held)->localizer->info().dataset != "good") ++wrong;
      if (repository_->Stats().scenes.size() != kScenes) ++wrong;
    }
  };
  const auto operate = [&](uint64_t seed) {
    base::Random random(seed, 2);
    for (int i = 0; i < kRounds; ++i) {
      const std::string scene = name(random.NextBelow(kScenes));
      switch (random.NextBelow(6)) {
        case 0:
          (void)repository_->Unload(scene, "");
          break;
        case 1:
          source_->Put(scene, "2", "good", 5);
          break;
        case 2:
          source_->Put(scene, "3", "broken", 5);
          break;
        case 3:
          source_->Remove(scene, "2");
          break;
        case 4:
          ++asked;
          repository_->Load(scene, "1", [&](const auto& status) {
            ++answered;
            if (!status.ok()) ++wrong;
          });
          break;
        default:
          (void)repository_->Rescan();
          for (const SceneStatus& status : repository_->List()) {
            if (status.versions.empty()) ++wrong;
          }
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (uint64_t seed = 0; seed < 4; ++seed) {
      threads.emplace_back([&, seed] { query(seed); });
    }
    threads.emplace_back([&] { operate(7); });
    threads.emplace_back([&] { operate(8); });
  }
  EXPECT_TRUE(repository_->WaitForLoads().ok());
  EXPECT_LE(repository_->Stats().resident_bytes, 20u);
  repository_->Stop();
  EXPECT_EQ(answered, asked);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(loaded, repository_->Stats().counts.loads);
}

}  // namespace
}  // namespace treeline::repository
