#include "common/dataset/frame_times.h"

#include <cstdint>
#include <optional>

#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"

namespace treeline::dataset {
namespace {

constexpr int64_t kMaxNumber = 100'000'000;

// "seq-01/frame-000123": what is before the number, and the number.
struct NumberedStem {
  absl::string_view prefix;
  int64_t number = 0;
};

std::optional<NumberedStem> SplitStem(absl::string_view stem) {
  const size_t end = stem.find_last_not_of("0123456789");
  const size_t digits = end == absl::string_view::npos ? 0 : end + 1;
  NumberedStem result = {.prefix = stem.substr(0, digits), .number = 0};
  if (!absl::SimpleAtoi(stem.substr(digits), &result.number) ||
      result.number > kMaxNumber) {
    return std::nullopt;
  }
  return result;
}

// How many periods lie between two frames.
int64_t PeriodsBetween(absl::string_view before, absl::string_view after) {
  const std::optional<NumberedStem> a = SplitStem(before);
  const std::optional<NumberedStem> b = SplitStem(after);
  if (!a || !b || a->prefix != b->prefix || b->number <= a->number) return 1;
  return b->number - a->number;
}

}  // namespace

std::vector<Time_ns> FrameTimes(const Dataset& dataset) {
  std::vector<Time_ns> times;
  int64_t periods = 0;
  for (int i = 0; i < dataset.size(); ++i) {
    const std::string& stem = dataset.frame(i).stem;
    if (const absl::StatusOr<Time_ns> time = ParseTime_ns(stem); time.ok()) {
      times.push_back(*time);
      continue;
    }
    if (i == 0) {
      const std::optional<NumberedStem> first = SplitStem(stem);
      if (first) periods = first->number;
    } else {
      periods += PeriodsBetween(dataset.frame(i - 1).stem, stem);
    }
    times.push_back(periods * 1'000'000'000 / kFrameRate_hz);
  }
  return times;
}

}  // namespace treeline::dataset
