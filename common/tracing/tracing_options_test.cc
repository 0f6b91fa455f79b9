#include "common/tracing/tracing_options.h"

#include <algorithm>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::tracing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

using Environment = std::map<std::string, std::string>;

constexpr char kAll[] = "OTEL_EXPORTER_OTLP_ENDPOINT";
constexpr char kTraces[] = "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT";

TracingOptions Of(const Environment& environment) {
  return OptionsFromEnvironment(environment, "treeline-server", "1.2");
}

std::string Resource(const TracingOptions& options, const std::string& name) {
  for (const auto& [key, value] : options.resource) {
    if (key == name) return std::get<std::string>(value);
  }
  return "";
}

TEST(TracingOptions, WithoutAnEndpointThereAreNone) {
  EXPECT_FALSE(Of({}).enabled());
  EXPECT_FALSE(Of({{kAll, ""}}).enabled());
  // Nor is there anything to say of variables that nobody uses.
  const TracingOptions options = Of({{"OTEL_EXPORTER_OTLP_PROTOCOL", "grpc"},
                                     {"OTEL_TRACES_SAMPLER", "odd"}});
  EXPECT_FALSE(options.enabled());
  EXPECT_THAT(options.warnings, IsEmpty());
}

TEST(TracingOptions, TheEndpointOfTracesIsWholeAndTheOtherABase) {
  EXPECT_EQ(Of({{kAll, "http://c:4318"}}).endpoint, "http://c:4318/v1/traces");
  EXPECT_EQ(Of({{kAll, "https://c/otlp/"}}).endpoint,
            "https://c/otlp/v1/traces");
  EXPECT_EQ(Of({{kAll, "http://c:4318"}, {kTraces, "http://t/here"}}).endpoint,
            "http://t/here");
}

TEST(TracingOptions, WhatCannotBeSentIsWarnedOfAndOff) {
  for (const Environment& more :
       {Environment{{"OTEL_EXPORTER_OTLP_PROTOCOL", "grpc"}},
        Environment{{"OTEL_EXPORTER_OTLP_TRACES_PROTOCOL", "http/json"}},
        Environment{{"OTEL_TRACES_EXPORTER", "zipkin"}},
        Environment{{kTraces, "collector:4317"}}}) {
    Environment environment{{kAll, "http://c:4318"}};
    environment.insert(more.begin(), more.end());
    const TracingOptions options = Of(environment);
    EXPECT_FALSE(options.enabled()) << more.begin()->first;
    EXPECT_EQ(options.warnings.size(), 1u);
  }
  for (const Environment& more :
       {Environment{{"OTEL_SDK_DISABLED", "TRUE"}},
        Environment{{"OTEL_TRACES_EXPORTER", "none"}}}) {
    Environment environment{{kAll, "http://c:4318"}};
    environment.insert(more.begin(), more.end());
    EXPECT_FALSE(Of(environment).enabled());
    EXPECT_THAT(Of(environment).warnings, IsEmpty());
  }
}

TEST(TracingOptions, WhoSendsIsNamed) {
  const TracingOptions plain = Of({{kAll, "http://c"}});
  EXPECT_EQ(Resource(plain, "service.name"), "treeline-server");
  EXPECT_EQ(Resource(plain, "service.version"), "1.2");
  const TracingOptions named =
      Of({{kAll, "http://c"},
          {"OTEL_RESOURCE_ATTRIBUTES",
           "service.name=a,deployment.environment=hall%203 , x=1"},
          {"OTEL_SERVICE_NAME", "b"}});
  EXPECT_EQ(Resource(named, "service.name"), "b");
  EXPECT_EQ(Resource(named, "deployment.environment"), "hall 3");
  EXPECT_EQ(Resource(named, "x"), "1");
}

TEST(TracingOptions, HeadersAreReadAndNeverTold) {
  const TracingOptions options =
      Of({{kAll, "http://c"},
          {"OTEL_EXPORTER_OTLP_HEADERS", "api-key=s3cret,x=a%3Db"}});
  EXPECT_THAT(options.headers,
              ElementsAre(Pair("api-key", "s3cret"), Pair("x", "a=b")));
  for (const std::string bad :
       {"s3cret", "k=s3cret%0d%0aEvil: 1", "k=s3cret%2", "s3 cret=1", "=s3cret",
        "k=s3cret%zz", "k=s3cret\r\n"}) {
    const TracingOptions broken = Of(
        {{kAll, "http://c"}, {"OTEL_EXPORTER_OTLP_HEADERS", bad + ",a=b\x01"}});
    EXPECT_THAT(broken.headers, IsEmpty()) << bad;
    ASSERT_EQ(broken.warnings.size(), 1u) << bad;
    EXPECT_THAT(broken.warnings[0], ::testing::Not(HasSubstr("s3")));
  }
}

TEST(TracingOptions, SamplersAreThoseOfOpenTelemetry) {
  const auto sampling = [](const std::string& sampler, const std::string& arg) {
    return Of({{kAll, "http://c"},
               {"OTEL_TRACES_SAMPLER", sampler},
               {"OTEL_TRACES_SAMPLER_ARG", arg}})
        .sampling;
  };
  EXPECT_EQ(sampling("", "").ratio, 1);
  EXPECT_TRUE(sampling("", "").follows_parent);
  EXPECT_EQ(sampling("parentbased_traceidratio", "0.25").ratio, 0.25);
  EXPECT_TRUE(sampling("parentbased_traceidratio", "0.25").follows_parent);
  EXPECT_FALSE(sampling("traceidratio", "0.25").follows_parent);
  EXPECT_EQ(sampling("always_off", "").ratio, 0);
  EXPECT_FALSE(sampling("always_on", "").follows_parent);
  EXPECT_EQ(sampling("parentbased_always_off", "").ratio, 0);
  for (const std::string arg : {"2", "-1", "nan", "much"}) {
    EXPECT_EQ(sampling("traceidratio", arg).ratio, 1) << arg;
  }
  EXPECT_EQ(sampling("odd", "").ratio, 1);
}

TEST(TracingOptions, SettingsGoBeforeTheEnvironment) {
  TracingOptions options = Of({{kAll, "http://c"},
                               {"OTEL_EXPORTER_OTLP_HEADERS", "a=1"},
                               {"OTEL_TRACES_SAMPLER", "always_off"}});
  TracingOptions unchanged = options;
  ASSERT_TRUE(ApplySettings("", {}, -1, unchanged).ok());
  EXPECT_EQ(unchanged.endpoint, options.endpoint);
  EXPECT_EQ(unchanged.headers, options.headers);
  EXPECT_EQ(unchanged.sampling.ratio, 0);
  ASSERT_TRUE(
      ApplySettings("http://d/v1/traces", {"b=2", "c=3"}, 0.5, options).ok());
  EXPECT_EQ(options.endpoint, "http://d/v1/traces");
  EXPECT_THAT(options.headers, ElementsAre(Pair("b", "2"), Pair("c", "3")));
  EXPECT_EQ(options.sampling.ratio, 0.5);
  EXPECT_TRUE(options.sampling.follows_parent);
  for (const char* bad : {"collector:4318", "ftp://c", "http://", "http:///v1",
                          "http://c d", "http://c\n"}) {
    TracingOptions broken;
    EXPECT_TRUE(absl::IsInvalidArgument(ApplySettings(bad, {}, -1, broken)))
        << bad;
  }
}

}  // namespace
}  // namespace treeline::tracing
