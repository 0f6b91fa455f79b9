#include "nav_agent/bridge/robot_ports/laser_port.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/bridge/agent_values/laser_values.h"

namespace treeline::robot_ports {
namespace {

// Fewer tell nothing of a place.
constexpr int kFewestBeams = 3;
// A turn, with room for rounding and for the beam that is there twice.
constexpr double kLargestSpan_rad = 6.9;

struct Measured {
  core::RangeSensorInfo info;
  core::LaserScan scan;
};

// Angles of `measured` run counter-clockwise afterwards. The last beam becomes
// the first: then the moment of the scan is its middle, and of all beams.
void TurnRound(Measured& measured) {
  core::RangeSensorInfo& info = measured.info;
  info.angle_min_rad = info.AngleOf_rad(info.beams - 1);
  info.angle_increment_rad = -info.angle_increment_rad;
  std::ranges::reverse(measured.scan.ranges_m);
  std::ranges::reverse(measured.scan.intensities);
  measured.scan.stamp +=
      std::chrono::duration_cast<base::MonotonicTime::duration>(
          std::chrono::duration<double>(info.beam_interval_s *
                                        (info.beams - 1) / 2));
  info.beam_interval_s = 0;
}

void TurnUpsideUp(Measured& measured) {
  measured.info.angle_min_rad = -measured.info.angle_min_rad;
  measured.info.angle_increment_rad = -measured.info.angle_increment_rad;
}

// Each beam of `wanted` gets what the nearest one measured, if one is nearer
// than half of the distance between beams, or a little more.
core::LaserScan WithBeamsOf(const core::RangeSensorInfo& wanted,
                            const Measured& measured) {
  constexpr double kNearEnough = 0.75;
  const core::RangeSensorInfo& info = measured.info;
  const double near_rad = kNearEnough * std::max(info.angle_increment_rad,
                                                 wanted.angle_increment_rad);
  const bool has_intensities = !measured.scan.intensities.empty();
  core::LaserScan scan = {
      .stamp = measured.scan.stamp, .ranges_m = {}, .intensities = {}};
  for (int i = 0; i < wanted.beams; ++i) {
    const double angle_rad = wanted.AngleOf_rad(i);
    const double place = std::clamp(
        std::round((angle_rad - info.angle_min_rad) / info.angle_increment_rad),
        0.0, static_cast<double>(info.beams - 1));
    const int beam = static_cast<int>(place);
    const bool is_near =
        std::abs(info.AngleOf_rad(beam) - angle_rad) <= near_rad;
    const auto at = static_cast<size_t>(beam);
    scan.ranges_m.push_back(is_near ? measured.scan.ranges_m[at]
                                    : core::kInvalidRange);
    if (has_intensities) {
      scan.intensities.push_back(is_near ? measured.scan.intensities[at]
                                         : uint16_t{0});
    }
  }
  return scan;
}

bool HasSameBeams(const core::RangeSensorInfo& a,
                  const core::RangeSensorInfo& b) {
  return a.beams == b.beams &&
         std::abs(a.angle_min_rad - b.angle_min_rad) < 1e-4 &&
         std::abs(a.angle_increment_rad - b.angle_increment_rad) * a.beams <
             1e-3;
}

absl::StatusOr<core::RangeSensorInfo> GoodInfoOf(
    const messages::LaserScan& message) {
  TL_ASSIGN_OR_RETURN(core::RangeSensorInfo info,
                      agent_values::SensorInfoOf(message));
  const double span_rad = std::abs(info.angle_increment_rad) * (info.beams - 1);
  if (info.beams < kFewestBeams || !(span_rad <= kLargestSpan_rad) ||
      !(std::abs(info.angle_min_rad) <= kLargestSpan_rad)) {
    return absl::InvalidArgumentError(
        absl::StrCat("scan of ", info.beams, " beams from ", info.angle_min_rad,
                     " rad over ", span_rad, " rad: that is no laser"));
  }
  // Many drivers leave it out, or write what is not so.
  if (!(info.scan_interval_s > 0 && info.scan_interval_s < 10)) {
    info.scan_interval_s = 0;
  }
  return info;
}

}  // namespace

absl::Status LaserPort::Add(const messages::LaserScan& message) {
  absl::StatusOr<core::RangeSensorInfo> info = GoodInfoOf(message);
  const absl::Status stamped = time_.CheckStamp(message.header.stamp);
  const absl::MutexLock lock(&mutex_);
  if (!info.ok()) return health_.NoteBroken(info.status());
  if (!stamped.ok()) return health_.NoteBroken(stamped);
  Measured measured = {.info = *info, .scan = agent_values::ScanOf(message)};
  measured.scan.stamp = time_.TimeOf(message.header.stamp);
  if (is_upside_down_) TurnUpsideUp(measured);
  if (measured.info.angle_increment_rad < 0) TurnRound(measured);
  if (!info_.has_value()) info_ = measured.info;
  frame_id_ = message.header.frame_id;
  health_.NoteGood(real_clock_.Now());
  waiting_.Add(HasSameBeams(*info_, measured.info)
                   ? std::move(measured.scan)
                   : WithBeamsOf(*info_, measured),
               health_);
  return absl::OkStatus();
}

void LaserPort::SetUpsideDown() {
  const absl::MutexLock lock(&mutex_);
  if (is_upside_down_) return;
  is_upside_down_ = true;
  info_.reset();
  waiting_.Take();
}

std::string LaserPort::frame_id() const {
  const absl::MutexLock lock(&mutex_);
  return frame_id_;
}

core::RangeSensorInfo LaserPort::Info() const {
  const absl::MutexLock lock(&mutex_);
  return info_.value_or(core::RangeSensorInfo());
}

std::vector<core::LaserScan> LaserPort::TakeScans() {
  const absl::MutexLock lock(&mutex_);
  return waiting_.Take();
}

core::DeviceHealth LaserPort::Health() const {
  const absl::MutexLock lock(&mutex_);
  return health_.At(real_clock_.Now());
}

}  // namespace treeline::robot_ports
