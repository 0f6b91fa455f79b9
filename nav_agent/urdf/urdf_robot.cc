#include "nav_agent/urdf/urdf_robot.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/robot_file.h"

namespace treeline::urdf {
namespace {

constexpr int kCircleCorners = 16;
// Corners that stand out by less are of a straight side: angles in URDFs have
// seven digits.
constexpr double kStraight_m2 = 1e-7;
// Lasers that are tilted by more see the floor 3 m away.
constexpr double kLevel_rad = 0.05;
// Both wheels of an axle are at least so far from the middle.
constexpr double kNearMiddle_m = 0.02;
// A robot's file says nothing of axles elsewhere.
constexpr double kAxleOff_m = 0.01;

using Points = std::vector<geometry::Vec3>;

// Corners of a polygon that encloses the circle.
void AddCircle(double radius_m, double z_m, Points& points) {
  const double corner_m =
      radius_m / std::cos(std::numbers::pi / kCircleCorners);
  for (int i = 0; i < kCircleCorners; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kCircleCorners;
    points.push_back(
        {corner_m * std::cos(angle_rad), corner_m * std::sin(angle_rad), z_m});
  }
}

// Points whose hull encloses the shape, in the frame of `base`.
Points PointsOf(const Shape& shape, const geometry::Rigid3& base_from_link) {
  const geometry::Rigid3 base_from_shape =
      base_from_link * shape.link_from_shape;
  Points points;
  if (shape.kind == ShapeKind::kSphere) {
    // The same from every side; only its outline seen from above counts, and
    // how high it reaches.
    AddCircle(shape.radius_m, 0, points);
    points.push_back({0, 0, shape.radius_m});
    points.push_back({0, 0, -shape.radius_m});
    for (geometry::Vec3& point : points) {
      point = base_from_shape.translation + point;
    }
    return points;
  }
  if (shape.kind == ShapeKind::kCylinder) {
    AddCircle(shape.radius_m, shape.length_m / 2, points);
    AddCircle(shape.radius_m, -shape.length_m / 2, points);
  } else {
    for (int i = 0; i < 8; ++i) {
      points.push_back({(i & 1 ? 0.5 : -0.5) * shape.size_m.x,
                        (i & 2 ? 0.5 : -0.5) * shape.size_m.y,
                        (i & 4 ? 0.5 : -0.5) * shape.size_m.z});
    }
  }
  for (geometry::Vec3& point : points) point = base_from_shape * point;
  return points;
}

Points AllPoints(const Urdf& urdf, size_t base) {
  Points all;
  for (size_t i = 0; i < urdf.links.size(); ++i) {
    const geometry::Rigid3 base_from_link = urdf.BaseFromLink(base, i);
    for (const Shape& shape : urdf.links[i].collisions) {
      const Points points = PointsOf(shape, base_from_link);
      all.insert(all.end(), points.begin(), points.end());
    }
  }
  return all;
}

// Andrew's monotone chain.
std::vector<geometry::Vec2> ConvexHull(std::vector<geometry::Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](geometry::Vec2 a, geometry::Vec2 b) {
              return a.x != b.x ? a.x < b.x : a.y < b.y;
            });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return {};
  std::vector<geometry::Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t begin = hull.size();
    for (const geometry::Vec2& point : points) {
      while (hull.size() >= begin + 2 &&
             geometry::Cross(hull.back() - hull[hull.size() - 2],
                             point - hull.back()) <= kStraight_m2) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// A polygon with a side in each of kMaxCorners directions that encloses `hull`.
std::vector<geometry::Vec2> Enclosed(const std::vector<geometry::Vec2>& hull) {
  std::vector<double> reach_m;
  std::vector<geometry::Vec2> normals;
  for (size_t i = 0; i < kMaxCorners; ++i) {
    const double angle_rad = 2 * std::numbers::pi * static_cast<double>(i) /
                             static_cast<double>(kMaxCorners);
    normals.push_back({std::cos(angle_rad), std::sin(angle_rad)});
    double most_m = -1e300;
    for (const geometry::Vec2& corner : hull) {
      most_m = std::max(most_m, geometry::Dot(corner, normals.back()));
    }
    reach_m.push_back(most_m);
  }
  std::vector<geometry::Vec2> corners;
  for (size_t i = 0; i < kMaxCorners; ++i) {
    const size_t j = (i + 1) % kMaxCorners;
    const double det = geometry::Cross(normals[i], normals[j]);
    corners.push_back(
        {(reach_m[i] * normals[j].y - reach_m[j] * normals[i].y) / det,
         (normals[i].x * reach_m[j] - normals[j].x * reach_m[i]) / det});
  }
  return corners;
}

absl::Status Missing(const Urdf& urdf, absl::string_view what,
                     absl::string_view name) {
  std::vector<std::string> names;
  for (const Link& link : urdf.links) {
    if (names.size() < 20) names.push_back(link.name.substr(0, 60));
  }
  return absl::InvalidArgumentError(
      absl::StrCat("there is no link '", name, "' for the ", what,
                   "; there are: ", absl::StrJoin(names, ", ")));
}

// Writes the file piece by piece.
class Description {
 public:
  Description(const Urdf& urdf, const UrdfRobotOptions& options)
      : urdf_(urdf), options_(options) {}

  absl::StatusOr<UrdfRobot> Make();

 private:
  absl::Status FindBase();
  absl::Status AddBody();
  void AddWheels();
  absl::Status AddLaser(const char* key, const std::string& link);
  absl::Status AddLasers();
  absl::Status AddCamera();
  // The links whose names hold one of the words.
  std::vector<std::string> Named(
      std::initializer_list<const char*> words) const;
  void Note(std::string note) { robot_.notes.push_back(std::move(note)); }

  const Urdf& urdf_;
  const UrdfRobotOptions& options_;
  UrdfRobot robot_;
  size_t base_ = 0;
  // Of the ground in the frame of the base.
  double ground_m_ = 0;
  double top_m_ = 0;
  double reach_m_ = 0;
  double caster_m_ = 0;
};

absl::Status Description::FindBase() {
  if (!options_.base_link.empty()) {
    const auto base = urdf_.Find(options_.base_link);
    if (!base) return Missing(urdf_, "base", options_.base_link);
    base_ = *base;
  } else {
    for (const char* name : {"base_footprint", "base_link"}) {
      if (const auto base = urdf_.Find(name)) {
        base_ = *base;
        return absl::OkStatus();
      }
    }
    while (urdf_.links[base_].parent) base_ = *urdf_.links[base_].parent;
    Note(absl::StrCat("no link is called base_footprint or base_link: '",
                      urdf_.links[base_].name, "' is taken for the base"));
  }
  return absl::OkStatus();
}

absl::Status Description::AddBody() {
  const Points points = AllPoints(urdf_, base_);
  const std::vector<geometry::Vec2> footprint = FootprintOf(urdf_, base_);
  int meshes = 0;
  for (const Link& link : urdf_.links) meshes += link.meshes;
  if (footprint.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the robot has no collision shapes that are boxes, cylinders or "
        "spheres, and so no footprint (",
        meshes, " are meshes, which are not read)"));
  }
  if (meshes > 0) {
    Note(absl::StrCat(meshes,
                      " collision shapes are meshes, which are not "
                      "read: the footprint may be too small"));
  }
  double low_m = points.front().z;
  top_m_ = points.front().z;
  for (const geometry::Vec3& point : points) {
    low_m = std::min(low_m, point.z);
    top_m_ = std::max(top_m_, point.z);
  }
  ground_m_ = urdf_.links[base_].name == "base_footprint" ? 0 : low_m;
  if (top_m_ - ground_m_ < 0.001) {
    return absl::InvalidArgumentError(
        "the robot is flat: its shapes have no "
        "height above the ground");
  }
  std::vector<std::string> corners;
  double front_m = 0;
  double rear_m = 0;
  for (const geometry::Vec2& corner : footprint) {
    corners.push_back(absl::StrFormat("[%.4f, %.4f]", corner.x, corner.y));
    front_m = std::max(front_m, corner.x);
    rear_m = std::max(rear_m, -corner.x);
  }
  reach_m_ = std::min(front_m, rear_m);
  absl::StrAppend(&robot_.yaml, "footprint: [", absl::StrJoin(corners, ", "),
                  "]\n");
  return absl::OkStatus();
}

void Description::AddWheels() {
  double left_m = 0;
  double right_m = 0;
  double radius_m = 0;
  double foremost_m = -1e300;
  double rearmost_m = 1e300;
  for (size_t i = 0; i < urdf_.links.size(); ++i) {
    const Link& link = urdf_.links[i];
    if (link.joint != JointKind::kTurning || link.collisions.size() != 1 ||
        link.collisions[0].kind == ShapeKind::kBox) {
      continue;
    }
    const geometry::Vec3 at = urdf_.BaseFromLink(base_, i).translation;
    // Casters hang below others, or stand in the middle.
    if (std::abs(at.y) < kNearMiddle_m) continue;
    left_m = std::max(left_m, at.y);
    right_m = std::min(right_m, at.y);
    radius_m = std::max(radius_m, link.collisions[0].radius_m);
    foremost_m = std::max(foremost_m, at.x);
    rearmost_m = std::min(rearmost_m, at.x);
  }
  if (left_m == 0 || right_m == 0 || radius_m == 0) {
    Note(
        "no wheels were found (cylinders on turning joints, on both sides): "
        "track and radius are those of the robot that it is like");
  } else {
    absl::StrAppendFormat(&robot_.yaml,
                          "wheel_track_m: %.4f\nwheel_radius_m: %.4f\n",
                          left_m - right_m, radius_m);
    const double axle_m = 0.5 * (foremost_m + rearmost_m);
    if (std::abs(axle_m) > kAxleOff_m) {
      Note(absl::StrFormat(
          "the wheels are %.3f m ahead of the base's origin, and a robot's "
          "file "
          "has the origin below the axle: give the link there as the base",
          axle_m));
    }
    caster_m_ = 0.5 * (foremost_m - rearmost_m);
  }
  // Within the body, which the default robot's would not be.
  if (caster_m_ < 0.01) caster_m_ = 0.8 * reach_m_;
  absl::StrAppendFormat(&robot_.yaml, "caster_m: %.4f\n",
                        std::min(caster_m_, reach_m_));
}

std::vector<std::string> Description::Named(
    std::initializer_list<const char*> words) const {
  std::vector<std::string> names;
  for (const Link& link : urdf_.links) {
    const std::string lower = absl::AsciiStrToLower(link.name);
    for (const char* word : words) {
      if (absl::StrContains(lower, word)) {
        names.push_back(link.name);
        break;
      }
    }
  }
  return names;
}

absl::Status Description::AddLaser(const char* key, const std::string& name) {
  const auto link = urdf_.Find(name);
  if (!link) return Missing(urdf_, key, name);
  const geometry::Rigid3 pose = urdf_.BaseFromLink(base_, *link);
  const geometry::Vec3 up = pose.rotation * geometry::Vec3{0, 0, 1};
  const double tilt_rad = std::acos(std::clamp(up.z, -1.0, 1.0));
  if (tilt_rad > kLevel_rad) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "link '%s' is tilted by %.0f degrees%s; only lasers that stand upright "
        "can be described",
        name, tilt_rad * 180 / std::numbers::pi,
        tilt_rad > 3 ? " (upside down)" : ""));
  }
  const geometry::Vec3 ahead = pose.rotation * geometry::Vec3{1, 0, 0};
  // Sensors often have no shape of their own.
  top_m_ = std::max(top_m_, pose.translation.z);
  absl::StrAppendFormat(
      &robot_.yaml, "%s:  # %s\n  at: [%.4f, %.4f, %.4f]\n  yaw_rad: %.5f\n",
      key, name, pose.translation.x, pose.translation.y,
      pose.translation.z - ground_m_, std::atan2(ahead.y, ahead.x));
  return absl::OkStatus();
}

absl::Status Description::AddLasers() {
  std::string laser = options_.laser_link;
  if (laser.empty()) {
    const auto names = Named({"laser", "lidar", "scan", "hokuyo", "rplidar"});
    if (names.size() > 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "several links may be the laser: ", absl::StrJoin(names, ", "),
          "; say which (--laser-link, --rear-laser-link)"));
    }
    if (names.empty()) {
      Note(
          "no link's name says that it is a laser: its place is that of the "
          "robot that it is like");
    } else {
      laser = names[0];
      Note(absl::StrCat("'", laser, "' is taken for the laser"));
    }
  }
  if (!laser.empty()) TL_RETURN_IF_ERROR(AddLaser("laser", laser));
  if (!options_.rear_laser_link.empty()) {
    return AddLaser("rear_laser", options_.rear_laser_link);
  }
  robot_.yaml += "rear_laser: none\n";
  return absl::OkStatus();
}

absl::Status Description::AddCamera() {
  std::string camera = options_.camera_link;
  if (camera.empty()) {
    const auto names = Named({"optical"});
    if (names.size() == 1) {
      camera = names[0];
      Note(absl::StrCat("'", camera, "' is taken for the camera"));
    }
  }
  if (camera.empty()) return absl::OkStatus();
  const auto link = urdf_.Find(camera);
  if (!link) return Missing(urdf_, "camera", camera);
  const geometry::Rigid3 pose = urdf_.BaseFromLink(base_, *link);
  top_m_ = std::max(top_m_, pose.translation.z);
  const bool is_optical = absl::StrContains(camera, "optical");
  const geometry::Vec3 ahead =
      pose.rotation *
      (is_optical ? geometry::Vec3{0, 0, 1} : geometry::Vec3{1, 0, 0});
  const geometry::Vec3 left =
      pose.rotation *
      (is_optical ? geometry::Vec3{-1, 0, 0} : geometry::Vec3{0, 1, 0});
  if (std::abs(ahead.z) > 0.99 || std::abs(left.z) > 0.1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "link '", camera,
        "': only cameras that look ahead with their upper edge up can be "
        "described; does the camera's name lack 'optical', or have it "
        "wrongly?"));
  }
  absl::StrAppendFormat(
      &robot_.yaml,
      "camera:  # %s\n  at: [%.4f, %.4f, %.4f]\n  yaw_rad: %.5f\n"
      "  down_rad: %.5f\n",
      camera, pose.translation.x, pose.translation.y,
      pose.translation.z - ground_m_, std::atan2(ahead.y, ahead.x),
      -std::asin(std::clamp(ahead.z, -1.0, 1.0)));
  return absl::OkStatus();
}

absl::StatusOr<UrdfRobot> Description::Make() {
  TL_RETURN_IF_ERROR(FindBase());
  robot_.yaml = absl::StrCat("like: ", options_.like, "\n");
  TL_RETURN_IF_ERROR(AddBody());
  AddWheels();
  TL_RETURN_IF_ERROR(AddLasers());
  TL_RETURN_IF_ERROR(AddCamera());
  absl::StrAppendFormat(&robot_.yaml, "height_m: %.4f\n", top_m_ - ground_m_);
  const auto read = core::ParseRobot(robot_.yaml, "the robot's file");
  if (!read.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "what the URDF says makes no robot: ", read.status().message()));
  }
  return std::move(robot_);
}

}  // namespace

std::vector<geometry::Vec2> FootprintOf(const Urdf& urdf, size_t base) {
  std::vector<geometry::Vec2> points;
  for (const geometry::Vec3& point : AllPoints(urdf, base)) {
    points.push_back({point.x, point.y});
  }
  std::vector<geometry::Vec2> hull = ConvexHull(std::move(points));
  if (hull.size() < 3) return {};
  return hull.size() > kMaxCorners ? Enclosed(hull) : hull;
}

absl::StatusOr<UrdfRobot> RobotOfUrdf(const Urdf& urdf,
                                      const UrdfRobotOptions& options) {
  return Description(urdf, options).Make();
}

}  // namespace treeline::urdf
