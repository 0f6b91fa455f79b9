// Models from a web server that fails in all the ways that web servers do.
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "tests/integration/http_source_fixture.h"

namespace treeline {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class HttpSourceFaults : public HttpSourceTest {
 protected:
  void ExpectFetched() {
    const auto path = Fetch();
    ASSERT_TRUE(path.ok()) << path.status();
    EXPECT_EQ(base::ReadFile(*path).value(), model_);
    EXPECT_THAT(CachedNames(), ElementsAre(DigestOf(model_) + ".treeline"));
  }

  // Lets go of a server that stalls. Outlives its threads.
  absl::Notification done_;
};

TEST_F(HttpSourceFaults, ATruncatedBodyIsContinuedWithARange) {
  Serve(Model(100000), {{.stop_after = 60000}, {}});
  ExpectFetched();
  const auto requests = server_->Requests("/model.treeline");
  ASSERT_THAT(requests, SizeIs(2));
  EXPECT_EQ(requests[1].range, "bytes=60000-");
  EXPECT_EQ(requests[1].sent, 40000u);
}

TEST_F(HttpSourceFaults, AServerWithoutRangesStartsOver) {
  Serve(Model(100000), {{.stop_after = 60000}, {.ranges = false}});
  ExpectFetched();
  EXPECT_EQ(server_->Requests("/model.treeline")[1].sent, 100000u);
}

TEST_F(HttpSourceFaults, ARefusedRangeStartsOver) {
  Serve(Model(100000), {{.stop_after = 60000}, {.status = 416}, {}});
  ExpectFetched();
  const auto requests = server_->Requests("/model.treeline");
  ASSERT_THAT(requests, SizeIs(3));
  EXPECT_EQ(requests[2].range, "");
}

TEST_F(HttpSourceFaults, AWrongRangeStartsOver) {
  Serve(Model(100000),
        {{.stop_after = 60000},
         {.headers = {{"Content-Range", "bytes 0-99999/100000"}}},
         {}});
  ExpectFetched();
}

TEST_F(HttpSourceFaults, OtherBytesThanPromisedAreRefused) {
  const std::string model = Model(100000);
  for (const std::string& other :
       {Model(100000, 'x'), Model(100001), Model(99999), std::string()}) {
    Serve(model);
    server_->Put("/model.treeline", other);
    source_.reset();
    const auto path = Fetch();
    EXPECT_TRUE(absl::IsDataLoss(path.status())) << path.status();
    EXPECT_EQ(base::ErrorInfoOf(path.status()).reason, "MODEL_CORRUPT");
    EXPECT_THAT(path.status().ToString(), HasSubstr("scene kitchen"));
    EXPECT_EQ(CachedNames().count(DigestOf(model) + ".treeline"), 0u);
  }
  // What is right later is taken.
  server_->Put("/model.treeline", model);
  ExpectFetched();
}

TEST_F(HttpSourceFaults, ADamagedPartOfAnEarlierProcessIsNotTheEnd) {
  Serve(Model(100000), {{.status = 404}, {}});
  EXPECT_FALSE(Fetch().ok());
  std::ofstream(absl::StrCat(folder_, "/sha256/", DigestOf(model_), ".part"))
      << std::string(5000, 'x');
  ExpectFetched();
}

TEST_F(HttpSourceFaults, WhatLastsIsNotTriedAgain) {
  const struct {
    int status;
    absl::StatusCode code;
    const char* reason;
  } cases[] = {
      {404, absl::StatusCode::kNotFound, "SOURCE_FILE_MISSING"},
      {401, absl::StatusCode::kPermissionDenied, "SOURCE_REFUSED"},
      {403, absl::StatusCode::kPermissionDenied, "SOURCE_REFUSED"},
      {418, absl::StatusCode::kFailedPrecondition, "SOURCE_REFUSED"},
  };
  for (const auto& [status, code, reason] : cases) {
    Serve(Model(static_cast<size_t>(status)), {{.status = status}});
    source_.reset();
    const auto path = Fetch();
    EXPECT_EQ(path.status().code(), code) << path.status();
    EXPECT_EQ(base::ErrorInfoOf(path.status()).reason, reason);
  }
  EXPECT_THAT(pauses_, IsEmpty());
  EXPECT_THAT(CachedNames(), IsEmpty());
}

TEST_F(HttpSourceFaults, WhatMayPassIsTriedAgain) {
  Serve(Model(1000), {{.status = 503},
                      {.status = 429, .headers = {{"Retry-After", "3"}}},
                      {.status = 500},
                      {}});
  ExpectFetched();
  ASSERT_THAT(pauses_, SizeIs(3));
  EXPECT_LE(pauses_[0], milliseconds(250));
  EXPECT_EQ(pauses_[1], milliseconds(3000));
}

TEST_F(HttpSourceFaults, ALongPauseIsLeftToWhoAsked) {
  Serve(Model(1000), {{.status = 503, .headers = {{"Retry-After", "3600"}}}});
  const auto path = Fetch();
  EXPECT_TRUE(absl::IsUnavailable(path.status()));
  EXPECT_EQ(base::RetryAfterOf(path.status()), milliseconds(3600000));
  EXPECT_THAT(pauses_, IsEmpty());
}

TEST_F(HttpSourceFaults, AStalledBodyIsGivenUpAndContinued) {
  Serve(Model(100000),
        {{.stop_after = 60000, .at_stop = [&] { done_.WaitForNotification(); }},
         {}});
  options_.http.stall_timeout = milliseconds(300);
  ExpectFetched();
  done_.Notify();
  EXPECT_EQ(server_->Requests("/model.treeline")[1].range, "bytes=60000-");
}

TEST_F(HttpSourceFaults, ACancelledFetchEndsAtOnce) {
  std::stop_source stop;
  std::chrono::steady_clock::time_point stopped;
  Serve(Model(100000), {{.stop_after = 60000, .at_stop = [&] {
                           stopped = std::chrono::steady_clock::now();
                           stop.request_stop();
                           done_.WaitForNotification();
                         }}});
  const auto path = Fetch(stop.get_token());
  const auto took = std::chrono::steady_clock::now() - stopped;
  done_.Notify();
  EXPECT_TRUE(absl::IsCancelled(path.status())) << path.status();
  // 100 ms are promised; the machine that tests may be busy.
  EXPECT_LT(took, std::chrono::seconds(1));
  RecordProperty("cancelled_after_us",
                 absl::StrCat(took / std::chrono::microseconds(1)));
}

TEST_F(HttpSourceFaults, AStopOfTheWholeSourceEndsAListing) {
  std::stop_source stop;
  options_.stop = stop.get_token();
  server_->Put("/index.json", R"({"models":[]})",
               {{.stop_after = 3, .at_stop = [&] {
                   stop.request_stop();
                   done_.WaitForNotification();
                 }}});
  Open();
  const auto listing = source_->List();
  done_.Notify();
  EXPECT_TRUE(absl::IsCancelled(listing.status())) << listing.status();
}

TEST_F(HttpSourceFaults, ThreadsThatWantTheSameFetchItOnce) {
  Serve(Model(1000000));
  ASSERT_NO_FATAL_FAILURE(Open());
  ASSERT_TRUE(source_->List().ok());
  std::vector<std::thread> threads;
  std::vector<absl::StatusOr<std::string>> paths(8);
  for (auto& path : paths) {
    threads.emplace_back([&] { path = source_->Fetch(RefOf(model_), {}); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& path : paths) {
    ASSERT_TRUE(path.ok()) << path.status();
    EXPECT_EQ(base::ReadFile(*path).value(), model_);
  }
  EXPECT_THAT(server_->Requests("/model.treeline"), SizeIs(1));
}

// Children are forked before there are threads: the server's come later.
class HttpSourceProcesses : public HttpSourceFaults {
 protected:
  void SetUp() override {
    HttpSourceTest::SetUp();
    server_.reset();
    ASSERT_EQ(pipe(pipe_), 0);
  }

  pid_t StartChild() {
    const pid_t child = fork();
    if (child == 0) {
      char url[256] = {};
      if (read(pipe_[0], url, sizeof(url)) != sizeof(url)) _exit(2);
      options_.url = url;
      FetchAndExit();
    }
    return child;
  }

  // Starts the server, and lets so many children begin.
  void StartServer(int children, std::vector<WebAnswer> answers) {
    server_ = std::make_unique<WebServer>();
    options_.url = server_->address() + "/";
    Serve(model_, std::move(answers));
    char url[256] = {};
    options_.url.copy(url, sizeof(url) - 1);
    for (int i = 0; i < children; ++i) {
      ASSERT_EQ(write(pipe_[1], url, sizeof(url)),
                static_cast<ssize_t>(sizeof(url)));
    }
  }

  int pipe_[2] = {-1, -1};
};

TEST_F(HttpSourceProcesses, WhatTheKilledOneFetchedIsNotFetchedAgain) {
  model_ = Model(500000);
  const pid_t child = StartChild();
  // What the child has written when it is killed.
  const std::string part =
      absl::StrCat(folder_, "/sha256/", DigestOf(model_), ".part");
  absl::Notification killed;
  StartServer(
      1, {{.stop_after = 300000,
           .at_stop =
               [&] {
                 std::error_code error;
                 while (std::filesystem::file_size(part, error) != 300000) {
                   std::this_thread::yield();
                 }
                 kill(child, SIGKILL);
                 killed.Notify();
               }},
          {}});
  killed.WaitForNotification();
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_THAT(CachedNames(), ElementsAre(DigestOf(model_) + ".part"));
  ExpectFetched();
  const auto requests = server_->Requests("/model.treeline");
  ASSERT_THAT(requests, SizeIs(2));
  EXPECT_EQ(requests[1].range, "bytes=300000-");
}

TEST_F(HttpSourceProcesses, ProcessesThatWantTheSameFetchItOnce) {
  model_ = Model(1000000);
  std::vector<pid_t> children;
  for (int i = 0; i < 4; ++i) children.push_back(StartChild());
  StartServer(4, {{}});
  for (const pid_t child : children) {
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
  }
  ExpectFetched();
  EXPECT_THAT(server_->Requests("/model.treeline"), SizeIs(1));
}

// A file system of 4 MiB, where this process may mount one.
class HttpSourceFullDisk : public HttpSourceFaults {
 protected:
  void SetUp() override {
    HttpSourceTest::SetUp();
    std::filesystem::create_directories(folder_);
    mounted_ = mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=4m") == 0;
    if (!mounted_) GTEST_SKIP() << "may not mount; DigestCacheTest covers it";
  }
  void TearDown() override {
    source_.reset();
    if (mounted_) umount2(folder_.c_str(), MNT_DETACH);
    HttpSourceTest::TearDown();
  }

  bool mounted_ = false;
};

TEST_F(HttpSourceFullDisk, WhatWasFetchedServesAndNothingIsHalfWritten) {
  Serve(Model(1000000));
  const auto first = Fetch();
  ASSERT_TRUE(first.ok()) << first.status();
  const std::string first_model = model_;
  const auto kept = source_->Keep(RefOf(first_model));

  // Fits when it begins; then another program fills the disk.
  absl::Notification filled;
  Serve(Model(2000000, 'x'), {{.stop_after = 500000,
                               .at_stop =
                                   [&] {
                                     std::ofstream(folder_ + "/other")
                                         << std::string(5000000, 'x');
                                     filled.Notify();
                                   }},
                              {}});
  ASSERT_TRUE(source_->List().ok());
  const auto second = Fetch();
  EXPECT_TRUE(absl::IsResourceExhausted(second.status())) << second.status();
  EXPECT_EQ(base::ErrorInfoOf(second.status()).reason, "CACHE_FULL");
  EXPECT_THAT(CachedNames(), ElementsAre(DigestOf(first_model) + ".treeline"));
  EXPECT_EQ(base::ReadFile(*first).value(), first_model);

  // And when there is space again, it is fetched. What is still being written
  // would keep it.
  filled.WaitForNotification();
  unlink((folder_ + "/other").c_str());
  EXPECT_EQ(base::ReadFile(Fetch().value()).value(), model_);
}

TEST_F(HttpSourceFullDisk, WhatCannotFitIsNotEvenBegun) {
  Serve(Model(5000000));
  const auto path = Fetch();
  EXPECT_EQ(base::ErrorInfoOf(path.status()).reason, "CACHE_FULL");
  EXPECT_THAT(server_->Requests("/model.treeline"), IsEmpty());
  EXPECT_THAT(CachedNames(), IsEmpty());
}

}  // namespace
}  // namespace treeline
