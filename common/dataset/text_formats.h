// The text files of recorded sequences. Every error is INVALID_ARGUMENT and
// names `file`, the line, and what was expected there. A '#' starts a comment;
// empty lines and carriage returns are ignored.
#ifndef COMMON_DATASET_TEXT_FORMATS_H_
#define COMMON_DATASET_TEXT_FORMATS_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid3.h"

namespace treeline::dataset {

// Time stamps are whole nanoseconds: a double cannot hold those of this epoch.
using Time_ns = int64_t;

// "1305031241.529758" -> 1305031241529758000. Digits beyond the ninth decimal
// are dropped. "1.305031241529758e+09" is the same time, to the microsecond.
// INVALID_ARGUMENT for anything else, and for times beyond the year 2262.
absl::StatusOr<Time_ns> ParseTime_ns(absl::string_view text);

// One stem a line.
struct ListedStem {
  std::string stem;
  int line = 0;
};
// A stem may have blanks inside, and a '#' that follows none: photographs have
// such names. Also errors: an empty list, a stem that is listed twice or leads
// out of the data set ("../x", "/x").
absl::StatusOr<std::vector<ListedStem>> ParseFrameList(absl::string_view text,
                                                       const std::string& file);

// "stem qw qx qy qz tx ty tz [f]": camera_from_world of the colour camera, and
// its focal length (px). A stem may carry the ending of its picture
// (".color.png"), as published files have it.
struct StemPose {
  std::string stem;
  geometry::Rigid3 world_from_camera;
  std::optional<double> focal_length_px;
};
absl::StatusOr<std::vector<StemPose>> ParseStemPoses(absl::string_view text,
                                                     const std::string& file);

// Four lines of four numbers: world_from_camera (7-Scenes).
absl::StatusOr<geometry::Rigid3> ParsePoseMatrix(absl::string_view text,
                                                 const std::string& file);
std::string FormatPoseMatrix(const geometry::Rigid3& world_from_camera);

// "timestamp path": rgb.txt and depth.txt (TUM). In order of time; no two at
// the same time.
struct TimedFile {
  Time_ns time = 0;
  std::string stem;  // the time stamp as it is written
  std::string path;  // relative to the sequence
  int line = 0;
};
absl::StatusOr<std::vector<TimedFile>> ParseTimedFiles(absl::string_view text,
                                                       const std::string& file);

// "timestamp tx ty tz qx qy qz qw": world_from_camera (TUM). In order of time.
struct TimedPose {
  Time_ns time = 0;
  geometry::Rigid3 world_from_camera;
};
absl::StatusOr<std::vector<TimedPose>> ParseTimedPoses(absl::string_view text,
                                                       const std::string& file);
// The inverse: a line for each pose, after a comment; w >= 0. Times, of 0 or
// later, are exact to the nanosecond.
std::string FormatTimedPoses(std::span<const TimedPose> poses);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_TEXT_FORMATS_H_
