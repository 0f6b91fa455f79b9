#include "server/app/call_log.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>

#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::server_app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class ManualClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now{};
};

class CallLogTest : public testing::Test {
 protected:
  CallLogTest() {
    const auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(out_);
    logger_ = std::make_shared<spdlog::logger>("test", sink);
    server_log_ = std::make_unique<logging::ProgramLog>(
        logger_, logging::LogFormat::kText);
    logger_->set_pattern("%l %v");
    log_ = std::make_unique<CallLog>(*server_log_, clock_);
  }
  int Lines() const {
    const std::string text = out_.str();
    return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  }

  std::ostringstream out_;
  std::shared_ptr<spdlog::logger> logger_;
  std::unique_ptr<logging::ProgramLog> server_log_;
  ManualClock clock_;
  std::unique_ptr<CallLog> log_;
};

service::CallRecord Failed() {
  service::CallRecord record;
  record.rpc = "Localize";
  record.scene = "kitchen";
  record.status = absl::InvalidArgumentError("the frame's color is missing");
  return record;
}

TEST_F(CallLogTest, AnsweredCallsAreForDebugging) {
  service::CallRecord record;
  record.rpc = "Localize";
  record.scene = "kitchen";
  record.model_version = "3";
  record.outcome = localizer::Outcome::kNotLocalized;
  record.reason = localizer::NotLocalizedReason::kTooFewInliers;
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
  service::CallRecord record = Failed();
  record.status = absl::InternalError("a fault");
  record.internal_error = "vector::_M_range_check";
  log_->OnCall(record);
  EXPECT_THAT(out_.str(), HasSubstr("error rpc=Localize status=INTERNAL"));
  EXPECT_THAT(out_.str(), HasSubstr("fault=\"vector::_M_range_check\""));
}

TEST_F(CallLogTest, ClientsCannotForgeLines) {
  service::CallRecord record = Failed();
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

service::CallRecord Traced() {
  service::CallRecord record = Failed();
  record.transport = "http";
  record.client = "robot-7";
  record.request_bytes = 300000;
  record.status =
      base::WithReason(absl::UnavailableError("overloaded"), "QUEUE_FULL");
  record.trace = tracing::ParseTraceparent(
      "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  return record;
}

TEST_F(CallLogTest, NamesTheClientTheTraceAndTheReason) {
  log_->OnCall(Traced());
  EXPECT_THAT(out_.str(),
              HasSubstr("rpc=Localize status=UNAVAILABLE transport=http "
                        "peer=\"\" client=\"robot-7\" "
                        "trace_id=0af7651916cd43dd8448eb211c80319c "
                        "span_id=b7ad6b7169203331 bytes=300000 "));
  EXPECT_THAT(out_.str(), HasSubstr("error_reason=\"QUEUE_FULL\""));
}

TEST_F(CallLogTest, NamesItsOwnSpanWhereItHasOne) {
  service::CallRecord record = Traced();
  record.span =
      tracing::TraceContext{record.trace->trace_id, "1111111111111111", true};
  log_->OnCall(record);
  EXPECT_THAT(out_.str(), HasSubstr("trace_id=0af7651916cd43dd8448eb211c80319c "
                                    "span_id=1111111111111111 "));
}

TEST_F(CallLogTest, JsonIsOneObjectALineWithTheSameFields) {
  logging::ProgramLog json_log(logger_, logging::LogFormat::kJson);
  CallLog log(json_log, clock_);
  service::CallRecord record = Traced();
  record.scene = "x\",\"status\":\"OK\n\xff\xe2\x80\xa8\x1b[31m";
  log.OnCall(record);
  EXPECT_EQ(Lines(), 1);
  const auto line = nlohmann::json::parse(out_.str());
  EXPECT_EQ(line["level"], "info");
  EXPECT_EQ(line["rpc"], "Localize");
  EXPECT_EQ(line["status"], "UNAVAILABLE");
  EXPECT_EQ(line["transport"], "http");
  EXPECT_EQ(line["client"], "robot-7");
  EXPECT_EQ(line["trace_id"], "0af7651916cd43dd8448eb211c80319c");
  EXPECT_EQ(line["span_id"], "b7ad6b7169203331");
  EXPECT_EQ(line["bytes"], 300000);
  EXPECT_EQ(line["error_reason"], "QUEUE_FULL");
  EXPECT_EQ(line["scene"], "x\",\"status\":\"OK\n\ufffd\u2028\x1b[31m");
  EXPECT_EQ(line["total_ms"], 0.0);
  EXPECT_TRUE(std::regex_match(
      line["ts"].get<std::string>(),
      std::regex("\\d{4}-\\d\\d-\\d\\dT\\d\\d:\\d\\d:\\d\\d\\.\\d{3}Z")));
}

TEST_F(CallLogTest, JsonTellsOfAnAnswerAllThatTextDoes) {
  logger_->set_level(spdlog::level::debug);
  logging::ProgramLog json_log(logger_, logging::LogFormat::kJson);
  CallLog log(json_log, clock_);
  service::CallRecord record;
  record.rpc = "Localize";
  record.outcome = localizer::Outcome::kLocalized;
  record.inliers = 237;
  record.samples = 500;
  record.timings.decode_ms = 7.554;
  log.OnCall(record);
  const auto line = nlohmann::json::parse(out_.str());
  EXPECT_EQ(line["outcome"], "LOCALIZED");
  EXPECT_EQ(line["inliers"], 237);
  EXPECT_EQ(line["decode_ms"], 7.55);
}

}  // namespace
}  // namespace treeline::server_app
