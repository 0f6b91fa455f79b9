#include "nav_agent/recording/recording_time.h"

#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/str_format.h"

namespace treeline::recording {

std::optional<RecordingTime> ParseRecordingTime(absl::string_view text) {
  constexpr int64_t kNanosecondsPerSecond = 1'000'000'000;
  constexpr int64_t kMaxSeconds = 9'000'000'000;
  int64_t seconds = 0;
  int64_t nanoseconds = 0;
  int64_t unit_ns = kNanosecondsPerSecond;
  bool after_point = false;
  int digits = 0;
  for (const char c : text) {
    if (c == '.' && !after_point) {
      after_point = true;
      continue;
    }
    if (!absl::ascii_isdigit(static_cast<unsigned char>(c))) return {};
    ++digits;
    if (after_point) {
      unit_ns /= 10;
      nanoseconds += (c - '0') * unit_ns;
    } else {
      seconds = 10 * seconds + (c - '0');
      if (seconds > kMaxSeconds) return {};
    }
  }
  if (digits == 0) return {};
  return RecordingTime(
      std::chrono::nanoseconds(seconds * kNanosecondsPerSecond + nanoseconds));
}

std::string FormatRecordingTime(RecordingTime time) {
  const int64_t microseconds =
      std::chrono::floor<std::chrono::microseconds>(time.time_since_epoch())
          .count();
  return absl::StrFormat("%d.%06d", microseconds / 1'000'000,
                         microseconds % 1'000'000);
}

}  // namespace treeline::recording
