#include "nav_agent/calibration/wheel_path.h"

#include <algorithm>
#include <cmath>

namespace treeline::calibration {
namespace {

// As core::SlopeOdometryOptions: faster wheels were not turned but reset.
constexpr double kMaxSpeed_mps = 3.0;
constexpr double kJump_m = 0.05;
// The yaw rate of wheels and of a gyroscope differ by noise and bias (rad/s).
constexpr double kSameRate_radps = 1e-3;

geometry::Rigid2 Arc(double left_m, double right_m, const Wheels& wheels) {
  const double l = wheels.left_scale * left_m;
  const double r = wheels.right_scale * right_m;
  const double turn_rad = (r - l) / wheels.track_m;
  const double half_rad = turn_rad / 2;
  const double way_m = (l + r) / 2;
  const double chord_m =
      std::abs(half_rad) < 1e-6 ? way_m : way_m * std::sin(half_rad) / half_rad;
  return {{chord_m * std::cos(half_rad), chord_m * std::sin(half_rad)},
          turn_rad};
}

}  // namespace

WheelPath::WheelPath(std::span<const DriveReading> readings,
                     double longest_gap_s)
    : readings_(readings) {
  int breaks = 0;
  double way_m = 0;
  double turn_rad = 0;
  for (size_t i = 0; i < readings.size(); ++i) {
    if (i > 0) {
      const DriveReading& a = readings[i - 1];
      const DriveReading& b = readings[i];
      const double interval_s = b.time_s - a.time_s;
      const double max_m = kMaxSpeed_mps * interval_s + kJump_m;
      const double left_m = std::abs(b.left_m - a.left_m);
      const double right_m = std::abs(b.right_m - a.right_m);
      const bool is_broken =
          interval_s > longest_gap_s || left_m > max_m || right_m > max_m;
      if (is_broken) {
        ++breaks;
      } else {
        way_m += 0.5 * (left_m + right_m);
      }
      turn_rad += 0.5 * (a.yaw_rate_radps + b.yaw_rate_radps) * interval_s;
    }
    breaks_.push_back(breaks);
    ways_m_.push_back(way_m);
    turns_rad_.push_back(turn_rad);
  }
}

long WheelPath::Before(double time_s) const {
  const auto after = std::upper_bound(
      readings_.begin(), readings_.end(), time_s,
      [](double t, const DriveReading& r) { return t < r.time_s; });
  return after - readings_.begin() - 1;
}

bool WheelPath::IsCovered(double begin_s, double end_s) const {
  if (readings_.empty() || begin_s < readings_.front().time_s ||
      end_s > readings_.back().time_s || end_s < begin_s) {
    return false;
  }
  const auto first = static_cast<size_t>(Before(begin_s));
  const auto last =
      std::min(static_cast<size_t>(Before(end_s)) + 1, readings_.size() - 1);
  return breaks_[first] == breaks_[last];
}

std::optional<geometry::Rigid2> WheelPath::Motion(double begin_s, double end_s,
                                                  const Wheels& wheels) const {
  if (!IsCovered(begin_s, end_s)) return std::nullopt;
  geometry::Rigid2 begin_from_now;
  double now_s = begin_s;
  for (auto i = static_cast<size_t>(Before(begin_s));
       i + 1 < readings_.size() && now_s < end_s; ++i) {
    const DriveReading& a = readings_[i];
    const DriveReading& b = readings_[i + 1];
    const double next_s = std::min(end_s, b.time_s);
    const double share = (next_s - now_s) / (b.time_s - a.time_s);
    begin_from_now =
        begin_from_now * Arc(share * (b.left_m - a.left_m),
                             share * (b.right_m - a.right_m), wheels);
    now_s = next_s;
  }
  return begin_from_now;
}

double WheelPath::Way_m(double begin_s, double end_s) const {
  const auto at = [this](double time_s) {
    const long before = std::max(0l, Before(time_s));
    const auto i = static_cast<size_t>(before);
    if (i + 1 >= readings_.size()) return ways_m_.back();
    const double share =
        std::clamp((time_s - readings_[i].time_s) /
                       (readings_[i + 1].time_s - readings_[i].time_s),
                   0.0, 1.0);
    return ways_m_[i] + share * (ways_m_[i + 1] - ways_m_[i]);
  };
  return readings_.empty() ? 0 : at(end_s) - at(begin_s);
}

std::optional<double> WheelPath::GyroscopeTurn_rad(double begin_s,
                                                   double end_s) const {
  if (!IsCovered(begin_s, end_s)) return std::nullopt;
  const auto at = [this](double time_s) {
    const auto i = static_cast<size_t>(Before(time_s));
    if (i + 1 >= readings_.size()) return turns_rad_.back();
    const double share = (time_s - readings_[i].time_s) /
                         (readings_[i + 1].time_s - readings_[i].time_s);
    return turns_rad_[i] + share * (turns_rad_[i + 1] - turns_rad_[i]);
  };
  return at(end_s) - at(begin_s);
}

bool WheelPath::HasGyroscope(double track_m) const {
  int differ = 0;
  int steps = 0;
  for (size_t i = 1; i < readings_.size(); ++i) {
    const DriveReading& a = readings_[i - 1];
    const DriveReading& b = readings_[i];
    if (breaks_[i] != breaks_[i - 1] || b.yaw_rate_radps == 0) continue;
    const double wheels_radps =
        ((b.right_m - a.right_m) - (b.left_m - a.left_m)) /
        (track_m * (b.time_s - a.time_s));
    ++steps;
    if (std::abs(wheels_radps - b.yaw_rate_radps) > kSameRate_radps) ++differ;
  }
  return steps > 10 && differ > steps / 4;
}

}  // namespace treeline::calibration
