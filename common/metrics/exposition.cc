#include "common/metrics/exposition.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace treeline::metrics {
namespace {

const char* NameOf(MetricType type) {
  switch (type) {
    case MetricType::kCounter:
      return "counter";
    case MetricType::kGauge:
      return "gauge";
    case MetricType::kHistogram:
      break;
  }
  return "histogram";
}

// How many bytes at the front are one well-formed UTF-8 sequence; 0: none.
size_t Utf8Length(absl::string_view text) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const auto continues = [&](size_t i) { return (byte(i) & 0xc0) == 0x80; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return continues(1) ? 2 : 0;
  if ((first & 0xf0) == 0xe0) {
    // Neither longer than needed nor half of a surrogate pair.
    if (first == 0xe0 && byte(1) < 0xa0) return 0;
    if (first == 0xed && byte(1) > 0x9f) return 0;
    return continues(1) && continues(2) ? 3 : 0;
  }
  if (first >= 0xf0 && first <= 0xf4) {
    if (first == 0xf0 && byte(1) < 0x90) return 0;
    if (first == 0xf4 && byte(1) > 0x8f) return 0;
    return continues(1) && continues(2) && continues(3) ? 4 : 0;
  }
  return 0;
}

std::string WellFormed(absl::string_view text) {
  std::string result;
  while (!text.empty()) {
    const size_t length = Utf8Length(text);
    if (length == 0) {
      result += "\xef\xbf\xbd";
      text.remove_prefix(1);
    } else {
      absl::StrAppend(&result, text.substr(0, length));
      text.remove_prefix(length);
    }
  }
  return result;
}

constexpr absl::string_view kTotal = "_total";

void AppendLabel(absl::string_view name, absl::string_view value,
                 std::string& text) {
  absl::StrAppend(
      &text, text.empty() ? "{" : ",", name, "=\"",
      absl::StrReplaceAll(WellFormed(value),
                          {{"\\", "\\\\"}, {"\n", "\\n"}, {"\"", "\\\""}}),
      "\"");
}

// The weight that a list of media types gives to one of them; nullopt: it is
// not in the list.
std::optional<double> WeightOf(absl::string_view wanted,
                               absl::string_view accept) {
  std::optional<double> best;
  for (const absl::string_view range : absl::StrSplit(accept, ',')) {
    const std::vector<absl::string_view> parts = absl::StrSplit(range, ';');
    if (!absl::EqualsIgnoreCase(absl::StripAsciiWhitespace(parts[0]), wanted)) {
      continue;
    }
    double weight = 1;
    for (size_t i = 1; i < parts.size(); ++i) {
      absl::string_view parameter = absl::StripAsciiWhitespace(parts[i]);
      if (absl::ConsumePrefix(&parameter, "q=") &&
          !absl::SimpleAtod(parameter, &weight)) {
        weight = 0;
      }
    }
    best = std::max(best.value_or(0), weight);
  }
  return best;
}

}  // namespace

const char* ContentTypeOf(ExpositionFormat format) {
  return format == ExpositionFormat::kOpenMetrics
             ? "application/openmetrics-text; version=1.0.0; charset=utf-8"
             : "text/plain; version=0.0.4; charset=utf-8";
}

ExpositionFormat FormatFor(absl::string_view accept) {
  const double open =
      WeightOf("application/openmetrics-text", accept).value_or(0);
  const double plain = WeightOf("text/plain", accept).value_or(0);
  return open > 0 && open >= plain ? ExpositionFormat::kOpenMetrics
                                   : ExpositionFormat::kPrometheus;
}

std::string NumberText(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  char buffer[32];
  return std::string(buffer,
                     std::to_chars(buffer, buffer + sizeof(buffer), value).ptr);
}

bool IsMetricName(absl::string_view name) {
  return !name.empty() &&
         !absl::ascii_isdigit(static_cast<unsigned char>(name[0])) &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  c == '_' || c == ':';
         });
}

bool IsLabelName(absl::string_view name) {
  return IsMetricName(name) && !absl::StrContains(name, ":") &&
         !absl::StartsWith(name, "__");
}

void Exposition::Family(absl::string_view name, absl::string_view help,
                        MetricType type) {
  // Names are ours: another one is a mistake in the program.
  if (!IsMetricName(name)) std::abort();
  sample_suffix_ = "";
  if (format_ == ExpositionFormat::kOpenMetrics &&
      type == MetricType::kCounter) {
    // There, the counter itself has the name without it.
    name = absl::StripSuffix(name, kTotal);
    sample_suffix_ = kTotal;
  }
  name_ = std::string(name);
  absl::StrAppend(
      &text_, "# HELP ", name, " ",
      absl::StrReplaceAll(
          WellFormed(help),
          {{"\\", "\\\\"},
           {"\n", "\\n"},
           {"\"", format_ == ExpositionFormat::kOpenMetrics ? "\\\"" : "\""}}),
      "\n# TYPE ", name, " ", NameOf(type), "\n");
}

void Exposition::Line(absl::string_view suffix, const Labels& labels,
                      const std::pair<absl::string_view, std::string>* more,
                      double value, const std::optional<Exemplar>& exemplar) {
  std::string braces;
  for (const auto& [name, label] : labels) {
    if (!IsLabelName(name)) std::abort();
    AppendLabel(name, label, braces);
  }
  if (more != nullptr) AppendLabel(more->first, more->second, braces);
  if (!braces.empty()) braces += "}";
  absl::StrAppend(&text_, name_, suffix, braces, " ", NumberText(value));
  if (exemplar.has_value()) {
    absl::StrAppend(&text_, " # {trace_id=\"", exemplar->trace_id, "\"} ",
                    NumberText(exemplar->value), " ",
                    absl::StrFormat("%.3f", exemplar->unix_s));
  }
  text_ += "\n";
}

std::string Exposition::BoundText(double bound) const {
  std::string text = NumberText(bound);
  // OpenMetrics wants the same bound to be the same text everywhere.
  if (format_ == ExpositionFormat::kOpenMetrics &&
      text.find_first_not_of("0123456789") == std::string::npos) {
    text += ".0";
  }
  return text;
}

void Exposition::End() {
  if (format_ == ExpositionFormat::kOpenMetrics) text_ += "# EOF\n";
}

void Exposition::Sample(const Labels& labels, double value) {
  Line(sample_suffix_, labels, nullptr, value);
}

void Exposition::Histogram(const Labels& labels,
                           const HistogramCounts& histogram) {
  uint64_t total = 0;
  for (size_t i = 0; i < histogram.counts.size(); ++i) {
    total += histogram.counts[i];
    const std::pair<absl::string_view, std::string> bound = {
        "le", i < histogram.upper_bounds.size()
                  ? BoundText(histogram.upper_bounds[i])
                  : "+Inf"};
    const bool has_room = format_ == ExpositionFormat::kOpenMetrics &&
                          i < histogram.exemplars.size();
    Line("_bucket", labels, &bound, static_cast<double>(total),
         has_room ? histogram.exemplars[i] : std::nullopt);
  }
  Line("_sum", labels, nullptr, histogram.sum);
  Line("_count", labels, nullptr, static_cast<double>(total));
}

}  // namespace treeline::metrics
