#include "nav_agent/calibration/drive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/sample_statistics.h"
#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

// Wheels that rolled by less in the whole drive stood.
constexpr double kStood_m = 0.05;

// A sane geometry of scans.
bool IsSane(const core::RangeSensorInfo& info) {
  return info.beams > 1 && std::isfinite(info.angle_min_rad) &&
         std::isfinite(info.angle_increment_rad) &&
         std::isfinite(info.beam_interval_s) && info.beam_interval_s >= 0 &&
         info.range_max_m > info.range_min_m;
}

double WayOfWheels_m(const std::vector<DriveReading>& readings) {
  double way_m = 0;
  for (size_t i = 1; i < readings.size(); ++i) {
    way_m += 0.5 * (std::abs(readings[i].left_m - readings[i - 1].left_m) +
                    std::abs(readings[i].right_m - readings[i - 1].right_m));
  }
  return way_m;
}

// The usual time from one to the next.
template <typename T>
double MedianInterval_s(const std::vector<T>& measurements) {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < measurements.size(); ++i) {
    intervals_s.push_back(measurements[i].time_s - measurements[i - 1].time_s);
  }
  return base::Quantile(std::move(intervals_s), 0.5);
}

void Note(int64_t count, absl::string_view what,
          std::vector<std::string>& notes) {
  if (count > 0) notes.push_back(absl::StrCat(count, " ", what));
}

}  // namespace

std::optional<double> DriveBuilder::Continued(base::MonotonicTime stamp,
                                              double newest_s) {
  if (!first_) first_ = stamp;
  double time_s =
      std::chrono::duration<double>(stamp - *first_).count() + moved_on_s_;
  if (time_s < newest_s_ - kClockJump_s) {
    // Farther on than any motion may last: none is measured across.
    const double to_s = newest_s_ + 2 * kLongestGap_s;
    moved_on_s_ += to_s - time_s;
    time_s = to_s;
    ++jumps_;
  }
  if (time_s <= newest_s) {
    ++late_;
    return std::nullopt;
  }
  newest_s_ = std::max(newest_s_, time_s);
  return time_s;
}

void DriveBuilder::TakeScan(const core::LaserScan& scan) {
  ++all_scans_;
  if (!IsSane(drive_.laser) ||
      scan.ranges_m.size() != static_cast<size_t>(drive_.laser.beams)) {
    ++other_scans_;
    return;
  }
  const double newest_s =
      drive_.scans.empty() ? -1e300 : drive_.scans.back().time_s;
  const std::optional<double> time_s = Continued(scan.stamp, newest_s);
  if (!time_s || *time_s - newest_s < kScanSpacing_s) return;
  drive_.scans.push_back({*time_s, scan.ranges_m});
}

void DriveBuilder::TakeReading(const core::BaseReading& reading) {
  if (!std::isfinite(reading.left_wheel_m) ||
      !std::isfinite(reading.right_wheel_m)) {
    ++bad_readings_;
    return;
  }
  const double newest_s =
      drive_.readings.empty() ? -1e300 : drive_.readings.back().time_s;
  const std::optional<double> time_s = Continued(reading.stamp, newest_s);
  if (!time_s) return;
  drive_.readings.push_back(
      {*time_s, reading.left_wheel_m, reading.right_wheel_m,
       std::isfinite(reading.yaw_rate_radps) ? reading.yaw_rate_radps : 0});
}

void DriveBuilder::Take(const recording::LogEntry& entry) {
  if (const auto* info = std::get_if<core::RangeSensorInfo>(&entry)) {
    // Scans of another geometry than the first are left out one by one.
    if (drive_.scans.empty()) drive_.laser = *info;
  } else if (const auto* robot = std::get_if<core::RobotModel>(&entry)) {
    if (!drive_.has_robot && robot->Validate().ok()) {
      drive_.robot = *robot;
      drive_.has_robot = true;
    }
  } else if (const auto* scan = std::get_if<core::LaserScan>(&entry)) {
    TakeScan(*scan);
  } else if (const auto* reading = std::get_if<core::BaseReading>(&entry)) {
    TakeReading(*reading);
  }
}

absl::StatusOr<Drive> DriveBuilder::Build() {
  if (all_scans_ == 0) {
    return absl::FailedPreconditionError(
        "the recording has no laser scans; record a drive with the laser on");
  }
  if (drive_.scans.size() < 2) {
    return absl::FailedPreconditionError(absl::StrCat(
        "of ", all_scans_,
        " scans fewer than two can be used: their number of beams is not that "
        "of the laser scanner that the recording describes"));
  }
  if (drive_.readings.size() < 2) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the recording has no odometry (", drive_.readings.size(),
        " wheel readings that can be used, ", bad_readings_,
        " that are not finite): there is nothing to calibrate the laser with; "
        "record the wheels, too"));
  }
  if (WayOfWheels_m(drive_.readings) < kStood_m) {
    return absl::FailedPreconditionError(
        "the wheels did not turn in this recording; drive: straight ahead for "
        "some metres, and turns both ways");
  }
  const double reading_s = MedianInterval_s(drive_.readings);
  drive_.longest_gap_s = std::clamp(
      kUsualGaps * std::max(reading_s, MedianInterval_s(drive_.scans)),
      kLongestGap_s.value, kLongestWait_s.value);
  drive_.shows_delay = reading_s <= kDelayInterval_s;
  if (jumps_ == 0) drive_.begin = first_;
  Note(other_scans_, "scans with another number of beams were left out",
       drive_.notes);
  Note(bad_readings_, "wheel readings that are not finite were left out",
       drive_.notes);
  Note(late_, "measurements are not newer than the one before: left out",
       drive_.notes);
  Note(jumps_, "times the clock jumped back; nothing is measured across",
       drive_.notes);
  return std::move(drive_);
}

}  // namespace treeline::calibration
