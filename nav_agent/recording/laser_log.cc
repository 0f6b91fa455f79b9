#include "nav_agent/recording/laser_log.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_lines.h"
#include "nav_agent/recording/gunzip.h"
#include "nav_agent/recording/laser_log_json.h"
#include "nav_agent/recording/log_builder.h"

namespace treeline::recording {
namespace {

using Words = std::vector<absl::string_view>;

// The words of one line, taken from the left, with errors that say where.
class LineReader {
 public:
  LineReader(const std::string& name, int line,
             std::span<const absl::string_view> words)
      : name_(name), line_(line), words_(words) {}

  absl::Status Error(absl::string_view what) const {
    return dataset::LineError(name_, line_, what);
  }
  absl::Status Need(size_t count) const {
    if (words_.size() >= count) return absl::OkStatus();
    return Error(absl::StrCat("the line ends too early: ", words_.size(),
                              " words where at least ", count, " belong"));
  }
  absl::Status Numbers(std::span<double> numbers) {
    TL_RETURN_IF_ERROR(Need(numbers.size()));
    TL_RETURN_IF_ERROR(dataset::ParseNumbers(words_, name_, line_, numbers));
    words_ = words_.subspan(numbers.size());
    return absl::OkStatus();
  }
  absl::StatusOr<geometry::Rigid2> Pose(double unit_m) {
    double numbers[3] = {};
    TL_RETURN_IF_ERROR(Numbers(numbers));
    return geometry::Rigid2{{numbers[0] * unit_m, numbers[1] * unit_m},
                            numbers[2]};
  }
  absl::StatusOr<int> Count() {
    TL_RETURN_IF_ERROR(Need(1));
    int count = 0;
    if (!absl::SimpleAtoi(words_[0], &count) || count < 0 ||
        count > kMaxLogBeams) {
      return Error(absl::StrCat("a number of beams from 0 to ", kMaxLogBeams,
                                " belongs here"));
    }
    words_ = words_.subspan(1);
    return count;
  }
  absl::StatusOr<std::vector<float>> Ranges(int count, double unit_m) {
    std::vector<double> numbers(static_cast<size_t>(count));
    TL_RETURN_IF_ERROR(Numbers(numbers));
    std::vector<float> ranges_m(numbers.size());
    for (size_t i = 0; i < numbers.size(); ++i) {
      ranges_m[i] = static_cast<float>(numbers[i] * unit_m);
    }
    return ranges_m;
  }
  absl::StatusOr<RecordingTime> Stamp() {
    TL_RETURN_IF_ERROR(Need(1));
    const auto stamp = ParseRecordingTime(words_[0]);
    if (!stamp.has_value()) return Error("no time stamp in seconds");
    words_ = words_.subspan(1);
    return *stamp;
  }
  size_t left() const { return words_.size(); }

 private:
  const std::string& name_;
  const int line_;
  std::span<const absl::string_view> words_;
};

// FLASER count [ranges] x y theta odom_x odom_y odom_theta stamp host logged
absl::Status AddFrontLaser(int line, LineReader reader, LogBuilder* builder) {
  TL_ASSIGN_OR_RETURN(const int count, reader.Count());
  TL_ASSIGN_OR_RETURN(std::vector<float> ranges_m, reader.Ranges(count, 1.0));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_laser, reader.Pose(1.0));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_base, reader.Pose(1.0));
  TL_ASSIGN_OR_RETURN(const RecordingTime stamp, reader.Stamp());
  builder->AddMount(odom_from_base.Inverse() * odom_from_laser);
  return builder->AddScan(line, stamp, odom_from_base, SickGeometry(count),
                          std::move(ranges_m));
}

// ROBOTLASER1 type start fov resolution max_range accuracy remission_mode
// count [ranges] remissions [...] laser pose, robot pose, tv rv forward side
// turn_axis stamp host logged
absl::Status AddRobotLaser(int line, LineReader reader, LogBuilder* builder) {
  double head[7] = {};
  TL_RETURN_IF_ERROR(reader.Numbers(head));
  TL_ASSIGN_OR_RETURN(const int count, reader.Count());
  TL_ASSIGN_OR_RETURN(std::vector<float> ranges_m, reader.Ranges(count, 1.0));
  TL_ASSIGN_OR_RETURN(const int remissions, reader.Count());
  TL_RETURN_IF_ERROR(reader.Ranges(remissions, 1.0).status());
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_laser, reader.Pose(1.0));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_base, reader.Pose(1.0));
  double motion[5] = {};
  TL_RETURN_IF_ERROR(reader.Numbers(motion));
  TL_ASSIGN_OR_RETURN(const RecordingTime stamp, reader.Stamp());
  const double max_range_m = head[4];
  if (max_range_m > 0) {
    for (float& range_m : ranges_m) {
      if (range_m >= static_cast<float>(max_range_m)) range_m = core::kNoReturn;
    }
  }
  if (!(std::abs(head[1]) <= 2 * std::numbers::pi) || !(head[3] > 0) ||
      head[3] * std::max(0, count - 1) > 2.001 * std::numbers::pi) {
    return reader.Error("start angle or resolution is not one of a scanner");
  }
  builder->AddMount(odom_from_base.Inverse() * odom_from_laser);
  return builder->AddScan(line, stamp, odom_from_base,
                          {.angle_min_rad = head[1],
                           .angle_increment_rad = head[3],
                           .beams = count},
                          std::move(ranges_m));
}

// ODOM x y theta tv rv accel stamp host logged
absl::Status AddOdometryLine(int line, LineReader reader, LogBuilder* builder) {
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_base, reader.Pose(1.0));
  double motion[3] = {};
  TL_RETURN_IF_ERROR(reader.Numbers(motion));
  TL_ASSIGN_OR_RETURN(const RecordingTime stamp, reader.Stamp());
  return builder->AddOdometry(line, stamp, odom_from_base);
}

// L x y theta xl yl thetal ranges... stamp, or O x y theta stamp; cm and rad.
absl::Status AddWeanLine(int line, bool has_scan, LineReader reader,
                         LogBuilder* builder) {
  constexpr double kMetresPerCentimetre = 0.01;
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_base,
                      reader.Pose(kMetresPerCentimetre));
  if (!has_scan) {
    TL_ASSIGN_OR_RETURN(const RecordingTime stamp, reader.Stamp());
    if (reader.left() > 0) return reader.Error("an O line with too many words");
    return builder->AddOdometry(line, stamp, odom_from_base);
  }
  TL_ASSIGN_OR_RETURN(const geometry::Rigid2 odom_from_laser,
                      reader.Pose(kMetresPerCentimetre));
  if (reader.left() < 2 ||
      reader.left() - 1 > static_cast<size_t>(kMaxLogBeams)) {
    return reader.Error("an L line without ranges, or with too many");
  }
  const int count = static_cast<int>(reader.left()) - 1;
  TL_ASSIGN_OR_RETURN(std::vector<float> ranges_m,
                      reader.Ranges(count, kMetresPerCentimetre));
  TL_ASSIGN_OR_RETURN(const RecordingTime stamp, reader.Stamp());
  builder->AddMount(odom_from_base.Inverse() * odom_from_laser);
  return builder->AddScan(line, stamp, odom_from_base, SickGeometry(count),
                          std::move(ranges_m));
}

absl::Status AddLine(const std::string& name, int line, const Words& words,
                     LogBuilder* builder) {
  const absl::string_view kind = words[0];
  const LineReader reader(name, line,
                          std::span<const absl::string_view>(words).subspan(1));
  if (kind == "FLASER") return AddFrontLaser(line, reader, builder);
  if (kind == "ROBOTLASER1") return AddRobotLaser(line, reader, builder);
  if (kind == "ODOM") return AddOdometryLine(line, reader, builder);
  if (kind == "O" || kind == "L") {
    return AddWeanLine(line, kind == "L", reader, builder);
  }
  return absl::OkStatus();
}

absl::StatusOr<LaserLog> ParseLines(absl::string_view text,
                                    const std::string& name,
                                    const LaserLogOptions& options) {
  LogBuilder builder(name, options);
  int line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    // Most lines of some logs are of other kinds: not worth splitting.
    const absl::string_view start = absl::StripLeadingAsciiWhitespace(line);
    if (start.empty() || !absl::StrContains("FROL", start.substr(0, 1))) {
      continue;
    }
    const Words words =
        absl::StrSplit(start, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty()) continue;
    TL_RETURN_IF_ERROR(AddLine(name, line_number, words, &builder));
  }
  return builder.Build();
}

}  // namespace

absl::Status LaserLogOptions::Validate() const {
  if (!(range_min_m >= 0) || !(range_max_m > range_min_m) ||
      !std::isfinite(range_max_m)) {
    return absl::InvalidArgumentError(
        "range_max_m must be above range_min_m, which must be 0 or more");
  }
  if (!(reorder_s >= 0)) {
    return absl::InvalidArgumentError("reorder_s must be 0 or more");
  }
  return absl::OkStatus();
}

absl::StatusOr<LaserLog> ParseLaserLog(absl::string_view bytes,
                                       const std::string& name,
                                       const LaserLogOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::string unpacked;
  if (IsGzip(bytes)) {
    auto plain = Gunzip(bytes, kMaxLogBytes);
    if (!plain.ok()) return base::Annotate(plain.status(), name);
    unpacked = *std::move(plain);
    bytes = unpacked;
  }
  const absl::string_view start = absl::StripLeadingAsciiWhitespace(bytes);
  if (start.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, ": empty; whatever recorded it wrote nothing, or is not done"));
  }
  if (absl::StartsWith(start, "{")) {
    return ParseLaserLogJson(bytes, name, options);
  }
  return ParseLines(bytes, name, options);
}

absl::StatusOr<LaserLog> ReadLaserLog(const std::string& path,
                                      const LaserLogOptions& options) {
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      base::ReadFile(path, kMaxLogBytes));
  return ParseLaserLog(bytes, path, options);
}

std::string FormatCarmenLog(const LaserLog& log) {
  const auto pose = [](const geometry::Rigid2& p) {
    return absl::StrFormat("%.9g %.9g %.9g", p.translation.x, p.translation.y,
                           p.yaw_rad);
  };
  std::string text = "# CARMEN log, as Treeline writes it\n";
  size_t reading = 0;
  const auto add_odometry_until = [&](RecordingTime stamp, bool all) {
    for (; reading < log.odometry.size() &&
           (all || log.odometry[reading].stamp < stamp);
         ++reading) {
      const RecordedOdometry& odometry = log.odometry[reading];
      const std::string time = FormatRecordingTime(odometry.stamp);
      absl::StrAppend(&text, "ODOM ", pose(odometry.odom_from_base), " 0 0 0 ",
                      time, " treeline ", time, "\n");
    }
  };
  for (const RecordedScan& scan : log.scans) {
    add_odometry_until(scan.stamp, false);
    absl::StrAppendFormat(
        &text, "ROBOTLASER1 0 %.9g %.9g %.9g %.9g 0.01 0 %d",
        log.laser.angle_min_rad,
        log.laser.angle_increment_rad * std::max(0, log.laser.beams - 1),
        log.laser.angle_increment_rad, log.laser.range_max_m, log.laser.beams);
    for (const float range_m : scan.ranges_m) {
      const bool none = range_m == core::kNoReturn;
      absl::StrAppendFormat(&text, " %.6g",
                            none                     ? log.laser.range_max_m
                            : std::isfinite(range_m) ? range_m
                                                     : 0.0);
    }
    const std::string time = FormatRecordingTime(scan.stamp);
    absl::StrAppend(&text, " 0 ",
                    pose(scan.odom_from_base * log.base_from_laser), " ",
                    pose(scan.odom_from_base), " 0 0 0 0 0 ", time,
                    " treeline ", time, "\n");
  }
  add_odometry_until({}, true);
  return text;
}

}  // namespace treeline::recording
