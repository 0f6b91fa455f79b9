#include "nav_agent/recording/log_builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_lines.h"

namespace treeline::recording {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
// Scanners are on the robot; poses in logs are rounded.
constexpr double kMaxMount_m = 2.0;
constexpr double kMountTolerance_m = 0.01;
constexpr double kMountTolerance_rad = 0.01;

// Where a clock has jumped back, it goes on this much later. More jumps than
// this are no clock's.
constexpr std::chrono::milliseconds kAfterJump(100);
constexpr int kMaxJumps = 20;
// What ParseRecordingTime reads; stamps that were moved on stay within it.
constexpr std::chrono::seconds kLatest(9'000'000'000);

bool IsEarlier(const RecordedScan& a, const RecordedScan& b) {
  return a.stamp < b.stamp;
}

bool IsEarlierReading(const RecordedOdometry& a, const RecordedOdometry& b) {
  return a.stamp < b.stamp;
}

}  // namespace

core::RangeSensorInfo SickGeometry(int beams) {
  double increment_deg = 180.0 / std::max(1, beams - 1);
  if (beams == 180 || beams == 181) increment_deg = 1;
  if (beams == 360 || beams == 361) increment_deg = 0.5;
  return {.angle_min_rad = -90 * kRadPerDeg,
          .angle_increment_rad = increment_deg * kRadPerDeg,
          .beams = beams};
}

absl::StatusOr<RecordingTime> LogBuilder::Continued(int line,
                                                    RecordingTime stamp,
                                                    RecordingTime* newest,
                                                    bool first) {
  if (stamp.time_since_epoch() > kLatest - moved_on_) {
    return dataset::LineError(name_, line,
                              "the clock has jumped too far to be continued");
  }
  const RecordingTime moved = stamp + moved_on_;
  if (first) {
    *newest = moved;
    return moved;
  }
  const double back_s = SecondsBetween(moved, *newest);
  if (back_s <= options_.reorder_s) {
    *newest = std::max(*newest, moved);
    return moved;
  }
  const std::string jump =
      absl::StrFormat("the clock jumps back by %.3f s, from %s to %s", back_s,
                      FormatRecordingTime(*newest), FormatRecordingTime(moved));
  if (++jumps_ > kMaxJumps) {
    return dataset::LineError(
        name_, line,
        absl::StrCat(jump, ", after ", kMaxJumps,
                     " such jumps: its lines are not in the order of time"));
  }
  log_.warnings.push_back(absl::StrCat(
      std::string(dataset::LineError(name_, line, jump).message()),
      "; later stamps are moved on by as much, and the way in between is "
      "odometry's"));
  moved_on_ += *newest - moved + kAfterJump;
  *newest = stamp + moved_on_;
  return *newest;
}

absl::Status LogBuilder::AddScan(int line, RecordingTime stamp,
                                 const geometry::Rigid2& odom_from_base,
                                 const core::RangeSensorInfo& laser,
                                 std::vector<float> ranges_m) {
  if (ranges_m.empty())
    return dataset::LineError(name_, line, "a scan without beams");
  if (log_.scans.empty()) {
    log_.laser = laser;
    log_.laser.range_min_m = options_.range_min_m;
    log_.laser.range_max_m = options_.range_max_m;
  }
  if (laser.beams != log_.laser.beams ||
      static_cast<int>(ranges_m.size()) != log_.laser.beams) {
    return dataset::LineError(
        name_, line,
        absl::StrCat("a scan of ", ranges_m.size(), " beams, after scans of ",
                     log_.laser.beams));
  }
  if (std::abs(laser.angle_min_rad - log_.laser.angle_min_rad) > 1e-5 ||
      std::abs(laser.angle_increment_rad - log_.laser.angle_increment_rad) >
          1e-7) {
    return dataset::LineError(name_, line,
                              "a scan with other angles than those before");
  }
  for (float& range_m : ranges_m) {
    if (range_m >= static_cast<float>(options_.range_max_m)) {
      range_m = core::kNoReturn;
    } else if (!(range_m > static_cast<float>(options_.range_min_m))) {
      range_m = core::kInvalidRange;
    }
  }
  TL_ASSIGN_OR_RETURN(
      stamp, Continued(line, stamp, &newest_scan_, log_.scans.empty()));
  log_.scans.push_back({.stamp = stamp,
                        .odom_from_base = odom_from_base,
                        .ranges_m = std::move(ranges_m)});
  return absl::OkStatus();
}

absl::Status LogBuilder::AddOdometry(int line, RecordingTime stamp,
                                     const geometry::Rigid2& odom_from_base) {
  TL_ASSIGN_OR_RETURN(
      stamp, Continued(line, stamp, &newest_odometry_, log_.odometry.empty()));
  log_.odometry.push_back({.stamp = stamp, .odom_from_base = odom_from_base});
  return absl::OkStatus();
}

geometry::Rigid2 LogBuilder::CommonMount() const {
  if (mounts_.empty()) return {};
  const geometry::Rigid2& first = mounts_.front();
  for (const geometry::Rigid2& mount : mounts_) {
    const bool same =
        geometry::Norm(mount.translation - first.translation) <=
            kMountTolerance_m &&
        std::abs(geometry::NormalizedAngle_rad(
            mount.yaw_rad - first.yaw_rad)) <= kMountTolerance_rad;
    if (!same || geometry::Norm(mount.translation) > kMaxMount_m) return {};
  }
  return first;
}

absl::StatusOr<LaserLog> LogBuilder::Build() {
  if (log_.scans.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(name_,
                     ": no laser scans: neither JSON of scans, nor FLASER, "
                     "ROBOTLASER1 or L lines"));
  }
  std::stable_sort(log_.scans.begin(), log_.scans.end(), IsEarlier);
  std::stable_sort(log_.odometry.begin(), log_.odometry.end(),
                   IsEarlierReading);
  log_.base_from_laser = CommonMount();
  if (log_.scans.size() > 1) {
    std::vector<double> intervals_s;
    for (size_t i = 1; i < log_.scans.size(); ++i) {
      intervals_s.push_back(
          SecondsBetween(log_.scans[i - 1].stamp, log_.scans[i].stamp));
    }
    const auto middle =
        intervals_s.begin() + static_cast<ptrdiff_t>(intervals_s.size() / 2);
    std::nth_element(intervals_s.begin(), middle, intervals_s.end());
    log_.laser.scan_interval_s = *middle;
  }
  return std::move(log_);
}

}  // namespace treeline::recording
