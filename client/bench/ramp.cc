#include "client/bench/ramp.h"

#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"

namespace treeline::bench {
namespace {

constexpr size_t kMaxSteps = 200;
// Of a step: closer to the end than this is the end.
constexpr double kRounding = 1e-9;

absl::Status Refuse(absl::string_view text, absl::string_view why) {
  return absl::InvalidArgumentError(
      absl::StrCat("the ramp \"", text, "\": ", why,
                   "; write FROM:TO:+STEP, FROM:TO:xFACTOR or a list A,B,C"));
}

absl::StatusOr<double> Positive(absl::string_view text,
                                absl::string_view number) {
  double value = 0;
  if (!absl::SimpleAtod(number, &value) || !(value > 0) || value > 1e9) {
    return Refuse(text, absl::StrCat("\"", number, "\" is no positive number"));
  }
  return value;
}

absl::StatusOr<std::vector<double>> ParseList(absl::string_view text) {
  std::vector<double> steps;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    TL_ASSIGN_OR_RETURN(const double value, Positive(text, part));
    if (!steps.empty() && value <= steps.back()) {
      return Refuse(text, "it does not grow");
    }
    steps.push_back(value);
  }
  if (steps.size() > kMaxSteps) return Refuse(text, "more than 200 steps");
  return steps;
}

}  // namespace

absl::StatusOr<std::vector<double>> ParseRamp(absl::string_view text) {
  const std::vector<absl::string_view> parts = absl::StrSplit(text, ':');
  if (parts.size() == 1) return ParseList(text);
  if (parts.size() != 3 || parts[2].empty() ||
      (parts[2].front() != '+' && parts[2].front() != 'x')) {
    return Refuse(text, "it has no step");
  }
  TL_ASSIGN_OR_RETURN(const double from, Positive(text, parts[0]));
  TL_ASSIGN_OR_RETURN(const double to, Positive(text, parts[1]));
  TL_ASSIGN_OR_RETURN(const double step, Positive(text, parts[2].substr(1)));
  const bool adds = parts[2].front() == '+';
  if (to < from || (!adds && step <= 1)) {
    return Refuse(text, "it does not grow");
  }
  std::vector<double> steps;
  double value = from;
  while (value < to * (1 - kRounding)) {
    steps.push_back(value);
    if (steps.size() >= kMaxSteps) return Refuse(text, "more than 200 steps");
    value = adds ? value + step : value * step;
  }
  steps.push_back(to);
  return steps;
}

}  // namespace treeline::bench
