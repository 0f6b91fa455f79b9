#include "common/metrics/exposition.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/metrics/testing_exposition.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::metrics {
namespace {

TEST(Exposition, IsTheTextFormat) {
  Exposition out;
  out.Family("queue", "Waiting \\ now\n.", MetricType::kGauge);
  out.Sample({}, 3);
  out.Family("calls_total", "Calls.", MetricType::kCounter);
  out.Sample({{"rpc", "Localize"}, {"why", "a \"b\"\n\\c"}}, 1e9);
  out.Family("seconds", "Time.", MetricType::kHistogram);
  out.Histogram({{"rpc", "L"}}, {{0.5, 1}, {1, 0, 2}, 7.25});
  EXPECT_EQ(out.text(),
            "# HELP queue Waiting \\\\ now\\n.\n"
            "# TYPE queue gauge\n"
            "queue 3\n"
            "# HELP calls_total Calls.\n"
            "# TYPE calls_total counter\n"
            "calls_total{rpc=\"Localize\",why=\"a \\\"b\\\"\\n\\\\c\"} 1e+09\n"
            "# HELP seconds Time.\n"
            "# TYPE seconds histogram\n"
            "seconds_bucket{rpc=\"L\",le=\"0.5\"} 1\n"
            "seconds_bucket{rpc=\"L\",le=\"1\"} 1\n"
            "seconds_bucket{rpc=\"L\",le=\"+Inf\"} 3\n"
            "seconds_sum{rpc=\"L\"} 7.25\n"
            "seconds_count{rpc=\"L\"} 3\n");
  EXPECT_TRUE(ParseExposition(out.text()).ok());
}

TEST(Exposition, OpenMetricsHasExemplarsAndAnEnd) {
  Exposition out(ExpositionFormat::kOpenMetrics);
  out.Family("calls_total", "Calls \"now\".", MetricType::kCounter);
  out.Sample({{"rpc", "L"}}, 3);
  out.Family("seconds", "Time.", MetricType::kHistogram);
  out.Histogram(
      {}, {{0.5, 1},
           {1, 0, 2},
           7.25,
           {Exemplar{0.25, "0af7651916cd43dd8448eb211c80319c", 1764131400.1254},
            std::nullopt, std::nullopt}});
  out.End();
  EXPECT_EQ(out.text(),
            "# HELP calls Calls \\\"now\\\".\n"
            "# TYPE calls counter\n"
            "calls_total{rpc=\"L\"} 3\n"
            "# HELP seconds Time.\n"
            "# TYPE seconds histogram\n"
            "seconds_bucket{le=\"0.5\"} 1 # "
            "{trace_id=\"0af7651916cd43dd8448eb211c80319c\"} 0.25 "
            "1764131400.125\n"
            "seconds_bucket{le=\"1.0\"} 1\n"
            "seconds_bucket{le=\"+Inf\"} 3\n"
            "seconds_sum 7.25\n"
            "seconds_count 3\n"
            "# EOF\n");
}

TEST(Exposition, ThePlainFormatHasNoRoomForExemplars) {
  Exposition out;
  out.Family("seconds", "Time.", MetricType::kHistogram);
  out.Histogram({}, {{}, {1}, 1, {Exemplar{1, "0af7", 1}}});
  out.End();
  EXPECT_TRUE(ParseExposition(out.text()).ok()) << out.text();
}

TEST(Exposition, TheFormatIsTheOneThatIsPreferred) {
  const auto is_open = [](absl::string_view accept) {
    return FormatFor(accept) == ExpositionFormat::kOpenMetrics;
  };
  // Prometheus 2 and 3, as they ask.
  EXPECT_TRUE(
      is_open("application/openmetrics-text;version=1.0.0,"
              "application/openmetrics-text;version=0.0.1;q=0.75,"
              "text/plain;version=0.0.4;q=0.5,*/*;q=0.1"));
  EXPECT_TRUE(is_open(
      "application/openmetrics-text;version=1.0.0;escaping=allow-utf-8;q=0.6,"
      "text/plain;version=0.0.4;q=0.3,*/*;q=0.2"));
  EXPECT_TRUE(is_open(" Application/OpenMetrics-Text ; q=0.2"));
  for (const char* accept :
       {"", "*/*", "text/html",
        "text/plain, application/openmetrics-text;q=0.5",
        "application/openmetrics-text;q=0", "application/openmetrics-text;q=x",
        "application/openmetrics-textual", ";;,,;q=,"}) {
    EXPECT_FALSE(is_open(accept)) << accept;
  }
}

TEST(Exposition, NumbersReadBackTheSame) {
  EXPECT_EQ(NumberText(0.1), "0.1");
  EXPECT_EQ(NumberText(std::numeric_limits<double>::infinity()), "+Inf");
  EXPECT_EQ(NumberText(-std::numeric_limits<double>::infinity()), "-Inf");
  EXPECT_EQ(NumberText(std::nan("")), "NaN");
  for (uint64_t i = 0; i < 1000; ++i) {
    base::Random random(/*seed=*/3, i);
    const double value =
        std::ldexp(static_cast<double>(random.NextBits()),
                   static_cast<int>(random.NextBelow(200)) - 100);
    EXPECT_EQ(std::strtod(NumberText(value).c_str(), nullptr), value);
  }
}

TEST(Exposition, KnowsNames) {
  EXPECT_TRUE(IsMetricName("treeline_requests_total"));
  EXPECT_TRUE(IsMetricName("a:b"));
  EXPECT_FALSE(IsMetricName(""));
  EXPECT_FALSE(IsMetricName("1a"));
  EXPECT_FALSE(IsMetricName("a-b"));
  EXPECT_TRUE(IsLabelName("scene"));
  EXPECT_FALSE(IsLabelName("a:b"));
  EXPECT_FALSE(IsLabelName("__name__"));
}

TEST(Exposition, WhatIsNotUtf8IsReplaced) {
  const auto shown = [](const std::string& value) {
    Exposition out;
    out.Family("m", "M.", MetricType::kGauge);
    out.Sample({{"l", value}}, 0);
    const std::string& text = out.text();
    const size_t start = text.find("{l=\"") + 4;
    return text.substr(start, text.find("\"}") - start);
  };
  EXPECT_EQ(shown("\xc3\xa4\xe2\x82\xac\xf0\x9f\x8c\xb2"),
            "\xc3\xa4\xe2\x82\xac\xf0\x9f\x8c\xb2");
  const std::string replaced = "\xef\xbf\xbd";
  EXPECT_EQ(shown("\xff"), replaced);
  EXPECT_EQ(shown("a\xc3"), "a" + replaced);
  EXPECT_EQ(shown("\xc0\x80"), replaced + replaced);                 // too long
  EXPECT_EQ(shown("\xed\xa0\x80"), replaced + replaced + replaced);  // half
  EXPECT_EQ(shown("\xf5z"), replaced + "z");
}

// Any bytes as a label's value, and the page still reads back to one sample.
TEST(Exposition, NoLabelBreaksOut) {
  for (uint64_t i = 0; i < 3000; ++i) {
    base::Random random(/*seed=*/11, i);
    // Mostly what has a meaning in the format.
    static constexpr char kSpecial[] = "\"\\\n{},= \r\0#";
    std::string value;
    for (uint32_t n = random.NextBelow(12); n > 0; --n) {
      value.push_back(random.NextBelow(3) == 0
                          ? static_cast<char>(random.NextBelow(128))
                          : kSpecial[random.NextBelow(sizeof(kSpecial) - 1)]);
    }
    Exposition out;
    out.Family("m", "M.", MetricType::kGauge);
    out.Sample({{"l", value}}, 5);
    const auto parsed = ParseExposition(out.text());
    ASSERT_TRUE(parsed.ok()) << parsed.status();
    ASSERT_EQ(parsed->at("m").samples.size(), 1u);
    ASSERT_EQ(SampleOf(*parsed, absl::StrCat("m{l=", value, "}")), 5);
  }
}

// The reader of the tests must itself refuse what is wrong.
TEST(ParseExposition, RefusesWhatIsWrong) {
  const std::string head = "# HELP m M.\n# TYPE m ";
  EXPECT_TRUE(ParseExposition(head + "gauge\nm 1\n").ok());
  EXPECT_FALSE(ParseExposition(head + "gauge\nm 1").ok());
  EXPECT_FALSE(ParseExposition("m 1\n").ok());
  EXPECT_FALSE(ParseExposition("# HELP m M.\nm 1\n").ok());
  EXPECT_FALSE(ParseExposition(head + "gauge\nn 1\n").ok());
  EXPECT_FALSE(ParseExposition(head + "gauge\nm 1\nm 1\n").ok());
  EXPECT_FALSE(ParseExposition(head + "gauge\nm{l=\"a\"b\"} 1\n").ok());
  EXPECT_FALSE(ParseExposition(head + "gauge\nm{l=\"\\x\"} 1\n").ok());
  EXPECT_FALSE(ParseExposition(head + "gauge\nm one\n").ok());
  EXPECT_FALSE(ParseExposition(head + "counter\nm -1\n").ok());
  EXPECT_FALSE(
      ParseExposition(head + "gauge\nm 1\n" + head + "gauge\nm 1\n").ok());
  const std::string h = head + "histogram\n";
  EXPECT_TRUE(ParseExposition(h + "m_bucket{le=\"1\"} 1\n"
                                  "m_bucket{le=\"+Inf\"} 2\n"
                                  "m_sum 3\nm_count 2\n")
                  .ok());
  EXPECT_FALSE(
      ParseExposition(h + "m_bucket{le=\"1\"} 1\nm_sum 3\nm_count 1\n").ok());
  EXPECT_FALSE(ParseExposition(h + "m_bucket{le=\"1\"} 3\n"
                                   "m_bucket{le=\"+Inf\"} 2\n"
                                   "m_sum 3\nm_count 2\n")
                   .ok());
  EXPECT_FALSE(
      ParseExposition(h + "m_bucket{le=\"+Inf\"} 2\nm_sum 3\nm_count 1\n")
          .ok());
}

}  // namespace
}  // namespace treeline::metrics
