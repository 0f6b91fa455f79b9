#include "server/app/failed_query_recorder.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/app/recording_dispatcher.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::server_app {
namespace {

namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class FailedQueryRecorderTest : public testing::Test {
 protected:
  FailedQueryRecorderTest()
      : folder_(absl::StrCat(
            testing::TempDir(), "/recorder-", getpid(), "-",
            testing::UnitTest::GetInstance()->current_test_info()->name())) {}
  ~FailedQueryRecorderTest() override {
    recorder_.reset();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  void Start(uint64_t max_bytes = 1 << 20, size_t max_pending = 16) {
    recorder_.reset();
    auto recorder = FailedQueryRecorder::Start(
        {.folder = folder_, .max_bytes = max_bytes, .max_pending = max_pending},
        [this] {
          // 2026-11-21T10:50:19Z and on, a second each.
          return std::chrono::system_clock::time_point(
              std::chrono::seconds(1795258219 + seconds_++));
        },
        [this](const absl::Status& status) { health_.push_back(status); });
    ASSERT_TRUE(recorder.ok()) << recorder.status();
    recorder_ = *std::move(recorder);
  }
  void Record(const std::string& reason, size_t bytes) {
    recorder_->Offer({reason, std::string(bytes - 10, 'r'), "0123456789"});
    recorder_->WaitUntilIdle();
  }
  std::set<std::string> Files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  void PutFile(const std::string& name, size_t bytes) const {
    std::ofstream(folder_ + "/" + name) << std::string(bytes, 'x');
  }

  const std::string folder_;
  int seconds_ = 0;
  std::vector<absl::Status> health_;
  std::unique_ptr<FailedQueryRecorder> recorder_;
};

TEST_F(FailedQueryRecorderTest, AQueryIsItsBytesAndWhatIsKnownOfIt) {
  Start();
  recorder_->Offer({"TOO_FEW_INLIERS", "request", "{}"});
  recorder_->WaitUntilIdle();
  const std::string stem = "20261121T105019.000Z-000001-TOO_FEW_INLIERS";
  EXPECT_THAT(Files(), ElementsAre(stem + ".binpb", stem + ".json"));
  EXPECT_EQ(base::ReadFile(folder_ + "/" + stem + ".binpb").value(), "request");
  EXPECT_EQ(base::ReadFile(folder_ + "/" + stem + ".json").value(), "{}");
  EXPECT_EQ(recorder_->written(), 1u);
  EXPECT_EQ(recorder_->bytes_on_disk(), 9u);
}

TEST_F(FailedQueryRecorderTest, TheFolderIsForItsUserAlone) {
  Start();
  EXPECT_EQ(fs::status(folder_).permissions(), fs::perms::owner_all);
}

TEST_F(FailedQueryRecorderTest, TheOldestMakeRoom) {
  Start(/*max_bytes=*/1000);
  for (int i = 0; i < 5; ++i) Record(absl::StrCat("R", i), 400);
  EXPECT_THAT(Files(), ElementsAre("20261121T105022.000Z-000004-R3.binpb",
                                   "20261121T105022.000Z-000004-R3.json",
                                   "20261121T105023.000Z-000005-R4.binpb",
                                   "20261121T105023.000Z-000005-R4.json"));
  EXPECT_EQ(recorder_->bytes_on_disk(), 800u);
  EXPECT_EQ(recorder_->written(), 5u);
}

TEST_F(FailedQueryRecorderTest, AnEarlierRunCountsAndIsCleanedUp) {
  Start(/*max_bytes=*/1000);
  Record("OLD", 400);
  Record("NEWER", 400);
  PutFile("20261121T105019.000Z-000009-X.binpb.tmp-77", 5000);
  PutFile("notes.txt", 5000);
  PutFile("20261121-holiday.json", 5000);
  Start(/*max_bytes=*/500);
  EXPECT_EQ(recorder_->bytes_on_disk(), 400u);
  const auto files = Files();
  EXPECT_EQ(files.size(), 4u) << "a query of two files, and two foreign ones";
  EXPECT_EQ(files.count("notes.txt"), 1u);
  EXPECT_EQ(files.count("20261121-holiday.json"), 1u);
  EXPECT_EQ(files.count("20261121T105020.000Z-000002-NEWER.binpb"), 1u);
}

TEST_F(FailedQueryRecorderTest, WhatCanNeverFitIsDropped) {
  Start(/*max_bytes=*/1000);
  EXPECT_FALSE(recorder_->HasRoomFor(1001));
  EXPECT_EQ(recorder_->dropped(), 1u);
  Record("LARGE", 1001);
  EXPECT_EQ(recorder_->dropped(), 2u);
  EXPECT_THAT(Files(), IsEmpty());
}

TEST_F(FailedQueryRecorderTest, WhatComesTooFastIsDroppedAndCounted) {
  Start(/*max_bytes=*/1 << 20, /*max_pending=*/2);
  constexpr uint64_t kOffered = 200;
  for (uint64_t i = 0; i < kOffered; ++i) {
    recorder_->Offer({"R", std::string(1000, 'r'), "{}"});
  }
  recorder_->WaitUntilIdle();
  EXPECT_GE(recorder_->written(), 1u);
  EXPECT_EQ(recorder_->written() + recorder_->dropped(), kOffered);
  EXPECT_EQ(Files().size(), 2 * recorder_->written());
}

TEST_F(FailedQueryRecorderTest, WhatWaitsIsWrittenBeforeItEnds) {
  Start();
  for (int i = 0; i < 5; ++i) recorder_->Offer({"R", "request", "{}"});
  recorder_.reset();
  EXPECT_EQ(Files().size(), 10u);
}

TEST_F(FailedQueryRecorderTest, ADiskThatRefusesCostsOnlyTheRecord) {
  Start();
  Record("FIRST", 100);
  fs::remove_all(folder_);  // as good as a full disk, for root too
  Record("SECOND", 100);
  Record("THIRD", 100);
  EXPECT_EQ(recorder_->failed(), 2u);
  ASSERT_EQ(health_.size(), 1u) << "said once, not for each";
  EXPECT_THAT(std::string(health_[0].message()), HasSubstr(folder_));
  fs::create_directory(folder_);
  Record("FOURTH", 100);
  ASSERT_EQ(health_.size(), 2u);
  EXPECT_TRUE(health_[1].ok());
  EXPECT_EQ(Files().size(), 2u);
}

TEST_F(FailedQueryRecorderTest, ReasonsAreNoPaths) {
  Start();
  Record("../../etc/x\n", 100);
  for (const std::string& name : Files()) {
    EXPECT_TRUE(
        absl::StartsWith(name, "20261121T105019.000Z-000001-______etc_x_."))
        << name;
  }
  EXPECT_EQ(Files().size(), 2u);
}

TEST_F(FailedQueryRecorderTest, AFolderThatCannotBeIsAnError) {
  const auto recorder = FailedQueryRecorder::Start(
      {.folder = "/proc/nowhere/x"},
      [] { return std::chrono::system_clock::time_point(); },
      [](const absl::Status&) {});
  EXPECT_FALSE(recorder.ok());
  EXPECT_THAT(std::string(recorder.status().message()),
              HasSubstr("/proc/nowhere/x"));
}

// Answers Localize with what it was given.
class FakeDispatcher final : public service::Dispatcher {
 public:
  absl::StatusOr<service::Client> Admit(const service::CallInfo&,
                                        service::Scope) override {
    return service::Client{};
  }
  absl::StatusOr<service::Client> Identify(const service::CallInfo&,
                                           service::Scope) override {
    return service::Client{};
  }
  void Localize(service::CallInfo, const v1::LocalizeRequest&,
                Done<v1::LocalizeResponse> done) override {
    done(answer);
  }
  void ListScenes(service::CallInfo, const v1::ListScenesRequest&,
                  Done<v1::ListScenesResponse> done) override {
    done(v1::ListScenesResponse());
  }
  void GetScene(service::CallInfo, const v1::GetSceneRequest&,
                Done<v1::GetSceneResponse> done) override {
    done(v1::GetSceneResponse());
  }
  void LoadScene(service::CallInfo, const v1::LoadSceneRequest&,
                 Done<v1::LoadSceneResponse> done) override {
    done(v1::LoadSceneResponse());
  }
  void UnloadScene(service::CallInfo, const v1::UnloadSceneRequest&,
                   Done<v1::UnloadSceneResponse> done) override {
    done(v1::UnloadSceneResponse());
  }
  void GetSceneMap(service::CallInfo, const v1::GetSceneMapRequest&,
                   Done<v1::GetSceneMapResponse> done) override {
    done(v1::GetSceneMapResponse());
  }
  void ListRecentQueries(service::CallInfo, const v1::ListRecentQueriesRequest&,
                         Done<v1::ListRecentQueriesResponse> done) override {
    done(v1::ListRecentQueriesResponse());
  }
  void Reject(const service::CallInfo&, const v1::LocalizeRequest&,
              const absl::Status&) override {}
  service::Load load() const override { return {.queued = 3}; }

  absl::StatusOr<v1::LocalizeResponse> answer = v1::LocalizeResponse();
};

class RecordingDispatcherTest : public FailedQueryRecorderTest {
 protected:
  // What is left on disk of a query with this answer: its JSON, or "".
  std::string Kept(absl::StatusOr<v1::LocalizeResponse> answer) {
    Start();
    inner_.answer = std::move(answer);
    RecordingDispatcher dispatcher(inner_, *recorder_);
    v1::LocalizeRequest request;
    request.set_scene("kitchen");
    service::CallInfo call;
    call.credentials.bearer_token = "secret-token";
    call.traceparent =
        "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
    int answers = 0;
    dispatcher.Localize(call, request,
                        [&](const absl::StatusOr<v1::LocalizeResponse>& got) {
                          ++answers;
                          EXPECT_EQ(got.status(), inner_.answer.status());
                        });
    EXPECT_EQ(answers, 1);
    recorder_->WaitUntilIdle();
    std::string json;
    for (const std::string& name : Files()) {
      const std::string bytes = base::ReadFile(folder_ + "/" + name).value();
      EXPECT_THAT(bytes, Not(HasSubstr("secret-token")));
      if (absl::EndsWith(name, ".json")) json = bytes;
      if (absl::EndsWith(name, ".binpb")) {
        EXPECT_EQ(bytes, request.SerializeAsString());
      }
    }
    recorder_.reset();
    fs::remove_all(folder_);
    return json;
  }

  FakeDispatcher inner_;
};

TEST_F(RecordingDispatcherTest, KeepsWhatWasNotLocalized) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
  response.set_reason(v1::NOT_LOCALIZED_REASON_LOW_CONFIDENCE);
  response.set_inliers(7);
  const std::string json = Kept(response);
  EXPECT_THAT(json, HasSubstr("\"reason\": \"LOW_CONFIDENCE\""));
  EXPECT_THAT(json, HasSubstr("\"inliers\": 7"));
  EXPECT_THAT(json, HasSubstr("0af7651916cd43dd8448eb211c80319c"));
}

TEST_F(RecordingDispatcherTest, KeepsWhatWasRefusedAsInvalidAndFaults) {
  EXPECT_THAT(Kept(absl::InvalidArgumentError("frame.color: \xff")),
              HasSubstr("\"message\": \"frame.color: \\ufffd\""));
  EXPECT_THAT(Kept(absl::InternalError("a fault")),
              HasSubstr("\"status\": \"INTERNAL\""));
}

TEST_F(RecordingDispatcherTest, KeepsNothingElse) {
  v1::LocalizeResponse localized;
  localized.set_outcome(v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(Kept(localized), "");
  EXPECT_EQ(Kept(absl::UnavailableError("overloaded")), "");
  EXPECT_EQ(Kept(absl::UnauthenticatedError("no token")), "");
  EXPECT_EQ(Kept(absl::PermissionDeniedError("no scope")), "");
  EXPECT_EQ(Kept(absl::ResourceExhaustedError("rate")), "");
  EXPECT_EQ(Kept(absl::DeadlineExceededError("late")), "");
  EXPECT_EQ(Kept(absl::CancelledError("gone")), "");
  EXPECT_EQ(Kept(absl::NotFoundError("no scene")), "");
}

TEST_F(RecordingDispatcherTest, TheRestGoesThrough) {
  Start();
  RecordingDispatcher dispatcher(inner_, *recorder_);
  int answers = 0;
  const auto count = [&](const auto& answer) { answers += answer.ok(); };
  dispatcher.ListScenes({}, {}, count);
  dispatcher.GetScene({}, {}, count);
  dispatcher.LoadScene({}, {}, count);
  dispatcher.UnloadScene({}, {}, count);
  EXPECT_EQ(answers, 4);
  EXPECT_EQ(dispatcher.load().queued, 3);
}

}  // namespace
}  // namespace treeline::server_app
