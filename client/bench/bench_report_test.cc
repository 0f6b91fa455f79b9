#include "client/bench/bench_report.h"

#include <cmath>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::bench {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

BenchReport SomeReport() {
  Tally tally;
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  for (int i = 1; i <= 100; ++i) {
    response.mutable_timings()->set_forest_ms(2);
    tally.Add(
        {.latency_ms = i * 1.0,
         .from_send_ms = i * 1.0,
         .response = &response,
         .verdict = {.bits = i == 100 ? AnswerChecker::Bits::kDifferent
                                      : AnswerChecker::Bits::kAsBeforeLoad}});
  }
  tally.Add({.status = base::WithRetryAfter(
                 base::WithReason(absl::UnavailableError("full"), "QUEUE_FULL"),
                 std::chrono::milliseconds(50)),
             .from_send_ms = 3});
  LoadRun run;
  run.options.rate_per_s = 60;
  run.measured_s = 2;
  run.tally = tally.State();
  BenchReport report;
  report.server = "127.0.0.1:1";
  report.machine.cpu_model = "a processor";
  report.reference_answers = 4;
  report.runs.push_back(run);
  report.all_calls = tally.AllCalls();
  return report;
}

TEST(BenchReport, ProgramsFindTheFigures) {
  const Json json = Json::parse(BenchJson(SomeReport()));
  EXPECT_EQ(json["machine"]["cpu"], "a processor");
  EXPECT_EQ(json["reference_answers"], 4);
  EXPECT_EQ(json["capacity_per_s"], nullptr);
  const Json& run = json["runs"][0];
  EXPECT_EQ(run["loop"], "open");
  EXPECT_EQ(run["rate_per_s"], 60);
  EXPECT_EQ(run["counts"]["ok"], 100);
  EXPECT_EQ(run["counts"]["shed"], 1);
  EXPECT_EQ(run["answers_per_s"], 50);
  // One of the 100 answers was wrong.
  EXPECT_EQ(run["goodput_per_s"], 49.5);
  EXPECT_NEAR(run["latency_ms"]["p50"], 50, 1);
  EXPECT_EQ(run["shed_from_send_ms"]["max"], 3);
  EXPECT_EQ(run["server"]["forest_ms"]["p50"], 2);
  EXPECT_EQ(run["checks"]["different"], 1);
  EXPECT_EQ(run["outcomes"][1]["code"], "UNAVAILABLE");
  EXPECT_EQ(run["outcomes"][1]["reason"], "QUEUE_FULL");
  EXPECT_EQ(json["all_calls"][0]["count"], 100);
}

TEST(BenchReport, PeopleFindThemToo) {
  const std::string text = BenchText(SomeReport());
  EXPECT_THAT(text, AllOf(HasSubstr("goodput 49.5/s"), HasSubstr("QUEUE_FULL"),
                          HasSubstr("1 different"), Not(HasSubstr("SATUR"))));
}

TEST(BenchReport, AGeneratorThatIsTheBottleneckSaysSo) {
  BenchReport report = SomeReport();
  report.runs[0].send_lag.Add(kSaturatedLag_ms + 1);
  EXPECT_THAT(BenchText(report), HasSubstr("SATURATED"));
  EXPECT_EQ(Json::parse(BenchJson(report))["runs"][0]["generator"]["saturated"],
            true);
}

TEST(BenchReport, TheLiveLineTellsTheWarmUpApart) {
  EXPECT_THAT(LiveLine({}, -0.5), HasSubstr("warming up"));
  Glance glance;
  glance.counts[0] = 30;
  EXPECT_THAT(LiveLine(glance, 2), HasSubstr("15.0/s"));
}

TEST(BenchReport, SaysWhatFails) {
  BenchReport report = SomeReport();
  report.conditions = ParseFailConditions("p99>50ms,failed>0").value();
  EXPECT_THAT(BenchText(report), AllOf(HasSubstr("FAILS: p99 is"),
                                       Not(HasSubstr("FAILS: failed"))));
  const Json json = Json::parse(BenchJson(report));
  EXPECT_EQ(json["fail_if"], (Json{"p99>50ms", "failed>0"}));
  ASSERT_EQ(json["runs"][0]["failures"].size(), 1);
  EXPECT_EQ(Json::parse(BenchJson(SomeReport()))["runs"][0]["failures"],
            Json::array());
}

TEST(BenchReport, HasTheServersOwnFigures) {
  BenchReport report = SomeReport();
  EXPECT_EQ(Json::parse(BenchJson(report))["server_metrics"], nullptr);
  report.metrics_url = "http://host/metrics";
  CoursePoint point{.at_unix_s = 1'700'000'000.5, .figures = {}};
  point.figures.answers_per_s = 80;
  point.figures.p99_ms = std::nan("");
  point.figures.stage_ms = {{"pose", 2.5}};
  point.figures.workers = 2;
  report.course = Course{.points = {point}, .missed = 1, .last_error = "gone"};
  const Json metrics = Json::parse(BenchJson(report))["server_metrics"];
  EXPECT_EQ(metrics["workers"], 2);
  EXPECT_EQ(metrics["missed"], 1);
  const Json& at = metrics["points"][0];
  EXPECT_EQ(at["at_unix_s"], 1'700'000'000.5);
  EXPECT_EQ(at["answers_per_s"], 80);
  EXPECT_EQ(at["p99_ms"], nullptr);
  EXPECT_EQ(at["stage_ms"]["pose"], 2.5);
  EXPECT_THAT(BenchText(report), HasSubstr("missed 1 times: gone"));
}

// The names of all that is in a value, as far down as arrays and objects go;
// of an array, what is in its first element.
void Names(const Json& json, const std::string& path,
           std::set<std::string>& names) {
  if (json.is_array() && !json.empty()) Names(json[0], path + "[]", names);
  if (!json.is_object()) return;
  for (const auto& [name, value] : json.items()) {
    // Scenes and stages have names of their own.
    if (name == "answered_by" || name == "stage_ms") continue;
    const std::string below = absl::StrCat(path, ".", name);
    names.insert(below);
    Names(value, below, names);
  }
}

TEST(BenchReport, TheTemplateIsTestedWithTheKeysThatThereAre) {
  BenchReport report = SomeReport();
  report.workload.emplace_back();
  report.course.emplace();
  report.course->points.emplace_back();
  report.runs[0].send_lag.Add(1);
  Json ours = Json::parse(BenchJson(report));
  const auto text = base::ReadFile(TREELINE_BENCH_FIXTURE, 1 << 20);
  ASSERT_TRUE(text.ok()) << text.status();
  Json theirs = Json::parse(*text);
  // An error's latencies are told, and not drawn; nothing was shed there.
  for (Json* json : {&ours, &theirs}) {
    Json& run = (*json)["runs"][0];
    run.erase("shed_from_send_ms");
    run.erase("from_send_ms");
    for (Json& outcome : run["outcomes"]) {
      outcome.erase("latency_ms");
      outcome.erase("from_send_ms");
    }
  }
  std::set<std::string> our_names;
  std::set<std::string> their_names;
  Names(ours, "", our_names);
  Names(theirs, "", their_names);
  EXPECT_EQ(our_names, their_names);
}

}  // namespace
}  // namespace treeline::bench
