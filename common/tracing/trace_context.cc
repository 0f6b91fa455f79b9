#include "common/tracing/trace_context.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace treeline::tracing {
namespace {

constexpr size_t kLength = 55;
constexpr size_t kTraceIdAt = 3;
constexpr size_t kTraceIdDigits = 32;
constexpr size_t kSpanIdAt = 36;
constexpr size_t kSpanIdDigits = 16;
constexpr size_t kFlagsAt = 53;

int DigitOf(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

bool IsHex(absl::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return DigitOf(c) >= 0; });
}

bool IsId(absl::string_view text) {
  return IsHex(text) && text.find_first_not_of('0') != absl::string_view::npos;
}

}  // namespace

std::optional<TraceContext> ParseTraceparent(absl::string_view header) {
  if (header.size() != kLength || header.substr(0, kTraceIdAt) != "00-" ||
      header[kSpanIdAt - 1] != '-' || header[kFlagsAt - 1] != '-') {
    return std::nullopt;
  }
  const absl::string_view trace_id = header.substr(kTraceIdAt, kTraceIdDigits);
  const absl::string_view span_id = header.substr(kSpanIdAt, kSpanIdDigits);
  const absl::string_view flags = header.substr(kFlagsAt);
  if (!IsId(trace_id) || !IsId(span_id) || !IsHex(flags)) return std::nullopt;
  return TraceContext{std::string(trace_id), std::string(span_id),
                      (DigitOf(flags[1]) & 1) != 0};
}

std::string Traceparent(const TraceContext& context) {
  return absl::StrCat("00-", context.trace_id, "-", context.span_id,
                      context.sampled ? "-01" : "-00");
}

}  // namespace treeline::tracing
