#include "server/app/call_log.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class ManualClock final : public Clock {
 public:
  MonotonicTime Now() const override { return now; }
  MonotonicTime now{};
};

class CallLogTest : public testing::Test {
 protected:
  CallLogTest() {
    const auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(out_);
    logger_ = std::make_shared<spdlog::logger>("test", sink);
    logger_->set_pattern("%l %v");
    log_ = std::make_unique<CallLog>(logger_, clock_);
  }
  int Lines() const {
    const std::string text = out_.str();
    return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  }

  std::ostringstream out_;
  std::shared_ptr<spdlog::logger> logger_;
  ManualClock clock_;
  std::unique_ptr<CallLog> log_;
};

CallRecord Failed() {
  CallRecord record;
  record.rpc = "Localize";
  record.scene = "kitchen";
  record.status = absl::InvalidArgumentError("the frame's color is missing");
  return record;
}

TEST_F(CallLogTest, AnsweredCallsAreForDebugging) {
  CallRecord record;
  record.rpc = "Localize";
  record.scene = "kitchen";
  record.model_version = "3";
  record.outcome = Outcome::kNotLocalized;
  record.reason = NotLocalizedReason::kTooFewInliers;
  record.inliers = 7;
  record.samples = 500;
  record.timings.queue_ms = 1.5;
  log_->OnCall(record);
  EXPECT_EQ(Lines(), 0);
  logger_->set_level(spdlog::level::debug);
  log_->OnCall(record);
  EXPECT_THAT(out_.str(),
              HasSubstr("debug rpc=Localize status=OK peer=\"\" "
                        "scene=\"kitchen\" version=\"3\" "
                        "outcome=NOT_LOCALIZED reason=TOO_FEW_INLIERS "
                        "inliers=7 samples=500 "));
  EXPECT_THAT(out_.str(), HasSubstr("queue_ms=1.50"));
}

TEST_F(CallLogTest, FailedCallsSayWhy) {
  log_->OnCall(Failed());
  EXPECT_THAT(out_.str(), HasSubstr("info rpc=Localize "
                                    "status=INVALID_ARGUMENT"));
  EXPECT_THAT(out_.str(),
              HasSubstr("message=\"the frame's color is missing\""));
}

TEST_F(CallLogTest, FaultsOfTheServerAreErrorsWithTheirCause) {
  CallRecord record = Failed();
  record.status = absl::InternalError("a fault");
  record.internal_error = "vector::_M_range_check";
  log_->OnCall(record);
  EXPECT_THAT(out_.str(), HasSubstr("error rpc=Localize status=INTERNAL"));
  EXPECT_THAT(out_.str(), HasSubstr("fault=\"vector::_M_range_check\""));
}

TEST_F(CallLogTest, ClientsCannotForgeLines) {
  CallRecord record = Failed();
  record.scene = "x\" status=OK\n2026-11-21 error the house burns\x1b[31m";
  log_->OnCall(record);
  EXPECT_EQ(Lines(), 1);
  EXPECT_THAT(out_.str(), HasSubstr("scene=\"x\\\" status=OK\\n2026"));
  EXPECT_THAT(out_.str(), Not(HasSubstr("\x1b")));
}

TEST_F(CallLogTest, AFloodOfFailuresIsCountedNotWritten) {
  for (int i = 0; i < 1000; ++i) log_->OnCall(Failed());
  EXPECT_EQ(Lines(), CallLog::kMaxLines);
  clock_.now += std::chrono::milliseconds(999);
  log_->OnCall(Failed());
  EXPECT_EQ(Lines(), CallLog::kMaxLines);
  clock_.now += std::chrono::milliseconds(1);
  log_->OnCall(Failed());
  EXPECT_EQ(Lines(), CallLog::kMaxLines + 1);
  EXPECT_THAT(out_.str(), HasSubstr("lines_left_out=981"));
}

}  // namespace
}  // namespace treeline
