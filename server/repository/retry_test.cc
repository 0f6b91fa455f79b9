#include "server/repository/retry.h"

#include <vector>

#include "common/base/error_info.h"
#include "gmock/gmock.h"

namespace treeline::repository {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;

constexpr RetryOptions kOptions{.max_attempts = 4,
                                .first_pause = milliseconds(100),
                                .longest_pause = milliseconds(300),
                                .longest_asked_pause = milliseconds(5000)};

class RetryTest : public testing::Test {
 protected:
  absl::Status Run(const std::function<absl::Status()>& attempt) {
    return Retry(
        kOptions, 1,
        [this](milliseconds time, const std::stop_token&) {
          pauses_.push_back(time);
        },
        stop_.get_token(),
        [&] {
          ++attempts_;
          return attempt();
        },
        [this] { return bytes_; });
  }

  std::stop_source stop_;
  std::vector<milliseconds> pauses_;
  uint64_t bytes_ = 0;
  int attempts_ = 0;
};

TEST_F(RetryTest, SuccessAndLastingErrorsEndIt) {
  EXPECT_TRUE(Run([] { return absl::OkStatus(); }).ok());
  EXPECT_TRUE(absl::IsNotFound(Run([] { return absl::NotFoundError(""); })));
  EXPECT_EQ(attempts_, 2);
  EXPECT_TRUE(pauses_.empty());
}

TEST_F(RetryTest, PausesGrowUpToTheLongestAndAreSpread) {
  EXPECT_TRUE(
      absl::IsUnavailable(Run([] { return absl::UnavailableError("x"); })));
  EXPECT_EQ(attempts_, 4);
  ASSERT_EQ(pauses_.size(), 3u);
  for (const auto& [pause, longest] :
       {std::pair(pauses_[0], 100), {pauses_[1], 200}, {pauses_[2], 300}}) {
    EXPECT_GE(pause.count(), longest / 2);
    EXPECT_LE(pause.count(), longest);
  }
}

TEST_F(RetryTest, TheServersWishIsHonouredUnlessItIsTooMuch) {
  EXPECT_TRUE(Run([&] {
                return attempts_ < 2
                           ? base::WithRetryAfter(absl::UnavailableError("x"),
                                                  milliseconds(5000))
                           : absl::OkStatus();
              }).ok());
  EXPECT_THAT(pauses_, ElementsAre(milliseconds(5000)));
  EXPECT_FALSE(Run([&] {
                 return base::WithRetryAfter(absl::UnavailableError("x"),
                                             milliseconds(5001));
               }).ok());
  EXPECT_EQ(pauses_.size(), 1u);
}

TEST_F(RetryTest, ProgressCountsAttemptsFromOneAgain) {
  EXPECT_FALSE(Run([&] {
                 if (bytes_ < 10u << 20) bytes_ += 1u << 20;
                 return absl::UnavailableError("x");
               }).ok());
  EXPECT_EQ(attempts_, 10 + 3);
}

TEST_F(RetryTest, AStopEndsIt) {
  EXPECT_TRUE(absl::IsCancelled(Run([&] {
    stop_.request_stop();
    return absl::UnavailableError("x");
  })));
  EXPECT_EQ(attempts_, 1);
}

}  // namespace
}  // namespace treeline::repository
