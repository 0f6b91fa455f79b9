#include "client/bench/run_record.h"

#include <string>

#include "client/bench/bench_report.h"
#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

// Calls of every kind.
RunRecord SomeRecord(double first_ms) {
  Tally tally;
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  response.set_scene("kitchen");
  response.set_model_version("2");
  response.mutable_timings()->set_forest_ms(2.25);
  for (int i = 0; i < 50; ++i) {
    tally.Add({.latency_ms = first_ms + i,
               .from_send_ms = first_ms + i / 2.0,
               .scheduled_s = i * 0.1,
               .response = &response,
               .verdict = {.bits = AnswerChecker::Bits::kAsBeforeLoad,
                           .within_tolerance = i > 0,
                           .wrong_pose = i == 0}});
  }
  tally.Add(
      {.status = base::WithReason(absl::UnavailableError("full"), "QUEUE_FULL"),
       .pushback = true,
       .from_send_ms = 3});
  tally.Add({.status = absl::InternalError("\xff broken")});
  RunRecord record;
  record.run.options = {.concurrency = 3, .rate_per_s = 20, .deadline_ms = 250};
  record.run.measured_from = std::chrono::system_clock::time_point(
      std::chrono::microseconds(1'700'000'000'000'001));
  record.run.measured_s = 5;
  record.run.wall_s = 6;
  record.run.tally = tally.State();
  record.run.not_sent = 2;
  record.run.send_lag.Add(0.5);
  record.run.generator_cpus = 0.25;
  record.all_calls = tally.AllCalls();
  return record;
}

// All that is said of a run.
std::string Said(const LoadRun& run) {
  BenchReport report;
  report.runs.push_back(run);
  return BenchJson(report);
}

TEST(RunRecord, ComesBackAsItWas) {
  const RunRecord record = SomeRecord(10);
  const std::string line = WriteRunRecord(record);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto again = ParseRunRecord(line);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(Said(again->run), Said(record.run));
  EXPECT_EQ(again->all_calls, record.all_calls);
}

TEST(RunRecord, WhatIsNoneIsRefused) {
  const std::string line = WriteRunRecord(SomeRecord(10));
  EXPECT_FALSE(ParseRunRecord("").ok());
  EXPECT_FALSE(ParseRunRecord("{}").ok());
  EXPECT_FALSE(ParseRunRecord("[1,2").ok());
  for (size_t size = 1; size < line.size(); size += 97) {
    EXPECT_FALSE(ParseRunRecord(line.substr(0, size)).ok()) << size;
  }
  std::string negative = line;
  negative.replace(negative.find("\"buckets\":[[") + 12, 1, "-");
  EXPECT_FALSE(ParseRunRecord(negative).ok());
}

TEST(MergeRuns, HasThePercentilesOfAllCalls) {
  LoadRun one = SomeRecord(10).run;
  LoadRun other = SomeRecord(1000).run;
  other.measured_s = 4;
  other.interrupted = true;
  const LoadRun both = MergeRuns({one, other});
  EXPECT_EQ(both.tally.total(), one.tally.total() + other.tally.total());
  EXPECT_EQ(both.tally.localized, 100);
  EXPECT_EQ(both.options.rate_per_s, 40);
  EXPECT_EQ(both.options.concurrency, 6);
  EXPECT_EQ(both.measured_s, 5);
  EXPECT_TRUE(both.interrupted);
  EXPECT_EQ(both.not_sent, 4);
  EXPECT_EQ(both.generator_cpus, 0.5);
  EXPECT_EQ(both.send_lag.count(), 2);
  const LatencyHistogram& latency = both.tally.latencies[0].from_schedule;
  EXPECT_EQ(latency.count(), 100);
  // Half are of the fast one, half of the slow one.
  EXPECT_LT(latency.Percentile_ms(50), 60);
  EXPECT_GT(latency.Percentile_ms(51), 990);
  EXPECT_EQ(both.tally.checks.wrong_poses, 2);
  EXPECT_EQ(both.tally.answered_by.at("kitchen/2"), 100);
  ASSERT_EQ(both.tally.intervals.size(), 5);
  EXPECT_EQ(both.tally.intervals[0].counts[0], 20);
  EXPECT_EQ(both.tally.server.forest.count(), 100);
}

}  // namespace
}  // namespace treeline::bench
