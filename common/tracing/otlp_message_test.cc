#include "common/tracing/otlp_message.h"

#include <chrono>
#include <limits>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "gtest/gtest.h"

namespace treeline::tracing {
namespace {

WallTime At(uint64_t unix_ns) {
  return WallTime(std::chrono::duration_cast<WallTime::duration>(
      std::chrono::nanoseconds(unix_ns)));
}

Span ForestSpan() {
  Span span;
  span.context = {"0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331", true};
  span.parent_span_id = "00f067aa0ba902b7";
  span.name = "forest";
  span.kind = SpanKind::kServer;
  span.start = At(0x180000015e6f7081);
  span.end = At(0x180000015e6f7082);
  span.attributes = {{"a", true}, {"b", int64_t{-300}}, {"c", 0.25}};
  span.is_error = true;
  span.error = "QUEUE_FULL";
  return span;
}

// What protobufjs writes for the same by OpenTelemetry's definition (npm's
// @opentelemetry/otlp-transformer 0.57.2), and behind it the field `flags`,
// which is younger.
TEST(OtlpMessage, IsWhatOthersWrite) {
  EXPECT_EQ(
      absl::BytesToHexString(OtlpMessage(
          {{"service.name", std::string("robot")}}, "1.2", {ForestSpan()})),
      "0ab5010a190a170a0c736572766963652e6e616d6512070a05726f626f74129701"
      "0a0f0a08747265656c696e651203312e32128301"
      "0a100af7651916cd43dd8448eb211c80319c1208b7ad6b7169203331"
      "220800f067aa0ba902b72a06666f7265737430023981706f5e01000018"
      "4182706f5e010000184a070a0161120210014a100a0162120b18d4fdffffffffffffff"
      "014a0e0a0163120921000000000000d03f7a0e120a51554555455f46554c4c1802"
      "850101000000");
}

TEST(OtlpMessage, WhatWentWellHasNoStatusAndARootNoParent) {
  Span span = ForestSpan();
  span.parent_span_id = "";
  span.is_error = false;
  span.error = "";
  const std::string message = OtlpMessage({}, "", {span});
  EXPECT_FALSE(absl::StrContains(message, "QUEUE_FULL"));
  EXPECT_FALSE(absl::StrContains(
      message, absl::HexStringToBytes("220800f067aa0ba902b7")));
}

TEST(OtlpMessage, TextIsAsciiAndShort) {
  Span span = ForestSpan();
  span.attributes = {{"odd", std::string("k\xc3\xbc\xff", 4)},
                     {"none", std::string(1, '\0')},
                     {"long", std::string(5000, 'x')},
                     {"nan", std::numeric_limits<double>::quiet_NaN()}};
  const std::string message = OtlpMessage({}, "", {span});
  EXPECT_TRUE(absl::StrContains(message, "k???"));
  EXPECT_TRUE(absl::StrContains(message, std::string(1024, 'x')));
  EXPECT_FALSE(absl::StrContains(message, std::string(1025, 'x')));
}

}  // namespace
}  // namespace treeline::tracing
