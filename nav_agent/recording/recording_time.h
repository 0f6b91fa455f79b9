// Moments in a recording.
#ifndef NAV_AGENT_RECORDING_RECORDING_TIME_H_
#define NAV_AGENT_RECORDING_RECORDING_TIME_H_

#include <chrono>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::recording {

// Since the recording's own epoch: that of Unix where the recorder knew the
// date, or when it was switched on.
using RecordingTime = std::chrono::sys_time<std::chrono::nanoseconds>;

// "976052890.244111": seconds, digits with at most one point, at most 9e9.
// Exact to the nanosecond; what is finer is cut off. Nothing for other text.
std::optional<RecordingTime> ParseRecordingTime(absl::string_view text);

// Seconds with six digits after the point.
std::string FormatRecordingTime(RecordingTime time);

// From `earlier` to `later` (s).
inline double SecondsBetween(RecordingTime earlier, RecordingTime later) {
  return std::chrono::duration<double>(later - earlier).count();
}

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_RECORDING_TIME_H_
