#include "client/bench/worker_processes.h"

#include <sstream>
#include <string>
#include <thread>

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using ::testing::HasSubstr;

// A record of a run with so many answers of 5 ms.
RunRecord Answered(int answers) {
  RunRecord record;
  record.run.measured_s = 1;
  record.run.tally.counts[0] = answers;
  for (int i = 0; i < answers; ++i) {
    record.run.tally.latencies[0].from_schedule.Add(5);
  }
  record.all_calls = {{{absl::StatusCode::kOk, ""}, answers}};
  return record;
}

TEST(PartOf, AddsUpToTheWhole) {
  const LoadStep whole = {.rate_per_s = 90, .concurrency = 8, .seed = 7};
  double rate_per_s = 0;
  int concurrency = 0;
  for (int i = 0; i < 3; ++i) {
    const LoadStep part = PartOf(whole, i, 3);
    rate_per_s += part.rate_per_s;
    concurrency += part.concurrency;
    EXPECT_EQ(part.seed, 7 + static_cast<uint64_t>(i));
  }
  EXPECT_DOUBLE_EQ(rate_per_s, 90);
  EXPECT_EQ(concurrency, 8);
}

TEST(ServeSteps, AnswersEveryStepWithItsRecord) {
  std::istringstream in(
      "{\"rate_per_s\":20,\"concurrency\":1,\"seed\":3}\n"
      "{\"rate_per_s\":0,\"concurrency\":4,\"seed\":3}\n");
  std::ostringstream out;
  EXPECT_TRUE(ServeSteps(
      in, out, [] { return absl::OkStatus(); },
      [](const LoadStep& step) -> absl::StatusOr<RunRecord> {
        EXPECT_EQ(step.seed, 3);
        return Answered(static_cast<int>(step.rate_per_s) + step.concurrency);
      }));
  std::istringstream lines(out.str());
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "ready");
  for (const int answers : {21, 4}) {
    std::getline(lines, line);
    const auto record = ParseRunRecord(line);
    ASSERT_TRUE(record.ok()) << record.status();
    EXPECT_EQ(record->run.tally.counts[0], answers);
  }
}

TEST(ServeSteps, SaysWhatFailed) {
  std::istringstream none("");
  std::ostringstream unprepared;
  EXPECT_FALSE(ServeSteps(
      none, unprepared, [] { return absl::UnavailableError("no\nserver"); },
      [](const LoadStep&) { return absl::StatusOr<RunRecord>(Answered(1)); }));
  EXPECT_EQ(unprepared.str(), "error 14 no server\n");
  std::istringstream garbage("run!\n");
  std::ostringstream out;
  EXPECT_FALSE(ServeSteps(
      garbage, out, [] { return absl::OkStatus(); },
      [](const LoadStep&) { return absl::StatusOr<RunRecord>(Answered(1)); }));
  EXPECT_THAT(out.str(), HasSubstr("error 3 no step"));
}

// A program that does what `script` says; $1 is its number.
class WorkerProcessesTest : public testing::Test {
 protected:
  std::vector<std::string> Program(const std::string& script) const {
    return {"/bin/sh", folder_.Write("worker.sh", script)};
  }

  const base::TestingFolder folder_;
};

TEST_F(WorkerProcessesTest, MergesWhatAllOfThemFound) {
  for (const int i : {0, 1, 2}) {
    folder_.Write(std::to_string(i), WriteRunRecord(Answered(10 + i)) + "\n");
  }
  const auto workers =
      WorkerProcesses::Start(Program("echo ready\nwhile read -r step; do cat " +
                                     folder_.path() + "/\"$1\"; done\n"),
                             3, {});
  ASSERT_TRUE(workers.ok()) << workers.status();
  for (int round = 0; round < 2; ++round) {
    const auto run = (*workers)->Run({.concurrency = 3}, {});
    ASSERT_TRUE(run.ok()) << run.status();
    EXPECT_EQ(run->tally.counts[0], 33);
    EXPECT_EQ(run->tally.latencies[0].from_schedule.count(), 33);
    EXPECT_EQ((*workers)->all_calls().begin()->second, 33);
  }
}

TEST_F(WorkerProcessesTest, AnErrorOfOneIsTheErrorOfAll) {
  const auto refused = WorkerProcesses::Start(
      Program("echo error 14 connection refused\n"), 2, {});
  EXPECT_EQ(refused.status(), absl::UnavailableError("connection refused"));
  const auto gone = WorkerProcesses::Start(Program("exit 3\n"), 1, {});
  EXPECT_THAT(std::string(gone.status().message()), HasSubstr("ended early"));
  EXPECT_FALSE(WorkerProcesses::Start({"/no/such/program"}, 1, {}).ok());
  const auto silent = WorkerProcesses::Start(
      Program("echo ready\nread -r step\necho nonsense\n"), 1, {});
  ASSERT_TRUE(silent.ok()) << silent.status();
  EXPECT_EQ((*silent)->Run({}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(WorkerProcessesTest, AnInterruptionReachesThem) {
  folder_.Write("record", WriteRunRecord(Answered(4)) + "\n");
  // Answers only when it is interrupted.
  const auto workers = WorkerProcesses::Start(
      Program("trap 'cat " + folder_.path() +
              "/record; exit 0' INT\necho ready\nread -r step\n"
              "while :; do sleep 0.05; done\n"),
      2, {});
  ASSERT_TRUE(workers.ok()) << workers.status();
  std::stop_source stop;
  stop.request_stop();
  const auto run = (*workers)->Run({}, stop.get_token());
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(run->tally.counts[0], 8);
}

}  // namespace
}  // namespace treeline::bench
