// What clients and servers send beside images: traceparent headers, answers of
// health checks, and texts that end in logs and metrics. Arbitrary bytes: no
// crash, and nothing that breaks out of its place.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/string_view.h"
#include "common/log/log_line.h"
#include "common/metrics/exposition.h"
#include "common/metrics/testing_exposition.h"
#include "common/tracing/trace_context.h"
#include "server/app/healthcheck.h"

namespace treeline {
namespace {

bool IsPlain(const std::string& text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return c >= 0x20 && c < 0x7f; });
}

void Check(bool holds) {
  if (!holds) std::abort();
}

void Use(absl::string_view bytes) {
  if (const auto trace = tracing::ParseTraceparent(bytes)) {
    Check(trace->trace_id.size() == 32 && trace->span_id.size() == 16);
    Check(IsPlain(trace->trace_id) && IsPlain(trace->span_id));
  }
  // Any answer but 1 is "not serving".
  server_app::DecodeHealthResponse(bytes).status().IgnoreError();

  logging::LogLine json(logging::LogFormat::kJson);
  json.Text("scene", bytes).Message(bytes).Word("end", "x");
  Check(IsPlain(json.fields()));
  const auto object =
      nlohmann::json::parse("{" + json.fields() + "}", nullptr, false);
  Check(object.is_object() && object.size() == 3 && object["end"] == "x");
  logging::LogLine text(logging::LogFormat::kText);
  text.Text("scene", bytes);
  Check(IsPlain(text.fields()));

  metrics::Exposition metrics;
  metrics.Family("m", "M.", metrics::MetricType::kGauge);
  metrics.Sample({{"l", std::string(bytes)}}, 1);
  const auto parsed = metrics::ParseExposition(metrics.text());
  Check(parsed.ok() && parsed->at("m").samples.size() == 1);
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Use(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
