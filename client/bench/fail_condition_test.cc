#include "client/bench/fail_condition.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// 100 answers after 1 to 100 ms, 4 calls turned away.
LoadRun SomeRun() {
  LoadRun run;
  run.measured_s = 10;
  run.tally.counts = {100, 4, 0, 0, 0};
  for (int ms = 1; ms <= 100; ++ms) {
    run.tally.latencies[0].from_schedule.Add(ms);
  }
  run.tally.localized = 90;
  run.tally.checks.wrong_poses = 2;
  return run;
}

std::vector<std::string> FailuresOf(const std::string& text,
                                    const LoadRun& run = SomeRun()) {
  const auto conditions = ParseFailConditions(text);
  EXPECT_TRUE(conditions.ok()) << conditions.status();
  return conditions.ok() ? Failures(*conditions, run)
                         : std::vector<std::string>{"did not parse"};
}

TEST(FailConditions, SayWhatIsSo) {
  EXPECT_THAT(FailuresOf("p99>50ms,wrong>0"),
              ElementsAre(AllOf(HasSubstr("p99 is 9"), HasSubstr("p99>50ms")),
                          "wrong is 2 (wrong>0)"));
  EXPECT_THAT(FailuresOf("p99 > 0.2 s, wrong >= 3"), IsEmpty());
  EXPECT_THAT(FailuresOf("p99>9000us"), ElementsAre(HasSubstr("p99 is")));
  EXPECT_THAT(FailuresOf("goodput<10.5/s"), ElementsAre(HasSubstr("10.0/s")));
  EXPECT_THAT(FailuresOf("goodput<10"), IsEmpty());
  EXPECT_THAT(FailuresOf("localized<90%"), IsEmpty());
  EXPECT_THAT(FailuresOf("localized<=90%"),
              ElementsAre("localized is 90.00 % (localized<=90%)"));
  EXPECT_THAT(FailuresOf("errors>3.8%"), ElementsAre(HasSubstr("3.85 %")));
  EXPECT_THAT(FailuresOf("shed>=4,late>0,failed>0"),
              ElementsAre("shed is 4 (shed>=4)"));
}

TEST(FailConditions, WhatIsNotKnownIsNotGood) {
  EXPECT_THAT(FailuresOf("p99>50ms", LoadRun()),
              ElementsAre("p99 has no value (p99>50ms)"));
  EXPECT_THAT(FailuresOf("within<90%"),
              ElementsAre("within has no value (within<90%)"));
  EXPECT_THAT(FailuresOf("wrong>0", LoadRun()), IsEmpty());
}

TEST(FailConditions, ErrorsAreExplained) {
  const auto error = [](const std::string& text) {
    const absl::Status status = ParseFailConditions(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    return std::string(status.message());
  };
  EXPECT_THAT(error("p98>50ms"),
              AllOf(HasSubstr("no figure \"p98\""), HasSubstr("p99.9")));
  EXPECT_THAT(error("p99"), HasSubstr("no comparison"));
  EXPECT_THAT(error("p99>50"), HasSubstr("us, ms or s, not \"\""));
  EXPECT_THAT(error("p99>50min"), HasSubstr("not \"min\""));
  EXPECT_THAT(error("wrong>0%"), HasSubstr("no unit"));
  EXPECT_THAT(error("p99>fast"), HasSubstr("number"));
  EXPECT_THAT(error("p99>5-0ms"), HasSubstr("number"));
  EXPECT_THAT(error("wrong=0"), HasSubstr(">="));
  EXPECT_THAT(error("wrong!=0"), HasSubstr(">="));
  EXPECT_THAT(error("p99>50ms,,wrong>0"), HasSubstr("no comparison"));
  EXPECT_THAT(error(""), HasSubstr("no comparison"));
}

TEST(FigureHelp, NamesEveryFigureWithItsUnit) {
  EXPECT_THAT(FigureHelp(), AllOf(HasSubstr("p99.9 "), HasSubstr("goodput"),
                                  HasSubstr("us, ms or s")));
}

}  // namespace
}  // namespace treeline::bench
