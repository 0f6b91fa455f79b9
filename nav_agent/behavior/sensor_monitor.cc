#include "nav_agent/behavior/sensor_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/control/scan_age.h"

namespace treeline::behavior {
namespace {

bool IsFinite(const core::BaseReading& reading) {
  for (const double value :
       {reading.left_wheel_m, reading.right_wheel_m, reading.forward_mps,
        reading.yaw_rate_radps, reading.pitch_rad, reading.roll_rad}) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

bool SameValues(const core::BaseReading& a, const core::BaseReading& b) {
  return a.left_wheel_m == b.left_wheel_m &&
         a.right_wheel_m == b.right_wheel_m && a.forward_mps == b.forward_mps &&
         a.yaw_rate_radps == b.yaw_rate_radps && a.pitch_rad == b.pitch_rad &&
         a.roll_rad == b.roll_rad;
}

// Slower wheels may repeat themselves.
bool Stands(double forward_mps, double yaw_rate_radps) {
  return std::abs(forward_mps) <= control::kStandingSpeed_mps &&
         std::abs(yaw_rate_radps) <= control::kStandingTurn_radps;
}

// Bit by bit: NaN is the same as NaN.
bool SameRanges(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// The share of beams that tell something: a range, or that there is none.
double ShareOfRanges(const std::vector<float>& ranges_m) {
  if (ranges_m.empty()) return 0;
  const auto count = std::ranges::count_if(
      ranges_m, [](float range_m) { return !std::isnan(range_m); });
  return static_cast<double>(count) / static_cast<double>(ranges_m.size());
}

bool HasRange(const std::vector<float>& ranges_m) {
  return std::ranges::any_of(
      ranges_m, [](float range_m) { return std::isfinite(range_m); });
}

std::string Silence(const char* device, double silent_s,
                    const SensorTally& tally, const SensorTally& before) {
  std::string text = absl::StrFormat("nothing usable from the %s for %.2f s",
                                     device, silent_s);
  const auto add = [&text](int64_t now, int64_t then, const char* what) {
    if (now > then) absl::StrAppend(&text, ", ", now - then, " ", what);
  };
  add(tally.late, before.late, "came too late");
  add(tally.future, before.future, "are stamped in the future");
  add(tally.out_of_order, before.out_of_order, "out of order");
  add(tally.broken, before.broken, "broken");
  return text;
}

}  // namespace

double SameAgain::For_s(base::MonotonicTime stamp) const {
  return since_.has_value() ? base::SecondsBetween(*since_, stamp) : 0;
}

bool AcceptStamp(base::MonotonicTime stamp, base::MonotonicTime now,
                 double timeout_s, const SensorMonitorOptions& options,
                 std::optional<base::MonotonicTime> newest,
                 SensorTally& tally) {
  if (base::SecondsBetween(now, stamp) > options.future_s) {
    ++tally.future;
    return false;
  }
  if (base::SecondsBetween(stamp, now) > timeout_s) {
    ++tally.late;
    return false;
  }
  if (newest.has_value() && stamp <= *newest) {
    ++tally.out_of_order;
    return false;
  }
  return true;
}

double LaserWatch::Timeout_s() const {
  constexpr double kLongest_s = 5;
  return std::max(options_->laser_timeout_s,
                  std::min(control::OldestScan_s(laser_->Info()), kLongest_s));
}

void LaserWatch::Poll(base::MonotonicTime now, double moved) {
  scans_.clear();
  moved_ += moved;
  const int beams = laser_->Info().beams;
  for (core::LaserScan& scan : laser_->TakeScans()) {
    if (static_cast<int>(scan.ranges_m.size()) != beams ||
        ShareOfRanges(scan.ranges_m) < options_->min_range_share) {
      ++tally_.broken;
      continue;
    }
    if (!AcceptStamp(scan.stamp, now, Timeout_s(), *options_, stamp_, tally_)) {
      continue;
    }
    Judge(scan);
    stamp_ = scan.stamp;
    ++tally_.used;
    tally_then_ = tally_;
    if (!is_frozen_) scans_.push_back(std::move(scan));
  }
}

void LaserWatch::Judge(const core::LaserScan& scan) {
  const bool is_same =
      HasRange(scan.ranges_m) && SameRanges(scan.ranges_m, last_ranges_m_);
  if (!is_same) {
    moved_ = 0;
    is_frozen_ = false;
    last_ranges_m_ = scan.ranges_m;
  }
  tally_.repeated += is_same ? 1 : 0;
  same_ranges_.Add(is_same, scan.stamp);
  if (same_ranges_.For_s(scan.stamp) > Timeout_s() && moved_ > kScanMotion_m) {
    is_frozen_ = true;
  }
}

std::optional<std::string> LaserWatch::Problem(base::MonotonicTime begun,
                                               base::MonotonicTime now) const {
  const core::DeviceHealth health = laser_->Health();
  if (health.state == core::DeviceState::kLost) {
    return absl::StrCat("the ", name_, " is lost: ", health.cause.message());
  }
  const double silent_s = base::SecondsBetween(stamp_.value_or(begun), now);
  if (silent_s > Timeout_s()) {
    return Silence(name_, silent_s, tally_, tally_then_);
  }
  if (is_frozen_) {
    return absl::StrCat("the ", name_,
                        " says the same again and again while the robot moves");
  }
  return std::nullopt;
}

SensorMonitor::SensorMonitor(const NavigatorDevices& devices,
                             const SensorMonitorOptions& options)
    : devices_(devices),
      options_(options),
      laser_("laser", devices.laser, options_) {
  if (devices.rear_laser != nullptr) {
    rear_laser_.emplace("rear laser", *devices.rear_laser, options_);
  }
}

const std::vector<core::LaserScan>& SensorMonitor::rear_scans() const {
  static const std::vector<core::LaserScan> kNone;
  return rear_laser_.has_value() ? rear_laser_->scans() : kNone;
}

void SensorMonitor::Poll(base::MonotonicTime now,
                         const core::VelocityCommand& command) {
  now_ = now;
  if (!begun_.has_value()) begun_ = now;
  PollOdometry(now, command);
  laser_.Poll(now, moved_);
  if (rear_laser_.has_value()) rear_laser_->Poll(now, moved_);
}

void SensorMonitor::PollOdometry(base::MonotonicTime now,
                                 const core::VelocityCommand& command) {
  readings_.clear();
  moved_ = 0;
  for (const core::BaseReading& reading : devices_.odometry.TakeReadings()) {
    if (!IsFinite(reading)) {
      ++odometry_.broken;
      continue;
    }
    if (!AcceptStamp(reading.stamp, now, options_.odometry_timeout_s, options_,
                     odometry_stamp_, odometry_)) {
      continue;
    }
    const bool is_same = reading_.has_value() && SameValues(*reading_, reading);
    const bool should_move =
        !Stands(command.forward_mps, command.yaw_rate_radps) ||
        !Stands(reading.forward_mps, reading.yaw_rate_radps);
    odometry_.repeated += is_same ? 1 : 0;
    same_readings_.Add(is_same && (should_move || odometry_frozen_.has_value()),
                       reading.stamp);
    if (reading_.has_value()) {
      moved_ += std::abs(reading.left_wheel_m - reading_->left_wheel_m) +
                std::abs(reading.right_wheel_m - reading_->right_wheel_m);
    }
    JudgeOdometry(reading, is_same);
    odometry_stamp_ = reading.stamp;
    reading_ = reading;
    ++odometry_.used;
    odometry_then_ = odometry_;
    readings_.push_back(reading);
  }
}

void SensorMonitor::JudgeOdometry(const core::BaseReading& reading,
                                  bool is_same) {
  if (!is_same) {
    odometry_frozen_.reset();
    odometry_retries_ = 0;
    return;
  }
  if (!odometry_frozen_.has_value()) {
    if (same_readings_.For_s(reading.stamp) > options_.frozen_s) {
      odometry_frozen_ = reading.stamp;
    }
    return;
  }
  // It may only have been stuck: a standing robot's readings may be alike.
  const bool says_it_stands =
      Stands(reading.forward_mps, reading.yaw_rate_radps);
  if (says_it_stands && odometry_retries_ < options_.retries &&
      base::SecondsBetween(*odometry_frozen_, reading.stamp) >
          options_.retry_s) {
    ++odometry_retries_;
    odometry_frozen_.reset();
    same_readings_.Restart();
  }
}

std::optional<core::RgbdFrame> SensorMonitor::TakeFrame(
    base::MonotonicTime now) {
  if (devices_.camera == nullptr) return std::nullopt;
  std::optional<core::RgbdFrame> newest;
  for (core::RgbdFrame& frame : devices_.camera->TakeFrames()) {
    // Pictures come late; what uses them asks where the robot was then.
    if (!AcceptStamp(frame.stamp, now, kCameraTimeout_s, options_,
                     camera_stamp_, camera_)) {
      continue;
    }
    camera_stamp_ = frame.stamp;
    ++camera_.used;
    newest = std::move(frame);
  }
  return newest;
}

void SensorMonitor::NoteBaseAnswer(const absl::Status& answer) {
  base_answer_ = answer;
}

std::optional<std::string> SensorMonitor::OdometryProblem() const {
  const core::DeviceHealth health = devices_.odometry.Health();
  if (health.state == core::DeviceState::kLost) {
    return absl::StrCat("the odometry is lost: ", health.cause.message());
  }
  const double silent_s =
      base::SecondsBetween(odometry_stamp_.value_or(*begun_), now_);
  if (silent_s > options_.odometry_timeout_s) {
    return Silence("odometry", silent_s, odometry_, odometry_then_);
  }
  if (odometry_frozen_.has_value()) {
    return "the odometry says the same again and again while the robot is to "
           "move";
  }
  return std::nullopt;
}

std::optional<std::string> SensorMonitor::BaseProblem() const {
  const core::DeviceHealth health = devices_.base.Health();
  if (health.state == core::DeviceState::kLost) {
    return absl::StrCat("the base is lost: ", health.cause.message());
  }
  if (!base_answer_.ok()) {
    return absl::StrCat("the base refuses commands: ", base_answer_.message());
  }
  if (reading_.has_value() && !reading_->motors_enabled) {
    return "the base's motors are off: look at its emergency stop";
  }
  return std::nullopt;
}

std::vector<StopReason> SensorMonitor::Problems() const {
  std::vector<StopReason> problems;
  if (!begun_.has_value()) return problems;
  const auto add = [&problems](core::NavigationCause cause,
                               std::optional<std::string> text) {
    if (text.has_value()) {
      problems.push_back({.cause = cause, .text = *std::move(text)});
    }
  };
  add(core::NavigationCause::kBaseLost, BaseProblem());
  add(core::NavigationCause::kOdometryLost, OdometryProblem());
  add(core::NavigationCause::kLaserLost, laser_.Problem(*begun_, now_));
  if (rear_laser_.has_value()) {
    add(core::NavigationCause::kLaserLost, rear_laser_->Problem(*begun_, now_));
  }
  return problems;
}

}  // namespace treeline::behavior
