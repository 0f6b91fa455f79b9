#include "nav_agent/app/map/testing_drive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/base/clock.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;

// From a point in the box along a direction to its walls, floor or ceiling.
double RangeInBox(geometry::Vec3 from, geometry::Vec3 along) {
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

camera::RgbdCalibration BoxCamera() {
  camera::RgbdCalibration calibration;
  calibration.color =
      *camera::Camera::Parse("PINHOLE,70,70,40,30", kWidth, kHeight);
  calibration.depth = calibration.color;
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return calibration;
}

recording::LogFrame FrameAt(const geometry::Rigid3& world_from_camera,
                            int64_t sequence) {
  core::RgbdFrame frame;
  frame.sequence = sequence;
  frame.frame.color = {
      .width = kWidth,
      .height = kHeight,
      .rgb = std::vector<uint8_t>(size_t{3} * kWidth * kHeight, 128)};
  image::DepthImage depth{.width = kWidth, .height = kHeight, .values = {}};
  const camera::Camera camera = BoxCamera().depth;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const camera::Pixel ray = *camera.Unproject(
          {.x = static_cast<double>(x), .y = static_cast<double>(y)});
      // The ray's z is 1, so that its range is the depth.
      const double z_m = RangeInBox(
          world_from_camera.translation,
          world_from_camera.rotation * geometry::Vec3{ray.x, ray.y, 1});
      depth.values.push_back(static_cast<uint16_t>(std::lround(1000 * z_m)));
    }
  }
  frame.frame.depth = std::move(depth);
  return *recording::EncodeLogFrame(frame, 90);
}

core::LaserScan ScanAt(const geometry::Rigid3& world_from_laser,
                       const core::RangeSensorInfo& laser) {
  core::LaserScan scan;
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle_rad = laser.AngleOf_rad(beam);
    scan.ranges_m.push_back(static_cast<float>(RangeInBox(
        world_from_laser.translation,
        world_from_laser.rotation *
            geometry::Vec3{std::cos(angle_rad), std::sin(angle_rad), 0})));
  }
  return scan;
}

}  // namespace

void RecordBoxDrive(const std::string& path, const BoxDrive& drive) {
  constexpr double kScans_hz = 20;
  constexpr int kReadings = 2;  // for each scan
  const core::RobotModel robot;
  const core::RangeSensorInfo laser{
      .angle_min_rad = -std::numbers::pi / 2,
      .angle_increment_rad = std::numbers::pi / 179,
      .beams = 180,
      .range_min_m = 0.1,
      .range_max_m = 30,
      .beam_interval_s = 0,
      .scan_interval_s = 1 / kScans_hz,
  };
  const base::SteadyClock clock;
  const auto log =
      *recording::AgentLogWriter::Open(path, /*append=*/false, clock);
  const auto write = [&log](const recording::LogEntry& entry) {
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
    const base::MonotonicTime stamp(
        std::chrono::duration_cast<base::MonotonicTime::duration>(
            std::chrono::duration<double>(time_s)));
    const double yaw_rad = rate_radps * time_s;
    const geometry::Rigid3 world_from_base{
        geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}), {}};
    core::BaseReading reading;
    reading.stamp = stamp;
    reading.right_wheel_m = yaw_rad * robot.wheel_track_m / 2;
    reading.left_wheel_m = -reading.right_wheel_m;
    reading.yaw_rate_radps = rate_radps;
    write(reading);
    write(recording::LogTruePose{stamp, world_from_base});
    if (i % kReadings == 0) {
      core::LaserScan scan =
          ScanAt(world_from_base * robot.base_from_laser, laser);
      scan.stamp = stamp;
      write(std::move(scan));
    }
    if (drive.frames_hz > 0 &&
        time_s * drive.frames_hz >= static_cast<double>(frames)) {
      recording::LogFrame frame =
          FrameAt(world_from_base * robot.base_from_camera, frames);
      frame.stamp = stamp;
      ++frames;
      write(std::move(frame));
    }
  }
  log->Flush().IgnoreError();
}

}  // namespace treeline::map_app
