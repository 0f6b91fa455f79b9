#include "simulation/simulator/sensor_suite.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/simulator/random_streams.h"

namespace treeline::simulator {
namespace {

constexpr SimTime kRemembered = std::chrono::milliseconds(500);

core::RangeSensorInfo InfoOf(const sensors::LaserScannerOptions& laser) {
  return {.angle_min_rad = laser.angle_min_rad,
          .angle_increment_rad = laser.angle_increment_rad,
          .beams = laser.beams,
          .range_min_m = laser.range_min_m,
          .range_max_m = laser.range_max_m,
          .beam_interval_s = laser.beam_interval_s,
          .scan_interval_s = laser.scan_interval_s};
}

void SetGeometry(const core::RangeSensorInfo& info,
                 sensors::LaserScannerOptions& laser) {
  laser.angle_min_rad = info.angle_min_rad;
  laser.angle_increment_rad = info.angle_increment_rad;
  laser.beams = info.beams;
  laser.range_min_m = info.range_min_m;
  laser.range_max_m = info.range_max_m;
  laser.beam_interval_s = info.beam_interval_s;
  laser.scan_interval_s = info.scan_interval_s;
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

void SensorOptions::UseLasers(const core::RobotLasers& lasers) {
  SetGeometry(lasers.front, laser);
  has_rear_laser = lasers.rear.has_value();
  if (has_rear_laser) SetGeometry(*lasers.rear, rear_laser);
}

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
  TL_RETURN_IF_ERROR(rear_laser.Validate());
  return laser.Validate();
}

sensors::LaserScannerOptions SensorOptions::ShortRangeLaser() {
  sensors::LaserScannerOptions laser;
  laser.beams = 541;
  laser.angle_increment_rad *= 2;
  laser.beam_interval_s *= 2;
  laser.range_min_m = 0.06;
  laser.range_max_m = 10;
  laser.noise_base_m = 0.01;
  return laser;
}

SensorSuite::Laser::Laser(core::LaserMount on, FaultTarget of,
                          sensors::LaserScanner measured, const SimClock& clock)
    : mount(on),
      target(of),
      scanner(std::move(measured)),
      device(clock, InfoOf(scanner.options())) {}

void PoseHistory::Add(SimTime time, const geometry::Rigid3& world_from_base) {
  entries_.push_back({time, world_from_base});
  while (entries_.front().time + kRemembered < time) entries_.pop_front();
}

void PoseHistory::Restart(SimTime time,
                          const geometry::Rigid3& world_from_base) {
  entries_.clear();
  entries_.push_back({time, world_from_base});
}

geometry::Rigid3 PoseHistory::At(SimTime time) const {
  const auto after = std::partition_point(
      entries_.begin(), entries_.end(),
      [&](const Entry& entry) { return entry.time < time; });
  if (after == entries_.begin()) return entries_.front().world_from_base;
  if (after == entries_.end()) return entries_.back().world_from_base;
  const Entry& a = *(after - 1);
  const Entry& b = *after;
  const double t = Seconds(time - a.time) / Seconds(b.time - a.time);
  const geometry::Rigid3& from = a.world_from_base;
  const geometry::Rigid3& to = b.world_from_base;
  return {geometry::Slerp(from.rotation, to.rotation, t),
          from.translation + t * (to.translation - from.translation)};
}

absl::StatusOr<std::unique_ptr<SensorSuite>> SensorSuite::Create(
    const worlds::World& world, const renderer::RayCaster& caster,
    const core::RobotModel& robot, const WheelOdometryErrors& errors,
    const SensorOptions& options, uint64_t seed, const SimClock& clock,
    std::shared_ptr<const Imager> imager) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::unique_ptr<SensorSuite> suite(new SensorSuite(
      robot, caster, errors, options, seed, clock, std::move(imager)));
  TL_ASSIGN_OR_RETURN(sensors::LaserScanner front,
                      sensors::LaserScanner::Create(
                          world, options.laser,
                          RandomFor(seed, SimRandom::kLaser, 0).NextBits()));
  suite->front_ = std::make_unique<Laser>(
      core::LaserMount::kFront, FaultTarget::kLaser, std::move(front), clock);
  if (options.has_rear_laser) {
    TL_ASSIGN_OR_RETURN(
        sensors::LaserScanner rear,
        sensors::LaserScanner::Create(
            world, options.rear_laser,
            RandomFor(seed, SimRandom::kRearLaser, 0).NextBits()));
    suite->rear_ = std::make_unique<Laser>(core::LaserMount::kRear,
                                           FaultTarget::kRearLaser,
                                           std::move(rear), clock);
  }
  return suite;
}

SensorSuite::SensorSuite(const core::RobotModel& robot,
                         const renderer::RayCaster& caster,
                         const WheelOdometryErrors& errors,
                         const SensorOptions& options, uint64_t seed,
                         const SimClock& clock,
                         std::shared_ptr<const Imager> imager)
    : robot_(robot),
      caster_(&caster),
      inertial_(errors, seed),
      options_(options),
      seed_(seed),
      has_camera_(imager != nullptr && options.camera_hz > 0),
      odometry_(clock),
      camera_(clock, std::move(imager)) {}

void SensorSuite::Restart(const RobotBody& body, SimTime now) {
  history_.Restart(now, body.stance().WorldFromBase());
}

void SensorSuite::MeasureOdometry(const RobotBody& body,
                                  const FaultPlan& faults, SimTime now) {
  constexpr FaultTarget kTarget = FaultTarget::kOdometry;
  core::BaseReading reading = body.drive().Counters();
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
    const base::MonotonicTime stamp = reading.stamp;
    reading = *last_reading_;
    reading.stamp = stamp;
  }
  last_reading_ = reading;
  odometry_.queue.Push(now + FromSeconds(options_.odometry_latency_s) +
                           DelayFault(faults, kTarget, now),
                       reading);
}

void SensorSuite::ScanUntil(const Stage& stage, const FaultPlan& faults,
                            SimTime now, Laser& laser) {
  const sensors::LaserScannerOptions& scanned = laser.scanner.options();
  const SimTime sweep =
      FromSeconds((scanned.beams - 1) * scanned.beam_interval_s);
  while (true) {
    const SimTime first = FromSeconds(static_cast<double>(laser.scans) /
                                      (1 / scanned.scan_interval_s));
    if (first + sweep > now) return;
    ScanOnce(stage, faults, first, laser);
    ++laser.scans;
  }
}

void SensorSuite::ScanOnce(const Stage& stage, const FaultPlan& faults,
                           SimTime first, Laser& laser) {
  const FaultTarget target = laser.target;
  if (faults.Has(target, FaultKind::kSilent, first)) {
    laser.device.queue.SetLost(Silent(
        laser.mount == core::LaserMount::kRear ? "rear laser" : "laser"));
    return;
  }
  const sensors::LaserScannerOptions& scanned = laser.scanner.options();
  const SimTime last =
      first + FromSeconds((scanned.beams - 1) * scanned.beam_interval_s);
  core::LaserScan scan;
  if (faults.Has(target, FaultKind::kFrozen, first) && laser.last.has_value()) {
    scan = *laser.last;
  } else {
    const geometry::Rigid3& base_from_laser = robot_.BaseFrom(laser.mount);
    const double middle_s = Seconds(first + (last - first) / 2);
    const renderer::WorldSnapshot snapshot =
        caster_->At(stage.InstancesAt(middle_s));
    sensors::LaserReturns returns =
        laser.scanner.Scan(snapshot, history_.At(first) * base_from_laser,
                           history_.At(last) * base_from_laser,
                           static_cast<uint64_t>(laser.scans));
    scan.ranges_m = std::move(returns.ranges_m);
    scan.intensities = std::move(returns.intensities);
  }
  scan.stamp = SimClock::StampOf(first + StampFault(faults, target, first));
  laser.last = scan;
  if (const Fault* invalid = faults.Find(target, FaultKind::kInvalid, first)) {
    base::Random random = RandomFor(seed_, SimRandom::kFault, laser.scans);
    for (float& range_m : scan.ranges_m) {
      if (random.NextUnit() < invalid->amount) range_m = core::kInvalidRange;
    }
  }
  laser.device.queue.Push(last + FromSeconds(options_.laser_latency_s) +
                              DelayFault(faults, target, first),
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
  if (options_.has_laser) ScanUntil(stage, faults, now, *front_);
  if (rear_ != nullptr) ScanUntil(stage, faults, now, *rear_);
  while (has_camera_) {
    const SimTime middle = due(exposures_, options_.camera_hz);
    if (middle > now) break;
    ExposeOnce(stage, faults, middle);
    ++exposures_;
  }
}

}  // namespace treeline::simulator
