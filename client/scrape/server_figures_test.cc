#include "client/scrape/server_figures.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::scrape {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

// A server that has answered `answers` queries, half of them localized.
std::string Metrics(int answers, int shed, int not_found) {
  const auto text = [](auto value) { return std::to_string(value); };
  return "treeline_workers 2\ntreeline_in_flight 1\ntreeline_queue_depth 3\n"
         "treeline_queue_capacity 64\nprocess_cpu_seconds_total " +
         text(answers / 100.0) +
         "\nprocess_resident_memory_bytes 1e8\n"
         "process_start_time_seconds 1000\n"
         "treeline_build_info{version=\"1.2\"} 1\n"
         "treeline_scenes{state=\"READY\"} 2\n"
         "treeline_outcomes_total{scene=\"a\",outcome=\"LOCALIZED\",reason="
         "\"NONE\"} " +
         text(answers / 2) +
         "\ntreeline_outcomes_total{scene=\"b\",outcome=\"NOT_LOCALIZED\","
         "reason=\"TOO_FEW_INLIERS\"} " +
         text(answers / 2) + "\ntreeline_shed_total{reason=\"QUEUE_FULL\"} " +
         text(shed) +
         "\ntreeline_requests_total{rpc=\"Localize\",status=\"OK\"} " +
         text(answers) +
         "\ntreeline_requests_total{rpc=\"Localize\",status=\"UNAVAILABLE\"} " +
         text(shed) +
         "\ntreeline_requests_total{rpc=\"Localize\",status=\"NOT_FOUND\"} " +
         text(not_found) +
         "\ntreeline_requests_total{rpc=\"ListScenes\",status=\"OK\"} " +
         text(answers * 9) +
         "\ntreeline_request_seconds_bucket{rpc=\"Localize\",le=\"0.01\"} " +
         text(answers / 2) +
         "\ntreeline_request_seconds_bucket{rpc=\"Localize\",le=\"0.02\"} " +
         text(answers) +
         "\ntreeline_request_seconds_bucket{rpc=\"Localize\",le=\"+Inf\"} " +
         text(answers) + "\ntreeline_stage_seconds_sum{stage=\"forest\"} " +
         text(answers * 0.004) +
         "\ntreeline_stage_seconds_count{stage=\"forest\"} " + text(answers) +
         "\n";
}

ServerFigures Between(const std::string& before, const std::string& after) {
  return FiguresBetween(MetricsSnapshot::Parse(before).value(),
                        MetricsSnapshot::Parse(after).value(), 2, 1060);
}

TEST(FiguresBetween, CountsWhatWasAdded) {
  const ServerFigures figures =
      Between(Metrics(100, 10, 5), Metrics(300, 30, 9));
  EXPECT_EQ(figures.answers_per_s, 100);
  EXPECT_EQ(figures.shed_per_s, 10);
  EXPECT_EQ(figures.failed_per_s, 2);
  EXPECT_EQ(figures.localized_share, 0.5);
  EXPECT_DOUBLE_EQ(figures.p50_ms, 10);
  EXPECT_NEAR(figures.p99_ms, 19.8, 1e-9);
  EXPECT_NEAR(figures.stage_ms.at("forest"), 4, 1e-9);
  EXPECT_NEAR(figures.processors, 1, 1e-9);
  EXPECT_EQ(figures.queue_depth, 3);
  EXPECT_EQ(figures.queue_capacity, 64);
  EXPECT_EQ(figures.in_flight, 1);
  EXPECT_EQ(figures.workers, 2);
  EXPECT_EQ(figures.resident_bytes, 1e8);
  EXPECT_EQ(figures.version, "1.2");
  EXPECT_EQ(figures.up_s, 60);
  EXPECT_THAT(figures.scenes, ElementsAre(Pair("READY", 2)));
  EXPECT_THAT(figures.answers_per_s_by_scene,
              ElementsAre(Pair("a", 50), Pair("b", 50)));
}

TEST(FiguresBetween, SaysNothingOfAQuietServer) {
  const ServerFigures figures =
      Between(Metrics(100, 10, 5), Metrics(100, 10, 5));
  EXPECT_EQ(figures.answers_per_s, 0);
  EXPECT_EQ(figures.failed_per_s, 0);
  EXPECT_TRUE(std::isnan(figures.localized_share));
  EXPECT_TRUE(std::isnan(figures.p99_ms));
  EXPECT_TRUE(std::isnan(figures.stage_ms.at("forest")));
}

TEST(FiguresBetween, AServerThatBeganAnewCountsFromZero) {
  const ServerFigures figures =
      Between(Metrics(1000, 10, 5), Metrics(40, 0, 0));
  EXPECT_EQ(figures.answers_per_s, 20);
  EXPECT_EQ(figures.shed_per_s, 0);
  EXPECT_GE(figures.processors, 0);
}

TEST(IsServer, KnowsOtherProgramsMetrics) {
  EXPECT_TRUE(IsServer(MetricsSnapshot::Parse(Metrics(1, 1, 1)).value()));
  EXPECT_FALSE(IsServer(
      MetricsSnapshot::Parse("process_cpu_seconds_total 1\n").value()));
}

}  // namespace
}  // namespace treeline::scrape
