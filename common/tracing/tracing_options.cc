#include "common/tracing/tracing_options.h"

#include <algorithm>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"

namespace treeline::tracing {
namespace {

constexpr char kTracesPath[] = "/v1/traces";
constexpr int64_t kLongestTimeout_ms = 60'000;

using Environment = std::map<std::string, std::string>;

// An empty variable counts as none.
std::string Get(const Environment& environment, const std::string& name) {
  const auto found = environment.find(name);
  return found == environment.end() ? "" : found->second;
}

// "ENDPOINT": of traces alone, or else of everything.
std::string GetOtlp(const Environment& environment, const std::string& name) {
  std::string of_traces = Get(environment, "OTEL_EXPORTER_OTLP_TRACES_" + name);
  return of_traces.empty() ? Get(environment, "OTEL_EXPORTER_OTLP_" + name)
                           : of_traces;
}

std::string EndpointOf(const Environment& environment) {
  std::string of_traces =
      Get(environment, "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT");
  if (!of_traces.empty()) return of_traces;
  const std::string of_all = Get(environment, "OTEL_EXPORTER_OTLP_ENDPOINT");
  if (of_all.empty()) return "";
  return absl::StrCat(absl::StripSuffix(of_all, "/"), kTracesPath);
}

// %20 and the like; nullopt: broken.
std::optional<std::string> PercentDecoded(absl::string_view text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded.push_back(text[i]);
      continue;
    }
    uint32_t byte = 0;
    if (i + 2 >= text.size() ||
        !absl::SimpleHexAtoi(text.substr(i + 1, 2), &byte)) {
      return std::nullopt;
    }
    decoded.push_back(static_cast<char>(byte));
    i += 2;
  }
  return decoded;
}

bool IsHeaderName(absl::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' ||
           c == '_' || c == '.';
  });
}

bool IsPrintable(absl::string_view value) {
  return std::all_of(value.begin(), value.end(), [](char c) {
    return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
  });
}

void SetAttribute(const std::string& name, std::string value,
                  Attributes& attributes) {
  for (auto& [known, old] : attributes) {
    if (known == name) {
      old = std::move(value);
      return;
    }
  }
  attributes.emplace_back(name, std::move(value));
}

void ReadResource(const Environment& environment, absl::string_view service,
                  absl::string_view version, TracingOptions& options) {
  SetAttribute("service.name", std::string(service), options.resource);
  SetAttribute("service.version", std::string(version), options.resource);
  const auto pairs = ParsePairs(Get(environment, "OTEL_RESOURCE_ATTRIBUTES"));
  if (pairs.ok()) {
    for (const auto& [name, value] : *pairs) {
      SetAttribute(name, value, options.resource);
    }
  } else {
    options.warnings.push_back(
        absl::StrCat("OTEL_RESOURCE_ATTRIBUTES: ", pairs.status().message()));
  }
  const std::string name = Get(environment, "OTEL_SERVICE_NAME");
  if (!name.empty()) SetAttribute("service.name", name, options.resource);
}

void ReadSampling(const Environment& environment, TracingOptions& options) {
  std::string sampler = Get(environment, "OTEL_TRACES_SAMPLER");
  if (sampler.empty()) return;
  constexpr absl::string_view kParentBased = "parentbased_";
  absl::string_view root = sampler;
  const bool follows_parent = absl::ConsumePrefix(&root, kParentBased);
  if (root == "always_on") {
    options.sampling = {1, follows_parent};
  } else if (root == "always_off") {
    options.sampling = {0, follows_parent};
  } else if (root == "traceidratio") {
    const std::string text = Get(environment, "OTEL_TRACES_SAMPLER_ARG");
    double ratio = 1;
    if (!text.empty() &&
        !(absl::SimpleAtod(text, &ratio) && ratio >= 0 && ratio <= 1)) {
      options.warnings.push_back(
          "OTEL_TRACES_SAMPLER_ARG is not a number from 0 to 1: all traces "
          "are recorded");
      ratio = 1;
    }
    options.sampling = {ratio, follows_parent};
  } else {
    options.warnings.push_back(
        "OTEL_TRACES_SAMPLER is none of always_on, always_off, traceidratio, "
        "alone or after parentbased_: left out");
  }
}

// Whether what is asked for is what this sends.
bool CanSend(const Environment& environment, TracingOptions& options) {
  const std::string exporter = Get(environment, "OTEL_TRACES_EXPORTER");
  if (!exporter.empty() && exporter != "otlp") {
    if (exporter != "none") {
      options.warnings.push_back(
          "OTEL_TRACES_EXPORTER: only otlp is there; no traces are sent");
    }
    return false;
  }
  const std::string protocol = GetOtlp(environment, "PROTOCOL");
  if (!protocol.empty() && protocol != "http/protobuf") {
    options.warnings.push_back(
        "OTEL_EXPORTER_OTLP_PROTOCOL: only http/protobuf is spoken; no traces "
        "are sent");
    return false;
  }
  return true;
}

void ReadExporter(const Environment& environment, TracingOptions& options) {
  options.ca_file = GetOtlp(environment, "CERTIFICATE");
  const std::string timeout = GetOtlp(environment, "TIMEOUT");
  int64_t timeout_ms = 0;
  if (!timeout.empty()) {
    if (absl::SimpleAtoi(timeout, &timeout_ms) && timeout_ms >= 1) {
      options.timeout =
          std::chrono::milliseconds(std::min(timeout_ms, kLongestTimeout_ms));
    } else {
      options.warnings.push_back(
          "OTEL_EXPORTER_OTLP_TIMEOUT is no number of milliseconds: left out");
    }
  }
  const auto headers = ParsePairs(GetOtlp(environment, "HEADERS"));
  if (headers.ok()) {
    options.headers = *headers;
  } else {
    options.warnings.push_back(absl::StrCat("OTEL_EXPORTER_OTLP_HEADERS: ",
                                            headers.status().message()));
  }
}

}  // namespace

absl::Status CheckEndpoint(absl::string_view endpoint) {
  absl::string_view rest = endpoint;
  if (!absl::ConsumePrefix(&rest, "http://") &&
      !absl::ConsumePrefix(&rest, "https://")) {
    return absl::InvalidArgumentError(
        "an address of traces begins with http:// or https://");
  }
  const bool has_host = !rest.empty() && rest[0] != '/' && rest[0] != ':';
  if (!has_host || !IsPrintable(rest) || absl::StrContains(rest, " ")) {
    return absl::InvalidArgumentError(
        "an address of traces is like http://HOST:4318/v1/traces");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::pair<std::string, std::string>>> ParsePairs(
    absl::string_view text) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    const absl::string_view pair = absl::StripAsciiWhitespace(part);
    if (pair.empty()) continue;
    const size_t equals = pair.find('=');
    if (equals == absl::string_view::npos) {
      return absl::InvalidArgumentError("not a list of NAME=VALUE");
    }
    const absl::string_view name =
        absl::StripAsciiWhitespace(pair.substr(0, equals));
    const std::optional<std::string> value =
        PercentDecoded(absl::StripAsciiWhitespace(pair.substr(equals + 1)));
    if (!IsHeaderName(name) || !value.has_value() || !IsPrintable(*value)) {
      return absl::InvalidArgumentError(
          "a name or a value has characters that it may not have");
    }
    pairs.emplace_back(name, *value);
  }
  return pairs;
}

absl::Status TracingOptions::Validate() const {
  if (!enabled()) return absl::OkStatus();
  TL_RETURN_IF_ERROR(CheckEndpoint(endpoint));
  if (!(sampling.ratio >= 0 && sampling.ratio <= 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the share of traces is ", sampling.ratio, "; it must be 0..1"));
  }
  return absl::OkStatus();
}

TracingOptions OptionsFromEnvironment(const Environment& environment,
                                      absl::string_view service,
                                      absl::string_view version) {
  TracingOptions options;
  ReadResource(environment, service, version, options);
  ReadSampling(environment, options);
  if (absl::EqualsIgnoreCase(Get(environment, "OTEL_SDK_DISABLED"), "true")) {
    options.warnings.clear();
    return options;
  }
  const std::string endpoint = EndpointOf(environment);
  ReadExporter(environment, options);
  if (endpoint.empty()) {
    // Of what nobody asked for, nobody wants to hear.
    options.warnings.clear();
    return options;
  }
  if (const absl::Status valid = CheckEndpoint(endpoint); !valid.ok()) {
    options.warnings.push_back(
        absl::StrCat("OTEL_EXPORTER_OTLP_ENDPOINT: ", valid.message(),
                     "; no traces are sent"));
  } else if (CanSend(environment, options)) {
    options.endpoint = endpoint;
  }
  return options;
}

absl::Status ApplySettings(absl::string_view endpoint,
                           const std::vector<std::string>& headers,
                           double ratio, TracingOptions& options) {
  if (!endpoint.empty()) options.endpoint = std::string(endpoint);
  if (!headers.empty()) {
    TL_ASSIGN_OR_RETURN(options.headers,
                        ParsePairs(absl::StrJoin(headers, ",")));
  }
  if (ratio >= 0) options.sampling = {ratio, /*follows_parent=*/true};
  return options.Validate();
}

}  // namespace treeline::tracing
