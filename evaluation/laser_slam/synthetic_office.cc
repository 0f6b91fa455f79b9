#include "evaluation/laser_slam/synthetic_office.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "common/base/random.h"
#include "common/geometry/rigid2.h"

namespace treeline::laser_slam {
namespace {

struct Wall {
  geometry::Vec2 begin;
  geometry::Vec2 end;
};

// Two blocks side by side with corridors all round them.
constexpr double kBlock_m = 16;    // along x and y
constexpr double kCorridor_m = 2;  // wide
constexpr double kRoom_m = 4;      // along the corridor, and deep
constexpr double kDoor_m = 1.1;
constexpr double kPitch_m = kBlock_m + kCorridor_m;

class Plan {
 public:
  explicit Plan(uint64_t seed) : random_(seed, 0) {
    for (const double x : {0.0, kPitch_m}) AddBlock({x, 0});
    // The outer walls, with alcoves.
    const double width_m = 2 * kBlock_m + 3 * kCorridor_m;
    const double height_m = kBlock_m + 2 * kCorridor_m;
    const geometry::Vec2 low = {-kCorridor_m, -kCorridor_m};
    const geometry::Vec2 high = low + geometry::Vec2{width_m, height_m};
    AddBox(low, high);
    for (int i = 0; i < 14; ++i) {
      const double along = random_.NextUniform(2, width_m - 3);
      const double size_m = random_.NextUniform(0.3, 1.2);
      const double deep_m = random_.NextUniform(0.1, 0.35);
      const geometry::Vec2 at = {low.x + along, low.y};
      if (i % 2 == 0) {
        AddBox(at, at + geometry::Vec2{size_m, deep_m});
      } else {
        AddBox({at.x, high.y - deep_m}, {at.x + size_m, high.y});
      }
    }
  }

  const std::vector<Wall>& walls() const { return walls_; }
  // Of rooms that open to the corridor below a block: where to enter.
  const std::vector<geometry::Vec2>& doors() const { return doors_; }

 private:
  void AddBox(geometry::Vec2 low, geometry::Vec2 high) {
    walls_.push_back({{low.x, low.y}, {high.x, low.y}});
    walls_.push_back({{high.x, low.y}, {high.x, high.y}});
    walls_.push_back({{high.x, high.y}, {low.x, high.y}});
    walls_.push_back({{low.x, high.y}, {low.x, low.y}});
  }
  // Rooms along the lower and the upper side; the rest is solid.
  void AddBlock(geometry::Vec2 corner) {
    walls_.push_back({corner, corner + geometry::Vec2{0, kBlock_m}});
    walls_.push_back({corner + geometry::Vec2{kBlock_m, 0},
                      corner + geometry::Vec2{kBlock_m, kBlock_m}});
    const int rooms = static_cast<int>(kBlock_m / kRoom_m);
    for (int i = 0; i < rooms; ++i) {
      AddRoom(corner + geometry::Vec2{i * kRoom_m, 0}, 1);
      AddRoom(corner + geometry::Vec2{i * kRoom_m, kBlock_m}, -1);
    }
  }
  // `side` 1: upwards from its door wall.
  void AddRoom(geometry::Vec2 at, double side) {
    const double door_m = random_.NextUniform(0.4, kRoom_m - kDoor_m - 0.4);
    const double back = at.y + side * kRoom_m;
    walls_.push_back({at, {at.x + door_m, at.y}});
    walls_.push_back({{at.x + door_m + kDoor_m, at.y}, {at.x + kRoom_m, at.y}});
    walls_.push_back({at, {at.x, back}});
    walls_.push_back({{at.x + kRoom_m, at.y}, {at.x + kRoom_m, back}});
    walls_.push_back({{at.x, back}, {at.x + kRoom_m, back}});
    // Furniture at the back, so that the robot can turn.
    for (int i = 0; i < 3; ++i) {
      const double x = at.x + random_.NextUniform(0.2, kRoom_m - 1.2);
      const double deep = side * random_.NextUniform(0.3, 0.9);
      const double wide = random_.NextUniform(0.3, 1.0);
      AddBox({x, std::min(back, back - deep)},
             {x + wide, std::max(back, back - deep)});
    }
    const bool is_closed = random_.NextUnit() < 0.3;
    if (is_closed) {
      walls_.push_back({{at.x + door_m, at.y + side * 0.1},
                        {at.x + door_m + kDoor_m, at.y + side * 0.1}});
    } else if (side > 0) {
      doors_.push_back({at.x + door_m + 0.5 * kDoor_m, at.y});
    }
  }

  base::Random random_;
  std::vector<Wall> walls_;
  std::vector<geometry::Vec2> doors_;
};

// The corners of the drive.
std::vector<geometry::Vec2> Way(const Plan& plan) {
  const double middle = -0.5 * kCorridor_m;
  const double top = kBlock_m + 0.5 * kCorridor_m;
  const double left = middle;
  const double between = kBlock_m + 0.5 * kCorridor_m;
  const double right = 2 * kBlock_m + 1.5 * kCorridor_m;
  std::vector<geometry::Vec2> way = {{left, middle}};
  // Along the lower corridor, into every second room that is open.
  for (size_t i = 0; i < plan.doors().size(); i += 2) {
    const geometry::Vec2 door = plan.doors()[i];
    if (door.x <= left || door.x >= right) continue;
    way.push_back({door.x, middle});
    way.push_back({door.x, door.y + 1.8});
    way.push_back({door.x, middle});
  }
  for (const geometry::Vec2& corner :
       {geometry::Vec2{right, middle}, geometry::Vec2{right, top},
        geometry::Vec2{between, top}, geometry::Vec2{between, middle},
        geometry::Vec2{left, middle}, geometry::Vec2{left, top},
        geometry::Vec2{between, top}, geometry::Vec2{right, top},
        geometry::Vec2{right, middle}, geometry::Vec2{left + 3, middle}}) {
    way.push_back(corner);
  }
  return way;
}

// Turns towards each corner on the spot, then drives there.
std::vector<geometry::Rigid2> Poses(const std::vector<geometry::Vec2>& way,
                                    const OfficeOptions& options) {
  const double step_m = options.speed_mps / options.scans_hz;
  const double step_rad = options.turn_radps / options.scans_hz;
  std::vector<geometry::Rigid2> poses = {{way.front(), 0}};
  for (size_t i = 1; i < way.size(); ++i) {
    geometry::Rigid2 pose = poses.back();
    const geometry::Vec2 ahead = way[i] - pose.translation;
    const double length_m = geometry::Norm(ahead);
    if (length_m < 1e-6) continue;
    const double turn_rad = geometry::NormalizedAngle_rad(
        std::atan2(ahead.y, ahead.x) - pose.yaw_rad);
    const int turns =
        static_cast<int>(std::ceil(std::abs(turn_rad) / step_rad));
    for (int k = 1; k <= turns; ++k) {
      poses.push_back(
          {pose.translation,
           geometry::NormalizedAngle_rad(pose.yaw_rad + turn_rad * k / turns)});
    }
    pose = poses.back();
    const int steps = static_cast<int>(std::ceil(length_m / step_m));
    for (int k = 1; k <= steps; ++k) {
      poses.push_back(
          {pose.translation + (static_cast<double>(k) / steps) * ahead,
           pose.yaw_rad});
    }
  }
  return poses;
}

std::vector<float> Scan(const std::vector<Wall>& walls,
                        const geometry::Rigid2& map_from_laser,
                        const core::RangeSensorInfo& laser, double noise_m,
                        base::Random random) {
  std::vector<float> ranges_m;
  const geometry::Vec2 from = map_from_laser.translation;
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle_rad = map_from_laser.yaw_rad + laser.AngleOf_rad(beam);
    const geometry::Vec2 along = {std::cos(angle_rad), std::sin(angle_rad)};
    double nearest_m = laser.range_max_m;
    for (const Wall& wall : walls) {
      const geometry::Vec2 length = wall.end - wall.begin;
      const double det = geometry::Cross(along, length);
      if (std::abs(det) < 1e-12) continue;
      const double range_m = geometry::Cross(wall.begin - from, length) / det;
      const double part = geometry::Cross(wall.begin - from, along) / det;
      if (range_m > 0 && part >= 0 && part <= 1) {
        nearest_m = std::min(nearest_m, range_m);
      }
    }
    const double range_m = nearest_m + noise_m * random.NextGaussian();
    ranges_m.push_back(nearest_m < laser.range_max_m
                           ? static_cast<float>(range_m)
                           : core::kNoReturn);
  }
  return ranges_m;
}

}  // namespace

OfficeDrive DriveThroughOffice(const OfficeOptions& options) {
  const Plan plan(options.seed);
  OfficeDrive drive;
  drive.log.laser = {
      .angle_min_rad = -std::numbers::pi / 2,
      .angle_increment_rad = std::numbers::pi / (options.beams - 1),
      .beams = options.beams,
      .range_min_m = 0.02,
      .range_max_m = options.laser_range_m,
      .scan_interval_s = 1 / options.scans_hz};
  drive.map_from_base = Poses(Way(plan), options);
  for (size_t i = 0; i < drive.map_from_base.size(); ++i) {
    const geometry::Rigid2& pose = drive.map_from_base[i];
    const auto time_ms =
        static_cast<int64_t>(1000 * static_cast<double>(i) / options.scans_hz);
    drive.log.scans.push_back(
        {.stamp = recording::RecordingTime(std::chrono::milliseconds(time_ms)),
         .odom_from_base = pose,
         .ranges_m =
             Scan(plan.walls(), pose, drive.log.laser, options.laser_noise_m,
                  base::Random(options.seed, 1 + i))});
  }
  return drive;
}

std::vector<recording::PoseRelation> TrueRelations(
    const OfficeDrive& drive, const recording::LaserLog& log) {
  constexpr double kNext_m = 1.0;
  constexpr double kSamePlace_m = 2.0;
  constexpr double kLoop_m = 10.0;
  struct Place {
    recording::RecordingTime stamp;
    geometry::Rigid2 pose;
    double way_m = 0;
  };
  std::map<recording::RecordingTime, size_t> number_of;
  for (size_t i = 0; i < drive.log.scans.size(); ++i) {
    number_of[drive.log.scans[i].stamp] = i;
  }
  std::vector<Place> places;  // a metre apart
  double way_m = 0;
  std::optional<geometry::Rigid2> last;
  for (const recording::RecordedScan& scan : log.scans) {
    const auto number = number_of.find(scan.stamp);
    if (number == number_of.end()) continue;
    const geometry::Rigid2& pose = drive.map_from_base[number->second];
    if (last) way_m += geometry::Norm(pose.translation - last->translation);
    last = pose;
    if (places.empty() || way_m >= places.back().way_m + kNext_m) {
      places.push_back({scan.stamp, pose, way_m});
    }
  }
  std::vector<recording::PoseRelation> relations;
  for (size_t i = 0; i < places.size(); ++i) {
    for (size_t k = i + 1; k < places.size(); ++k) {
      const geometry::Vec2 apart =
          places[k].pose.translation - places[i].pose.translation;
      const bool is_loop = geometry::Norm(apart) < kSamePlace_m &&
                           places[k].way_m - places[i].way_m > kLoop_m;
      if (k > i + 1 && !is_loop) continue;
      relations.push_back({.from = places[i].stamp,
                           .to = places[k].stamp,
                           .from_base_from_to_base =
                               places[i].pose.Inverse() * places[k].pose});
    }
  }
  return relations;
}

}  // namespace treeline::laser_slam
