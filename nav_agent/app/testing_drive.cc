#include "nav_agent/app/testing_drive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/base/clock.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;

// From a point in the box along a direction to its walls, floor or ceiling.
double RangeInBox(Vec3 from, Vec3 along) {
  double nearest = std::numeric_limits<double>::infinity();
  const auto meet = [&nearest](double at, double step, double low,
                               double high) {
    if (step > 0) nearest = std::min(nearest, (high - at) / step);
    if (step < 0) nearest = std::min(nearest, (low - at) / step);
  };
  meet(from.x, along.x, -kBoxX_m, kBoxX_m);
  meet(from.y, along.y, -kBoxY_m, kBoxY_m);
  meet(from.z, along.z, 0, kBoxZ_m);
  return nearest;
}

RgbdCalibration BoxCamera() {
  RgbdCalibration calibration;
  calibration.color = *Camera::Parse("PINHOLE,70,70,40,30", kWidth, kHeight);
  calibration.depth = calibration.color;
  calibration.pose_sensor = RgbdSensor::kDepth;
  return calibration;
}

LogFrame FrameAt(const Rigid3& world_from_camera, int64_t sequence) {
  RgbdFrame frame;
  frame.sequence = sequence;
  frame.frame.color = {
      .width = kWidth,
      .height = kHeight,
      .rgb = std::vector<uint8_t>(size_t{3} * kWidth * kHeight, 128)};
  DepthImage depth{.width = kWidth, .height = kHeight, .values = {}};
  const Camera camera = BoxCamera().depth;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Pixel ray = *camera.Unproject(
          {.x = static_cast<double>(x), .y = static_cast<double>(y)});
      // The ray's z is 1, so that its range is the depth.
      const double z_m =
          RangeInBox(world_from_camera.translation,
                     world_from_camera.rotation * Vec3{ray.x, ray.y, 1});
      depth.values.push_back(static_cast<uint16_t>(std::lround(1000 * z_m)));
    }
  }
  frame.frame.depth = std::move(depth);
  return *EncodeLogFrame(frame, 90);
}

LaserScan ScanAt(const Rigid3& world_from_laser, const RangeSensorInfo& laser) {
  LaserScan scan;
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle_rad = laser.AngleOf_rad(beam);
    scan.ranges_m.push_back(static_cast<float>(
        RangeInBox(world_from_laser.translation,
                   world_from_laser.rotation *
                       Vec3{std::cos(angle_rad), std::sin(angle_rad), 0})));
  }
  return scan;
}

}  // namespace

void RecordBoxDrive(const std::string& path, const BoxDrive& drive) {
  constexpr double kScans_hz = 20;
  constexpr int kReadings = 2;  // for each scan
  const RobotModel robot;
  const RangeSensorInfo laser{
      .angle_min_rad = -std::numbers::pi / 2,
      .angle_increment_rad = std::numbers::pi / 179,
      .beams = 180,
      .range_min_m = 0.1,
      .range_max_m = 30,
      .beam_interval_s = 0,
      .scan_interval_s = 1 / kScans_hz,
  };
  const SteadyClock clock;
  const auto log = *AgentLogWriter::Open(path, /*append=*/false, clock);
  const auto write = [&log](const LogEntry& entry) {
    log->Write(entry).IgnoreError();
  };
  write(robot);
  write(laser);
  if (drive.frames_hz > 0) write(BoxCamera());
  const double rate_radps = 2 * std::numbers::pi / drive.seconds;
  int64_t frames = 0;
  const int steps =
      static_cast<int>(drive.seconds * kScans_hz * kReadings) + kReadings;
  for (int i = 0; i <= steps; ++i) {
    const double time_s = i / (kScans_hz * kReadings);
    const MonotonicTime stamp(
        std::chrono::duration_cast<MonotonicTime::duration>(
            std::chrono::duration<double>(time_s)));
    const double yaw_rad = rate_radps * time_s;
    const Rigid3 world_from_base{Rotation3::FromAxisAngle({0, 0, yaw_rad}), {}};
    BaseReading reading;
    reading.stamp = stamp;
    reading.right_wheel_m = yaw_rad * robot.wheel_track_m / 2;
    reading.left_wheel_m = -reading.right_wheel_m;
    reading.yaw_rate_radps = rate_radps;
    write(reading);
    write(LogTruePose{stamp, world_from_base});
    if (i % kReadings == 0) {
      LaserScan scan = ScanAt(world_from_base * robot.base_from_laser, laser);
      scan.stamp = stamp;
      write(std::move(scan));
    }
    if (drive.frames_hz > 0 &&
        time_s * drive.frames_hz >= static_cast<double>(frames)) {
      LogFrame frame =
          FrameAt(world_from_base * robot.base_from_camera, frames);
      frame.stamp = stamp;
      ++frames;
      write(std::move(frame));
    }
  }
  log->Flush().IgnoreError();
}

}  // namespace treeline
