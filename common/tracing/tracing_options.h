// Whether and where a program sends its spans.
#ifndef COMMON_TRACING_TRACING_OPTIONS_H_
#define COMMON_TRACING_TRACING_OPTIONS_H_

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/tracing/span.h"
#include "common/tracing/tracer.h"

namespace treeline::tracing {

struct TracingOptions {
  // Where spans are posted to, as a whole: "http://collector:4318/v1/traces".
  // Empty: nowhere, and there are no spans.
  std::string endpoint = {};
  // Sent with each request. Secret.
  std::vector<std::pair<std::string, std::string>> headers = {};
  // Authorities to trust for an https endpoint, PEM; empty: the system's.
  std::string ca_file = {};
  // Of one request.
  std::chrono::milliseconds timeout = std::chrono::seconds(10);
  // Who sends: service.name and so on.
  Attributes resource = {};
  Sampling sampling = {};
  // What of the environment is not understood, and was left out: for the log.
  std::vector<std::string> warnings = {};

  bool enabled() const { return !endpoint.empty(); }
  // INVALID_ARGUMENT.
  absl::Status Validate() const;
};

// The variables of OpenTelemetry by their whole names, of which these count:
// OTEL_SDK_DISABLED, OTEL_TRACES_EXPORTER, OTEL_EXPORTER_OTLP_TRACES_... or
// OTEL_EXPORTER_OTLP_... with ENDPOINT, HEADERS, PROTOCOL, CERTIFICATE and
// TIMEOUT, OTEL_SERVICE_NAME, OTEL_RESOURCE_ATTRIBUTES, OTEL_TRACES_SAMPLER,
// OTEL_TRACES_SAMPLER_ARG. Without an endpoint there are no traces, other than
// OpenTelemetry has it: a program that nobody told sends nothing.
// https://opentelemetry.io/docs/specs/otel/configuration/sdk-environment-variables
// What is wrong in them is a warning, as OpenTelemetry demands. `service` is
// the name where they have none.
TracingOptions OptionsFromEnvironment(
    const std::map<std::string, std::string>& environment,
    absl::string_view service, absl::string_view version);

// A program's own settings go before the environment. An empty endpoint or
// list of headers, and a ratio below 0: as the environment has it.
// INVALID_ARGUMENT.
absl::Status ApplySettings(absl::string_view endpoint,
                           const std::vector<std::string>& headers,
                           double ratio, TracingOptions& options);

// OK or INVALID_ARGUMENT for what a setting of an endpoint says.
absl::Status CheckEndpoint(absl::string_view endpoint);

// "a=1,b=x%20y", as W3C's baggage has it: names and values of headers and
// attributes. INVALID_ARGUMENT does not say what stands there.
absl::StatusOr<std::vector<std::pair<std::string, std::string>>> ParsePairs(
    absl::string_view text);

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_TRACING_OPTIONS_H_
