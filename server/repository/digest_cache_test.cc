#include "server/repository/digest_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "gmock/gmock.h"

namespace treeline::repository {
namespace {

namespace fs = std::filesystem;
using ::testing::UnorderedElementsAre;

std::string DigestOf(const std::string& bytes) {
  Sha256 hash;
  hash.Update(bytes);
  return hash.Finish();
}

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now = {};
};

class DigestCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = absl::StrCat(
        testing::TempDir(), "/cache-", getpid(), "-",
        testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    options_.folder = folder_;
    Open();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void Open() {
    cache_.reset();
    auto cache = DigestCache::Open(options_, clock_);
    ASSERT_TRUE(cache.ok()) << cache.status();
    cache_ = *std::move(cache);
  }

  absl::StatusOr<std::unique_ptr<CacheDownload>> Begin(
      const std::string& bytes) {
    return cache_->Begin(DigestOf(bytes), bytes.size(), {});
  }

  absl::StatusOr<std::string> Find(const std::string& bytes) {
    return cache_->Find(DigestOf(bytes), bytes.size(), {});
  }

  // Puts a file that was used `age_s` ago, and that nobody was handed.
  void Put(const std::string& bytes, int age_s) {
    auto download = Begin(bytes);
    ASSERT_TRUE(download.ok()) << download.status();
    ASSERT_TRUE((*download)->Append(bytes).ok());
    const auto path = (*download)->Commit();
    ASSERT_TRUE(path.ok()) << path.status();
    Age(*path, age_s);
    clock_.now += options_.handed_out;
  }

  static void Age(const std::string& path, int age_s) {
    timespec times[2];
    clock_gettime(CLOCK_REALTIME, &times[0]);
    times[0].tv_sec -= age_s;
    times[1] = times[0];
    ASSERT_EQ(utimensat(AT_FDCWD, path.c_str(), times, 0), 0);
  }

  std::string PartOf(const std::string& bytes) const {
    return folder_ + "/sha256/" + DigestOf(bytes) + ".part";
  }

  std::set<std::string> FileNames() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ + "/sha256")) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  static std::string NameOf(const std::string& bytes) {
    return DigestOf(bytes) + ".treeline";
  }

  DigestCacheOptions options_ = {};
  FakeClock clock_ = {};
  std::string folder_ = {};
  std::unique_ptr<DigestCache> cache_ = {};
};

TEST_F(DigestCacheTest, WhatWasPutIsFoundUnderItsDigest) {
  EXPECT_TRUE(absl::IsNotFound(Find("model").status()));
  Put("model", 0);
  const auto path = Find("model");
  ASSERT_TRUE(path.ok()) << path.status();
  EXPECT_EQ(*path, folder_ + "/sha256/" + NameOf("model"));
  EXPECT_EQ(base::ReadFile(*path).value(), "model");
  EXPECT_THAT(FileNames(), UnorderedElementsAre(NameOf("model")));
}

TEST_F(DigestCacheTest, WhatIsNotAsPromisedIsRefusedAndGone) {
  for (const char* bytes : {"modem", "mode"}) {
    auto download = Begin("model");
    ASSERT_TRUE(download.ok()) << download.status();
    ASSERT_TRUE((*download)->Append(bytes).ok());
    const auto path = (*download)->Commit();
    EXPECT_TRUE(absl::IsDataLoss(path.status())) << bytes;
    EXPECT_EQ(base::ErrorInfoOf(path.status()).reason, "MODEL_CORRUPT");
    download->reset();
    EXPECT_TRUE(FileNames().empty());
  }
  auto download = Begin("model");
  EXPECT_TRUE(absl::IsDataLoss((*download)->Append("models")));
}

TEST_F(DigestCacheTest, AnAttemptGoesOnWhereTheLastOneEnded) {
  {
    auto first = Begin("model");
    ASSERT_TRUE((*first)->Append("mod").ok());
  }
  auto second = Begin("model");
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_TRUE((*second)->resumed());
  EXPECT_EQ((*second)->size(), 3u);
  ASSERT_TRUE((*second)->Append("el").ok());
  EXPECT_TRUE((*second)->Commit().ok());
  EXPECT_EQ(base::ReadFile(Find("model").value()).value(), "model");
}

TEST_F(DigestCacheTest, APartThatIsTooLongIsBegunAnew) {
  {
    auto first = Begin("model");
    ASSERT_TRUE((*first)->Append("model").ok());
  }
  ASSERT_EQ(truncate(PartOf("model").c_str(), 9), 0);
  auto second = Begin("model");
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ((*second)->size(), 0u);
}

TEST_F(DigestCacheTest, AFileOfAnotherSizeIsNotTrusted) {
  Put("model", 0);
  ASSERT_EQ(truncate(cache_->PathOf(DigestOf("model")).c_str(), 2), 0);
  EXPECT_TRUE(absl::IsNotFound(Find("model").status()));
  Put("model", 0);
  EXPECT_EQ(base::ReadFile(Find("model").value()).value(), "model");
}

TEST_F(DigestCacheTest, ADamagedFileIsFoundOutWhereAsked) {
  Put("model", 0);
  ASSERT_TRUE(
      base::WriteFileAtomically(cache_->PathOf(DigestOf("model")), "modem")
          .ok());
  EXPECT_TRUE(Find("model").ok());
  options_.verify = true;
  Open();
  EXPECT_TRUE(absl::IsNotFound(Find("model").status()));
  EXPECT_TRUE(FileNames().empty());
  Put("model", 0);
  EXPECT_TRUE(Find("model").ok());
}

TEST_F(DigestCacheTest, WhatWasUsedLongestAgoMakesRoom) {
  options_.limit_bytes = 30;
  Open();
  Put("aaaaaaaaaa", 100);
  Put("bbbbbbbbbb", 200);
  Put("cccccccccc", 300);
  ASSERT_TRUE(Find("cccccccccc").ok());  // used now
  clock_.now += options_.handed_out;
  Put("dddddddddd", 0);
  EXPECT_THAT(FileNames(),
              UnorderedElementsAre(NameOf("aaaaaaaaaa"), NameOf("cccccccccc"),
                                   NameOf("dddddddddd")));
}

TEST_F(DigestCacheTest, WhatIsKeptOrWasJustHandedOutStays) {
  options_.limit_bytes = 20;
  Open();
  Put("aaaaaaaaaa", 200);
  Put("bbbbbbbbbb", 100);
  const auto kept = cache_->Keep(DigestOf("aaaaaaaaaa"));
  ASSERT_TRUE(Find("bbbbbbbbbb").ok());
  const auto full = Begin("cccccccccc");
  EXPECT_TRUE(absl::IsResourceExhausted(full.status()));
  EXPECT_EQ(base::ErrorInfoOf(full.status()).reason, "CACHE_FULL");
  EXPECT_THAT(FileNames(),
              UnorderedElementsAre(NameOf("aaaaaaaaaa"), NameOf("bbbbbbbbbb")));
  clock_.now += options_.handed_out;
  Put("cccccccccc", 0);
  EXPECT_THAT(FileNames(),
              UnorderedElementsAre(NameOf("aaaaaaaaaa"), NameOf("cccccccccc")));
}

TEST_F(DigestCacheTest, WhatIsKeptStaysUntilTheLastLetsGo) {
  options_.limit_bytes = 10;
  Open();
  Put("aaaaaaaaaa", 200);
  auto one = cache_->Keep(DigestOf("aaaaaaaaaa"));
  auto other = cache_->Keep(DigestOf("aaaaaaaaaa"));
  one.reset();
  EXPECT_TRUE(absl::IsResourceExhausted(Begin("bbbbbbbbbb").status()));
  other.reset();
  EXPECT_TRUE(Begin("bbbbbbbbbb").ok());
  EXPECT_TRUE(FileNames().empty());
}

TEST_F(DigestCacheTest, DownloadsInFlightCountFully) {
  options_.limit_bytes = 15;
  Open();
  auto first = Begin("aaaaaaaaaa");
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_TRUE(absl::IsResourceExhausted(Begin("bbbbbbbbbb").status()));
  first->reset();
  EXPECT_TRUE(Begin("bbbbbbbbbb").ok());
}

TEST_F(DigestCacheTest, PartsOfTheDeadGoWhenTheyAreOld) {
  for (const char* bytes : {"old", "new", "held"}) {
    auto download = Begin(bytes);
    ASSERT_TRUE((*download)->Append(std::string(bytes).substr(1)).ok());
  }
  Age(PartOf("old"), 4000);
  Age(PartOf("held"), 4000);
  const int held = open(PartOf("held").c_str(), O_RDWR);
  ASSERT_EQ(flock(held, LOCK_EX), 0);
  Open();
  close(held);
  EXPECT_THAT(FileNames(), UnorderedElementsAre(DigestOf("new") + ".part",
                                                DigestOf("held") + ".part"));
}

TEST_F(DigestCacheTest, WhoMakesNoProgressIsNotWaitedForForever) {
  options_.patience = std::chrono::milliseconds(0);
  Open();
  auto first = Begin("model");
  ASSERT_TRUE((*first)->Append("m").ok());
  // A clock that goes on by itself.
  class Ticking final : public base::Clock {
   public:
    base::MonotonicTime Now() const override {
      return ticks_ += std::chrono::milliseconds(1);
    }

   private:
    mutable base::MonotonicTime ticks_ = {};
  };
  const Ticking ticking;
  auto other = DigestCache::Open(options_, ticking);
  ASSERT_TRUE(other.ok()) << other.status();
  const auto second = (*other)->Begin(DigestOf("model"), 5, {});
  EXPECT_TRUE(absl::IsUnavailable(second.status()));
  EXPECT_EQ(base::ErrorInfoOf(second.status()).reason, "CACHE_BUSY");
}

TEST_F(DigestCacheTest, WaitingForAnotherEndsWithAStop) {
  auto first = Begin("model");
  ASSERT_TRUE(first.ok());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(
      cache_->Begin(DigestOf("model"), 5, stop.get_token()).status()));
}

// Writing fails as on a full disk: with a limit on the size of files.
TEST_F(DigestCacheTest, AFullDiskLeavesNothingHalfWritten) {
  Put("small", 0);
  const std::string large(100000, 'x');
  auto download = Begin(large);
  ASSERT_TRUE(download.ok()) << download.status();
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{.rlim_cur = 50000, .rlim_max = limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const absl::Status status = (*download)->Append(large);
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, SIG_DFL);
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(base::ErrorInfoOf(status).reason, "CACHE_FULL");
  download->reset();
  EXPECT_THAT(FileNames(), UnorderedElementsAre(NameOf("small")));
  EXPECT_TRUE(Find("small").ok());
}

TEST_F(DigestCacheTest, AFolderThatCannotBeMadeIsNamed) {
  ASSERT_TRUE(base::WriteFileAtomically(folder_ + "/file", "x").ok());
  options_.folder = folder_ + "/file/cache";
  const auto cache = DigestCache::Open(options_, clock_);
  EXPECT_EQ(base::ErrorInfoOf(cache.status()).reason, "CACHE_FAILED");
  EXPECT_THAT(std::string(cache.status().message()),
              testing::HasSubstr(options_.folder));
}

}  // namespace
}  // namespace treeline::repository
