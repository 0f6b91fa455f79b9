#include "nav_agent/sim/sensor_suite.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/sim/random_streams.h"

namespace treeline {
namespace {

constexpr SimTime kRemembered = std::chrono::milliseconds(500);

RangeSensorInfo InfoOf(const LaserScannerOptions& laser) {
  return {.angle_min_rad = laser.angle_min_rad,
          .angle_increment_rad = laser.angle_increment_rad,
          .beams = laser.beams,
          .range_min_m = laser.range_min_m,
          .range_max_m = laser.range_max_m,
          .beam_interval_s = laser.beam_interval_s,
          .scan_interval_s = laser.scan_interval_s};
}

absl::Status Silent(const char* device) {
  return absl::UnavailableError(
      absl::StrCat("the ", device, " is silent (simulated fault)"));
}

// What faults do to when a measurement says that it was made, and arrives.
SimTime StampFault(const FaultPlan& faults, FaultTarget target, SimTime time) {
  const Fault* fault = faults.Find(target, FaultKind::kStampOffset, time);
  return fault == nullptr ? SimTime(0) : FromSeconds(fault->amount);
}
SimTime DelayFault(const FaultPlan& faults, FaultTarget target, SimTime time) {
  const Fault* fault = faults.Find(target, FaultKind::kDelay, time);
  return fault == nullptr ? SimTime(0) : FromSeconds(fault->amount);
}

}  // namespace

absl::Status SensorOptions::Validate() const {
  for (const double latency_s :
       {laser_latency_s, odometry_latency_s, camera_latency_s}) {
    if (!(latency_s >= 0 && latency_s <= 10)) {
      return absl::InvalidArgumentError(
          absl::StrCat("a latency of ", latency_s, " s; 0 to 10 is possible"));
    }
  }
  if (!(odometry_hz >= 1 && odometry_hz <= 200)) {
    return absl::InvalidArgumentError(
        absl::StrCat("odometry at ", odometry_hz, " Hz; 1 to 200 is possible"));
  }
  if (!(camera_hz >= 0 && camera_hz <= 60)) {
    return absl::InvalidArgumentError(
        absl::StrCat("a camera at ", camera_hz, " Hz; 0 to 60 is possible"));
  }
  if (!(camera_scale >= 0.1 && camera_scale <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera_scale must be in [0.1, 1], not ", camera_scale));
  }
  return laser.Validate();
}

void PoseHistory::Add(SimTime time, const Rigid3& world_from_base) {
  entries_.push_back({time, world_from_base});
  while (entries_.front().time + kRemembered < time) entries_.pop_front();
}

void PoseHistory::Restart(SimTime time, const Rigid3& world_from_base) {
  entries_.clear();
  entries_.push_back({time, world_from_base});
}

Rigid3 PoseHistory::At(SimTime time) const {
  const auto after = std::partition_point(
      entries_.begin(), entries_.end(),
      [&](const Entry& entry) { return entry.time < time; });
  if (after == entries_.begin()) return entries_.front().world_from_base;
  if (after == entries_.end()) return entries_.back().world_from_base;
  const Entry& a = *(after - 1);
  const Entry& b = *after;
  const double t = Seconds(time - a.time) / Seconds(b.time - a.time);
  const Rigid3& from = a.world_from_base;
  const Rigid3& to = b.world_from_base;
  return {Slerp(from.rotation, to.rotation, t),
          from.translation + t * (to.translation - from.translation)};
}

absl::StatusOr<std::unique_ptr<SensorSuite>> SensorSuite::Create(
    const World& world, const RayCaster& caster, const RobotModel& robot,
    const DriveErrors& errors, const SensorOptions& options, uint64_t seed,
    const SimClock& clock, std::shared_ptr<const Imager> imager) {
  TL_RETURN_IF_ERROR(options.Validate());
  const uint64_t laser_seed = RandomFor(seed, SimRandom::kLaser, 0).NextBits();
  TL_ASSIGN_OR_RETURN(LaserScanner scanner,
                      LaserScanner::Create(world, options.laser, laser_seed));
  return std::unique_ptr<SensorSuite>(
      new SensorSuite(robot, caster, std::move(scanner), errors, options, seed,
                      clock, std::move(imager)));
}

SensorSuite::SensorSuite(const RobotModel& robot, const RayCaster& caster,
                         LaserScanner scanner, const DriveErrors& errors,
                         const SensorOptions& options, uint64_t seed,
                         const SimClock& clock,
                         std::shared_ptr<const Imager> imager)
    : robot_(robot),
      caster_(&caster),
      scanner_(std::move(scanner)),
      inertial_(errors, seed),
      options_(options),
      seed_(seed),
      has_camera_(imager != nullptr && options.camera_hz > 0),
      laser_(clock, InfoOf(options.laser)),
      odometry_(clock),
      camera_(clock, std::move(imager)) {}

void SensorSuite::Restart(const RobotBody& body, SimTime now) {
  history_.Restart(now, body.stance().WorldFromBase());
}

void SensorSuite::MeasureOdometry(const RobotBody& body,
                                  const FaultPlan& faults, SimTime now) {
  constexpr FaultTarget kTarget = FaultTarget::kOdometry;
  BaseReading reading = body.drive().Counters();
  reading.stamp = SimClock::StampOf(now + StampFault(faults, kTarget, now));
  reading.motors_enabled = !body.is_fallen();
  inertial_.Measure(body.stance().pitch_rad, body.stance().roll_rad,
                    body.yaw_rate_radps(), readings_, 1 / options_.odometry_hz,
                    reading);
  if (faults.Has(kTarget, FaultKind::kSilent, now)) {
    odometry_.queue.SetLost(Silent("base"));
    return;
  }
  if (faults.Has(kTarget, FaultKind::kFrozen, now) &&
      last_reading_.has_value()) {
    const MonotonicTime stamp = reading.stamp;
    reading = *last_reading_;
    reading.stamp = stamp;
  }
  last_reading_ = reading;
  odometry_.queue.Push(now + FromSeconds(options_.odometry_latency_s) +
                           DelayFault(faults, kTarget, now),
                       reading);
}

void SensorSuite::ScanOnce(const Stage& stage, const FaultPlan& faults,
                           SimTime first) {
  constexpr FaultTarget kTarget = FaultTarget::kLaser;
  if (faults.Has(kTarget, FaultKind::kSilent, first)) {
    laser_.queue.SetLost(Silent("laser"));
    return;
  }
  const LaserScannerOptions& laser = options_.laser;
  const SimTime last =
      first + FromSeconds((laser.beams - 1) * laser.beam_interval_s);
  LaserScan scan;
  if (faults.Has(kTarget, FaultKind::kFrozen, first) &&
      last_scan_.has_value()) {
    scan = *last_scan_;
  } else {
    const double middle_s = Seconds(first + (last - first) / 2);
    const WorldSnapshot snapshot = caster_->At(stage.InstancesAt(middle_s));
    LaserReturns returns =
        scanner_.Scan(snapshot, history_.At(first) * robot_.base_from_laser,
                      history_.At(last) * robot_.base_from_laser,
                      static_cast<uint64_t>(scans_));
    scan.ranges_m = std::move(returns.ranges_m);
    scan.intensities = std::move(returns.intensities);
  }
  scan.stamp = SimClock::StampOf(first + StampFault(faults, kTarget, first));
  last_scan_ = scan;
  if (const Fault* invalid = faults.Find(kTarget, FaultKind::kInvalid, first)) {
    Random random = RandomFor(seed_, SimRandom::kFault, scans_);
    for (float& range_m : scan.ranges_m) {
      if (random.NextUnit() < invalid->amount) range_m = kInvalidRange;
    }
  }
  laser_.queue.Push(last + FromSeconds(options_.laser_latency_s) +
                        DelayFault(faults, kTarget, first),
                    std::move(scan));
}

void SensorSuite::ExposeOnce(const Stage& stage, const FaultPlan& faults,
                             SimTime middle) {
  constexpr FaultTarget kTarget = FaultTarget::kCamera;
  if (faults.Has(kTarget, FaultKind::kSilent, middle)) {
    camera_.queue.SetLost(Silent("camera"));
    return;
  }
  SimulatedCamera::Exposure exposure;
  if (faults.Has(kTarget, FaultKind::kFrozen, middle) &&
      last_exposure_.has_value()) {
    exposure = *last_exposure_;
  } else {
    exposure.shot = {
        .world_from_camera = history_.At(middle) * robot_.base_from_camera,
        .bodies = stage.InstancesAt(Seconds(middle)),
        .sequence = exposures_};
    exposure.dark = faults.Has(kTarget, FaultKind::kDark, middle);
    exposure.blind = faults.Has(kTarget, FaultKind::kInvalid, middle);
  }
  exposure.stamp =
      SimClock::StampOf(middle + StampFault(faults, kTarget, middle));
  exposure.sequence = exposures_;
  last_exposure_ = exposure;
  camera_.queue.Push(middle + FromSeconds(options_.camera_latency_s) +
                         DelayFault(faults, kTarget, middle),
                     std::move(exposure));
}

void SensorSuite::Step(const RobotBody& body, const Stage& stage,
                       const FaultPlan& faults, SimTime now) {
  history_.Add(now, body.stance().WorldFromBase());
  // The n-th of `hz` is due at n / hz, and measured in the first step that
  // ends then or later.
  const auto due = [](int64_t number, double hz) {
    return FromSeconds(static_cast<double>(number) / hz);
  };
  if (due(readings_ + 1, options_.odometry_hz) <= now) {
    MeasureOdometry(body, faults, now);
    ++readings_;
  }
  const LaserScannerOptions& laser = options_.laser;
  const SimTime sweep = FromSeconds((laser.beams - 1) * laser.beam_interval_s);
  while (options_.has_laser) {
    const SimTime first = due(scans_, 1 / laser.scan_interval_s);
    if (first + sweep > now) break;
    ScanOnce(stage, faults, first);
    ++scans_;
  }
  while (has_camera_) {
    const SimTime middle = due(exposures_, options_.camera_hz);
    if (middle > now) break;
    ExposeOnce(stage, faults, middle);
    ++exposures_;
  }
}

}  // namespace treeline
