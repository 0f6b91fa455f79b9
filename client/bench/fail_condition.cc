#include "client/bench/fail_condition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client/bench/bench_report.h"
#include "common/base/status_macros.h"

namespace treeline::bench {
namespace {

enum class Kind { kDuration, kCount, kShare, kRate };

double NaN() { return std::nan(""); }

const LatencyHistogram& OkLatency(const LoadRun& run) {
  return run.tally.latencies[static_cast<size_t>(CallKind::kOk)].from_schedule;
}

double PercentileOf(const LoadRun& run, double percent) {
  return OkLatency(run).count() == 0 ? NaN()
                                     : OkLatency(run).Percentile_ms(percent);
}

double CountOf(const LoadRun& run, CallKind kind) {
  return static_cast<double>(run.tally.counts[static_cast<size_t>(kind)]);
}

double ShareOf(double part, double whole) {
  return whole > 0 ? 100 * part / whole : NaN();
}

struct Figure {
  const char* name;
  Kind kind;
  const char* help;
  double (*of)(const LoadRun& run);
};

// In the order of the help.
constexpr std::array<Figure, 18> kFigures = {{
    {"p50", Kind::kDuration, "latency that half of the answers keep",
     [](const LoadRun& run) { return PercentileOf(run, 50); }},
    {"p90", Kind::kDuration, "that 90 % keep",
     [](const LoadRun& run) { return PercentileOf(run, 90); }},
    {"p95", Kind::kDuration, "that 95 % keep",
     [](const LoadRun& run) { return PercentileOf(run, 95); }},
    {"p99", Kind::kDuration, "that 99 % keep",
     [](const LoadRun& run) { return PercentileOf(run, 99); }},
    {"p99.9", Kind::kDuration, "that 99.9 % keep",
     [](const LoadRun& run) { return PercentileOf(run, 99.9); }},
    {"mean", Kind::kDuration, "mean latency of answers",
     [](const LoadRun& run) {
       return OkLatency(run).count() == 0 ? NaN() : OkLatency(run).mean_ms();
     }},
    {"max", Kind::kDuration, "longest latency of an answer",
     [](const LoadRun& run) {
       return OkLatency(run).count() == 0 ? NaN() : OkLatency(run).max_ms();
     }},
    {"wrong", Kind::kCount, "poses beyond the tolerance of the truth",
     [](const LoadRun& run) {
       return static_cast<double>(run.tally.checks.wrong_poses);
     }},
    {"different", Kind::kCount, "answers other than before",
     [](const LoadRun& run) {
       return static_cast<double>(run.tally.checks.different);
     }},
    {"failed", Kind::kCount, "calls that failed",
     [](const LoadRun& run) { return CountOf(run, CallKind::kFailed); }},
    {"shed", Kind::kCount, "calls that were turned away",
     [](const LoadRun& run) { return CountOf(run, CallKind::kShed); }},
    {"late", Kind::kCount, "calls past their deadline",
     [](const LoadRun& run) { return CountOf(run, CallKind::kDeadline); }},
    {"not-sent", Kind::kCount, "arrivals that the generator could not send",
     [](const LoadRun& run) { return static_cast<double>(run.not_sent); }},
    {"errors", Kind::kShare, "calls without an answer, of all",
     [](const LoadRun& run) {
       const auto all = static_cast<double>(run.tally.total());
       return ShareOf(all - CountOf(run, CallKind::kOk), all);
     }},
    {"localized", Kind::kShare, "localized, of the answers",
     [](const LoadRun& run) {
       return ShareOf(static_cast<double>(run.tally.localized),
                      CountOf(run, CallKind::kOk));
     }},
    {"within", Kind::kShare, "within tolerance, of answers with a true pose",
     [](const LoadRun& run) {
       return ShareOf(static_cast<double>(run.tally.checks.within_tolerance),
                      static_cast<double>(run.tally.checks.with_truth));
     }},
    {"goodput", Kind::kRate, "answers in time that were not different",
     [](const LoadRun& run) { return Goodput_per_s(run); }},
    {"lag", Kind::kDuration, "p99 of how late the generator sent",
     [](const LoadRun& run) { return run.send_lag.Percentile_ms(99); }},
}};

const char* UnitsOf(Kind kind) {
  switch (kind) {
    case Kind::kDuration:
      return "us, ms or s";
    case Kind::kShare:
      return "%";
    case Kind::kRate:
      return "/s or nothing";
    case Kind::kCount:
      break;
  }
  return "no unit";
}

// How many of the figure's own units one of these is; nullopt: none of its.
std::optional<double> UnitOf(Kind kind, absl::string_view unit) {
  switch (kind) {
    case Kind::kDuration:
      if (unit == "us") return 1e-3;
      if (unit == "ms") return 1;
      if (unit == "s") return 1e3;
      return std::nullopt;
    case Kind::kShare:
      return unit == "%" ? std::optional<double>(1) : std::nullopt;
    case Kind::kRate:
      return unit == "/s" || unit.empty() ? std::optional<double>(1)
                                          : std::nullopt;
    case Kind::kCount:
      break;
  }
  return unit.empty() ? std::optional<double>(1) : std::nullopt;
}

const Figure* FindFigure(absl::string_view name) {
  const auto* const found =
      std::find_if(kFigures.begin(), kFigures.end(),
                   [&](const Figure& figure) { return name == figure.name; });
  return found == kFigures.end() ? nullptr : found;
}

std::string Text(absl::string_view text) { return {text.data(), text.size()}; }

std::string Names() {
  std::string names;
  for (const Figure& figure : kFigures) {
    absl::StrAppend(&names, names.empty() ? "" : ", ", figure.name);
  }
  return names;
}

absl::StatusOr<FailCondition> ParseOne(absl::string_view text) {
  const auto refuse = [&](const std::string& why) {
    return absl::InvalidArgumentError(
        absl::StrCat("--fail-if: \"", text, "\": ", why));
  };
  const size_t at = text.find_first_of("<>=!");
  if (at == absl::string_view::npos) {
    return refuse("no comparison; write for instance p99>50ms or wrong>0");
  }
  const absl::string_view name = absl::StripAsciiWhitespace(text.substr(0, at));
  const Figure* figure = FindFigure(name);
  if (figure == nullptr) {
    return refuse(
        absl::StrCat("there is no figure \"", name, "\"; there are ", Names()));
  }
  absl::string_view rest = text.substr(at);
  if (rest.front() != '<' && rest.front() != '>') {
    return refuse("compare with >, >=, < or <=");
  }
  FailCondition condition{
      .text = Text(text), .figure = figure->name, .above = rest.front() == '>'};
  rest.remove_prefix(1);
  condition.or_equal = absl::ConsumePrefix(&rest, "=");
  rest = absl::StripAsciiWhitespace(rest);
  const size_t digits =
      std::min(rest.find_first_not_of("0123456789.+-"), rest.size());
  if (!absl::SimpleAtod(rest.substr(0, digits), &condition.limit)) {
    return refuse(absl::StrCat("\"", rest, "\" does not begin with a number"));
  }
  const absl::string_view unit =
      absl::StripAsciiWhitespace(rest.substr(digits));
  const std::optional<double> factor = UnitOf(figure->kind, unit);
  if (!factor) {
    return refuse(absl::StrCat("the unit of ", figure->name, " is ",
                               UnitsOf(figure->kind), ", not \"", unit, "\""));
  }
  condition.limit *= *factor;
  return condition;
}

std::string ValueText(Kind kind, double value) {
  switch (kind) {
    case Kind::kDuration:
      return absl::StrFormat("%.2f ms", value);
    case Kind::kShare:
      return absl::StrFormat("%.2f %%", value);
    case Kind::kRate:
      return absl::StrFormat("%.1f/s", value);
    case Kind::kCount:
      break;
  }
  return absl::StrFormat("%.0f", value);
}

bool IsSo(const FailCondition& condition, double value) {
  if (condition.or_equal && value == condition.limit) return true;
  return condition.above ? value > condition.limit : value < condition.limit;
}

}  // namespace

absl::StatusOr<std::vector<FailCondition>> ParseFailConditions(
    absl::string_view text) {
  std::vector<FailCondition> conditions;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    TL_ASSIGN_OR_RETURN(FailCondition condition,
                        ParseOne(absl::StripAsciiWhitespace(part)));
    conditions.push_back(std::move(condition));
  }
  return conditions;
}

std::string FigureHelp() {
  std::string help;
  for (const Figure& figure : kFigures) {
    absl::StrAppendFormat(&help, "  %-10s %s (%s)\n", figure.name, figure.help,
                          UnitsOf(figure.kind));
  }
  return help;
}

std::vector<std::string> Failures(const std::vector<FailCondition>& conditions,
                                  const LoadRun& run) {
  std::vector<std::string> failures;
  for (const FailCondition& condition : conditions) {
    const Figure& figure = *FindFigure(condition.figure);
    const double value = figure.of(run);
    if (std::isnan(value)) {
      failures.push_back(
          absl::StrCat(figure.name, " has no value (", condition.text, ")"));
    } else if (IsSo(condition, value)) {
      failures.push_back(absl::StrCat(figure.name, " is ",
                                      ValueText(figure.kind, value), " (",
                                      condition.text, ")"));
    }
  }
  return failures;
}

}  // namespace treeline::bench
