// For the tests of SceneTable.
#ifndef SERVER_REPOSITORY_SCENE_TABLE_FIXTURE_H_
#define SERVER_REPOSITORY_SCENE_TABLE_FIXTURE_H_

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "server/repository/repository_test_util.h"
#include "server/repository/scene_table.h"

namespace treeline::repository {

using ScenePtr = std::shared_ptr<const Scene>;

// A table with the source, the loader and the memory that it needs, all on one
// thread: every test says when what happens.
class SceneTableTest : public testing::Test {
 protected:
  SceneTableTest() : SceneTableTest(0) {}
  explicit SceneTableTest(uint64_t budget) : table_(budget) {}

  void Rescan() {
    SceneTable::Effects effects;
    table_.Apply(*source_.List(), clock_.Now(), effects);
    Carry(effects);
  }
  // Runs the queued loads, or only the first `count` of them; returns what was
  // loaded, as "scene/version".
  std::vector<std::string> RunLoads(int count = 1000) {
    std::vector<std::string> loaded;
    for (; count > 0; --count) {
      const auto job = Next();
      if (!job) break;
      loaded.push_back(job->model.scene + "/" + job->model.version);
      Finish(*job);
    }
    return loaded;
  }
  std::optional<SceneTable::Job> Next() {
    while (true) {
      SceneTable::Effects effects;
      auto job = table_.NextJob(resident_, clock_.Now(), effects);
      if (job || effects.empty()) return job;
      Carry(effects);
    }
  }
  void Finish(const SceneTable::Job& job) {
    absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer;
    const auto content = source_.Fetch(job.model, {});
    auto opened = content.ok() ? OpenContent(*content) : content.status();
    if (!opened.ok()) {
      localizer = opened.status();
    } else {
      resident_ += job.model.reserved_bytes();
      localizer = std::shared_ptr<const localizer::Localizer>(
          opened->release(), [this, bytes = job.model.reserved_bytes()](
                                 const localizer::Localizer* gone) {
            delete gone;
            resident_ -= bytes;
          });
    }
    SceneTable::Effects effects;
    table_.Finish(job, std::move(localizer), 0.25, clock_.Now(), effects);
    Carry(effects);
  }
  // What came of an Acquire or a Load.
  struct Asked {
    bool answered = false;
    absl::StatusOr<ScenePtr> scene = absl::UnknownError("no answer");
  };
  std::shared_ptr<Asked> Ask(const std::string& scene,
                             const std::string& version = "") {
    auto asked = std::make_shared<Asked>();
    SceneTable::Effects effects;
    table_.Acquire(scene, version, Into(asked), clock_.Now(), effects);
    Carry(effects);
    return asked;
  }
  std::shared_ptr<Asked> Load(const std::string& scene,
                              const std::string& version = "") {
    auto asked = std::make_shared<Asked>();
    SceneTable::Effects effects;
    table_.Load(scene, version, Into(asked), clock_.Now(), effects);
    Carry(effects);
    return asked;
  }
  static AcquireDone Into(const std::shared_ptr<Asked>& asked) {
    return [asked](absl::StatusOr<ScenePtr> scene) {
      EXPECT_FALSE(asked->answered);
      *asked = {true, std::move(scene)};
    };
  }
  // Asks, loads what that needs, and returns the version, or the error.
  std::string Answer(const std::string& scene,
                     const std::string& version = "") {
    const auto asked = Ask(scene, version);
    RunLoads();
    EXPECT_TRUE(asked->answered);
    return asked->scene.ok() ? (*asked->scene)->version
                             : asked->scene.status().ToString();
  }
  void Unload(const std::string& scene, const std::string& version = "") {
    SceneTable::Effects effects;
    EXPECT_TRUE(table_.Unload(scene, version, effects).ok());
    Carry(effects);
  }
  SceneState StateOf(const std::string& scene, size_t version) {
    return table_.Get(scene)->versions.at(version).state;
  }
  void Carry(SceneTable::Effects& effects) {
    effects.released.clear();
    for (const RepositoryEvent& event : effects.events) {
      events_.push_back(absl::StrCat(EventName(event.kind), " ", event.scene,
                                     "/", event.version));
    }
    effects.events.clear();
    for (const auto& answer : effects.answers) answer();
    effects.answers.clear();
  }

  std::vector<std::string> events_;
  ManualClock clock_;
  FakeSource source_;
  uint64_t resident_ = 0;
  SceneTable table_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_TABLE_FIXTURE_H_
