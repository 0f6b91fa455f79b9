#include "server/core/training/box_room_recording.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/random.h"
#include "common/image/decode.h"

namespace treeline::training {
namespace {

constexpr geometry::Vec3 kHalf{2, 1.25, 1.5};

// Random values at integer points, blended between them.
double ValueNoise(geometry::Vec3 p, uint64_t seed) {
  const auto lattice = [&](int64_t x, int64_t y, int64_t z) {
    const uint64_t bits = base::MixBits(
        base::MixBits(base::MixBits(static_cast<uint64_t>(x) + seed) +
                      static_cast<uint64_t>(y)) +
        static_cast<uint64_t>(z));
    return static_cast<double>(bits >> 11) * 0x1.0p-53;
  };
  const double fx = std::floor(p.x);
  const double fy = std::floor(p.y);
  const double fz = std::floor(p.z);
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1;
    const int dy = corner >> 1 & 1;
    const int dz = corner >> 2;
    const double weight = (dx ? p.x - fx : 1 - p.x + fx) *
                          (dy ? p.y - fy : 1 - p.y + fy) *
                          (dz ? p.z - fz : 1 - p.z + fz);
    value += weight * lattice(static_cast<int64_t>(fx) + dx,
                              static_cast<int64_t>(fy) + dy,
                              static_cast<int64_t>(fz) + dz);
  }
  return value;
}

uint8_t Pattern(geometry::Vec3 point, int channel) {
  const uint64_t seed = 1000 * static_cast<uint64_t>(channel + 1);
  const double value = 0.5 * ValueNoise(3 * point, seed) +
                       0.35 * ValueNoise(8 * point, seed + 1) +
                       0.15 * ValueNoise(20 * point, seed + 2);
  return static_cast<uint8_t>(std::clamp(510 * value - 127, 0., 255.));
}

// What the tile at a point of a wall adds to the brightness. Cells are in
// space; no wall lies on a border between two.
int Tile(geometry::Vec3 point) {
  constexpr double kSide_m = 0.6;
  constexpr double kOffset_m = 0.13;
  uint64_t bits = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::floor((point[axis] + kOffset_m) / kSide_m);
    bits =
        base::MixBits(bits + static_cast<uint64_t>(static_cast<int64_t>(cell)));
  }
  return static_cast<int>(bits % 121) - 60;
}

// Where a ray from inside the room leaves it: the factor of `direction`.
double DistanceToWall(geometry::Vec3 origin, geometry::Vec3 direction) {
  double nearest = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const double wall = direction[axis] > 0 ? kHalf[axis] : -kHalf[axis];
    nearest = std::min(nearest, (wall - origin[axis]) / direction[axis]);
  }
  return nearest;
}

template <typename Visit>
void VisitPixels(const camera::Camera& camera,
                 const geometry::Rigid3& world_from_camera,
                 const Visit& visit) {
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const auto ray =
          camera.Unproject({static_cast<double>(x), static_cast<double>(y)});
      const geometry::Vec3 direction =
          world_from_camera.rotation * geometry::Vec3{ray->x, ray->y, 1};
      const double z = DistanceToWall(world_from_camera.translation, direction);
      visit(z, world_from_camera.translation + z * direction);
    }
  }
}

void Check(const absl::Status& status) {
  if (!status.ok()) std::abort();
}

}  // namespace

camera::RgbdCalibration BoxRoomCalibration() {
  camera::RgbdCalibration calibration;
  calibration.color =
      *camera::Camera::Parse("PINHOLE,145,145,100,75", 200, 150);
  calibration.depth = calibration.color;
  return calibration;
}

image::Frame RenderBoxRoom(const camera::RgbdCalibration& calibration,
                           const geometry::Rigid3& world_from_sensor,
                           BoxRoomWalls walls) {
  const bool of_color = calibration.pose_sensor == camera::RgbdSensor::kColor;
  const geometry::Rigid3 world_from_color =
      of_color ? world_from_sensor
               : world_from_sensor * calibration.color_from_depth.Inverse();
  const geometry::Rigid3 world_from_depth =
      of_color ? world_from_sensor * calibration.color_from_depth
               : world_from_sensor;
  image::Frame frame;
  frame.color = {calibration.color.width(), calibration.color.height(), {}};
  VisitPixels(
      calibration.color, world_from_color, [&](double, geometry::Vec3 point) {
        const int tile = walls == BoxRoomWalls::kTiled ? Tile(point) : 0;
        for (int c = 0; c < 3; ++c) {
          frame.color.rgb.push_back(static_cast<uint8_t>(
              std::clamp(Pattern(point, c) + tile, 0, 255)));
        }
      });
  frame.depth = image::DepthImage{
      calibration.depth.width(), calibration.depth.height(), {}, 0.001};
  VisitPixels(calibration.depth, world_from_depth,
              [&](double z, geometry::Vec3) {
                frame.depth->values.push_back(static_cast<uint16_t>(
                    std::lround(1000 * z / calibration.depth_scale)));
              });
  return frame;
}

std::vector<geometry::Rigid3> BoxRoomPoses(int count) {
  std::vector<geometry::Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    // The camera's y axis points down: along the world's y here.
    const geometry::Rotation3 heading =
        geometry::Rotation3::FromAxisAngle({0, angle, 0});
    const geometry::Rotation3 tilt =
        geometry::Rotation3::FromAxisAngle({0.25 * std::sin(3 * angle), 0, 0}) *
        geometry::Rotation3::FromAxisAngle({0, 0, 0.2 * std::cos(2 * angle)});
    poses.push_back({geometry::Normalized(heading * tilt),
                     {0.5 * std::sin(2 * angle), 0.3 * std::cos(angle),
                      0.5 * std::cos(3 * angle)}});
  }
  return poses;
}

void WriteBoxRoomRecording(
    const std::string& folder, const camera::RgbdCalibration& calibration,
    const std::vector<geometry::Rigid3>& world_from_sensor,
    BoxRoomWalls walls) {
  std::filesystem::create_directories(folder + "/seq-01");
  std::string color_poses;
  for (size_t i = 0; i < world_from_sensor.size(); ++i) {
    const geometry::Rigid3& pose = world_from_sensor[i];
    const image::Frame frame = RenderBoxRoom(calibration, pose, walls);
    const std::string stem = absl::StrFormat("seq-01/frame-%06d", i);
    const std::string path = absl::StrCat(folder, "/", stem);
    Check(base::WriteFileAtomically(path + ".color.png",
                                    *image::EncodePng(frame.color)));
    Check(base::WriteFileAtomically(path + ".depth.png",
                                    *image::EncodeDepthPng(*frame.depth)));
    const geometry::Mat3 r = pose.rotation.Matrix();
    const geometry::Vec3& t = pose.translation;
    Check(base::WriteFileAtomically(
        path + ".pose.txt",
        absl::StrFormat("%.17g %.17g %.17g %.17g\n%.17g %.17g %.17g %.17g\n"
                        "%.17g %.17g %.17g %.17g\n0 0 0 1\n",
                        r(0, 0), r(0, 1), r(0, 2), t.x, r(1, 0), r(1, 1),
                        r(1, 2), t.y, r(2, 0), r(2, 1), r(2, 2), t.z)));
    const geometry::Rigid3 inverse = pose.Inverse();
    const geometry::Rotation3& q = inverse.rotation;
    const geometry::Vec3& s = inverse.translation;
    absl::StrAppendFormat(&color_poses,
                          "%s %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n",
                          stem, q.w, q.x, q.y, q.z, s.x, s.y, s.z);
  }
  Check(base::WriteFileAtomically(folder + "/poses.txt", color_poses));
}

}  // namespace treeline::training
