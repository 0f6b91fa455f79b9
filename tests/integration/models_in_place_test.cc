// Model files that somebody writes to while a server under load serves them:
// what is in memory goes on, what is read anew and is bad fails its scene, and
// the other scenes do not notice.
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/synchronization/mutex.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;

// Asks for one scene again and again until it is destroyed.
class Asker {
 public:
  Asker(const std::string& address, relocalizer::LocalizeQuery query)
      : client_(relocalizer::ConnectRelocalizer({.server = address}).value()),
        query_(std::move(query)),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Until that many more answers have begun and ended.
  void WaitForMore(int answers) {
    absl::MutexLock lock(&mutex_);
    // One may have been under way.
    const int wanted = answers_ + answers + 1;
    const auto enough = [&] {
      mutex_.AssertReaderHeld();
      return answers_ >= wanted;
    };
    EXPECT_TRUE(mutex_.AwaitWithTimeout(absl::Condition(&enough), kPatience));
  }
  // The first error; OK if there was none.
  absl::Status first_error() const {
    absl::MutexLock lock(&mutex_);
    return first_error_;
  }

 private:
  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const absl::Status status = client_->Localize(query_, {}).status();
      absl::MutexLock lock(&mutex_);
      ++answers_;
      first_error_.Update(status);
    }
  }

  const std::unique_ptr<relocalizer::Relocalizer> client_;
  const relocalizer::LocalizeQuery query_;
  mutable absl::Mutex mutex_;
  int answers_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status first_error_ ABSL_GUARDED_BY(mutex_);
  std::jthread thread_;  // last, so that it ends first
};

class ModelsInPlace : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    const auto bytes = base::ReadFile(RoomModelPath());
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    good_ = *bytes;
    PutRoom("other");
    PutModel("victim", "1", good_);
    path_ = models_ + "/victim/1/model.treeline";
    StartServer({"--drain-s", "0", "--poll-s", "0.02"});
    const std::string prefix = "admin on ";
    const auto line = server_->WaitForLine(prefix);
    ASSERT_TRUE(line.has_value()) << server_->err();
    auto admin = relocalizer::ConnectRelocalizer(
        {.server = line->substr(prefix.size())});
    ASSERT_TRUE(admin.ok()) << admin.status();
    admin_ = *std::move(admin);
  }
  void TearDown() override {
    admin_.reset();
    ServerTest::TearDown();
  }

  // As `cp` does it: the same file, with other bytes from its start on.
  void CopyOver(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  static relocalizer::LocalizeQuery Query(const std::string& scene) {
    relocalizer::LocalizeQuery query = QueryOf(HeldOutFrames(), 0);
    query.scene = scene;
    return query;
  }
  std::unique_ptr<Asker> Ask(const std::string& scene) const {
    return std::make_unique<Asker>(address_, Query(scene));
  }
  absl::StatusCode LoadVictim() const {
    return admin_->LoadScene("victim", "", {}).status().code();
  }

  std::unique_ptr<relocalizer::Relocalizer> admin_;
  std::string good_;
  std::string path_;
};

TEST_F(ModelsInPlace, WhatIsInMemoryServesWhateverHappensToItsFile) {
  const std::pair<const char*, std::function<void()>> changes[] = {
      {"nothing", [] {}},
      {"truncated", [&] { fs::resize_file(path_, good_.size() / 2); }},
      {"emptied", [&] { fs::resize_file(path_, 0); }},
      {"written over with noise",
       [&] { CopyOver(std::string(good_.size(), '\xa5')); }},
      {"written over halfway",
       [&] { CopyOver(good_.substr(0, good_.size() / 2)); }},
      {"longer", [&] { CopyOver(good_ + good_); }},
      {"deleted", [&] { fs::remove(path_); }},
      {"there again", [&] { CopyOver(good_); }},
  };
  const auto victim = Ask("victim");
  const auto other = Ask("other");
  for (const auto& [name, change] : changes) {
    change();
    victim->WaitForMore(5);
    other->WaitForMore(5);
    ASSERT_TRUE(server_->IsRunning()) << name << "\n" << server_->err();
    EXPECT_TRUE(victim->first_error().ok())
        << name << ": " << victim->first_error();
    EXPECT_TRUE(other->first_error().ok())
        << name << ": " << other->first_error();
  }
}

TEST_F(ModelsInPlace, ABadFileFailsItsSceneWhenItIsReadAndAGoodOneMendsIt) {
  const auto other = Ask("other");
  ASSERT_EQ(LoadVictim(), absl::StatusCode::kOk);
  fs::resize_file(path_, good_.size() / 2);
  EXPECT_EQ(LoadVictim(), absl::StatusCode::kDataLoss);
  // Out of memory there is nothing left of it.
  EXPECT_TRUE(admin_->UnloadScene("victim", "", {}).ok());
  const absl::Status refused = client_->Localize(Query("victim"), {}).status();
  EXPECT_TRUE(absl::IsDataLoss(refused)) << refused;
  const auto scene = client_->GetScene("victim", {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->state, "FAILED");
  CopyOver(good_);
  EXPECT_EQ(LoadVictim(), absl::StatusCode::kOk);
  EXPECT_TRUE(client_->Localize(Query("victim"), {}).ok());
  other->WaitForMore(3);
  EXPECT_TRUE(other->first_error().ok()) << other->first_error();
  EXPECT_TRUE(server_->IsRunning()) << server_->err();
}

TEST_F(ModelsInPlace, AFileThatChangesWhileItIsReadIsLoadedOrRefused) {
  const auto other = Ask("other");
  const std::jthread writer([&](const std::stop_token& stop) {
    for (size_t i = 0; !stop.stop_requested(); ++i) {
      CopyOver(good_);
      fs::resize_file(path_, good_.size() * (i % 10) / 10);
    }
  });
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(admin_->UnloadScene("victim", "", {}).ok());
    const absl::StatusCode code = LoadVictim();
    EXPECT_TRUE(code == absl::StatusCode::kOk ||
                code == absl::StatusCode::kDataLoss)
        << absl::StatusCodeToString(code);
    ASSERT_TRUE(server_->IsRunning()) << server_->err();
  }
  other->WaitForMore(3);
  EXPECT_TRUE(other->first_error().ok()) << other->first_error();
}

}  // namespace
}  // namespace treeline
