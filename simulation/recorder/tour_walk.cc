#include "simulation/recorder/tour_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "simulation/recorder/walk.h"
#include "simulation/sensors/picture.h"

namespace treeline::recorder {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStep_m = 0.05;
// Corners are rounded by the mean over so much of the way, to either side.
constexpr int kRounding = 9;
// Kept from what stands about at the camera's height, and measured at these.
constexpr double kClearance_m = 0.5;
constexpr float kClearanceHeights_m[] = {1.15f, 1.4f, 1.6f};
constexpr int kClearanceRays = 32;
constexpr int kRelaxations = 12;

// Points along the closed tour, kStep_m apart or a little less.
std::vector<geometry::Vec3> PointsAlong(
    const std::vector<worlds::Float3>& tour) {
  std::vector<geometry::Vec3> points;
  for (size_t i = 0; i < tour.size(); ++i) {
    const worlds::Float3 from = tour[i];
    const worlds::Float3 way = tour[(i + 1) % tour.size()] - from;
    const int steps = static_cast<int>(std::ceil(Norm(way) / kStep_m));
    for (int k = 0; k < steps; ++k) {
      const worlds::Float3 p =
          from + (static_cast<float>(k) / static_cast<float>(steps)) * way;
      points.push_back({p.x, p.y, p.z});
    }
  }
  return points;
}

// The mean of each point's surroundings along the closed way.
std::vector<geometry::Vec3> Rounded(const std::vector<geometry::Vec3>& points,
                                    int reach) {
  const int count = static_cast<int>(points.size());
  std::vector<geometry::Vec3> rounded(points.size());
  for (int i = 0; i < count; ++i) {
    geometry::Vec3 sum;
    for (int k = i - reach; k <= i + reach; ++k) {
      sum = sum + points[static_cast<size_t>(((k % count) + count) % count)];
    }
    rounded[static_cast<size_t>(i)] = sum / (2.0 * reach + 1);
  }
  return rounded;
}

worlds::Float3 ToFloat3(geometry::Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y),
          static_cast<float>(v.z)};
}

// A closed way's points moved along it so that they are evenly spaced. Returns
// its length, too.
double SpaceEvenly(std::vector<geometry::Vec3>& points) {
  const size_t count = points.size();
  std::vector<double> way_m = {0};
  for (size_t i = 0; i < count; ++i) {
    way_m.push_back(way_m.back() + Norm(points[(i + 1) % count] - points[i]));
  }
  std::vector<geometry::Vec3> even;
  size_t from = 0;
  for (size_t i = 0; i < count; ++i) {
    const double want_m =
        way_m.back() * static_cast<double>(i) / static_cast<double>(count);
    while (way_m[from + 1] < want_m) ++from;
    const double span_m = way_m[from + 1] - way_m[from];
    const double t = span_m > 0 ? (want_m - way_m[from]) / span_m : 0;
    even.push_back((1 - t) * points[from] + t * points[(from + 1) % count]);
  }
  points = std::move(even);
  return way_m.back();
}

// Steps back from what is nearer than kClearance_m at the camera's height.
geometry::Vec3 Kept(const renderer::RayCaster& caster, geometry::Vec3 ground) {
  geometry::Vec3 push;
  for (const float height_m : kClearanceHeights_m) {
    for (int i = 0; i < kClearanceRays; ++i) {
      const float angle = 2 * std::numbers::pi_v<float> *
                          static_cast<float>(i) / kClearanceRays;
      const worlds::Float3 way = {std::cos(angle), std::sin(angle), 0};
      const worlds::Float3 eye =
          ToFloat3(ground) + worlds::Float3{0, 0, height_m};
      for (const renderer::RayHit& hit :
           {caster.Cast(eye, way), caster.CastGlass(eye, way)}) {
        if (hit.surface == renderer::RayHit::kNothing ||
            hit.distance > kClearance_m) {
          continue;
        }
        const double want_m = kClearance_m - hit.distance;
        // The farthest push counts, not how many rays see the same wall.
        if (want_m > Norm(push)) push = {-want_m * way.x, -want_m * way.y, 0};
      }
    }
  }
  return ground + 0.5 * push;
}

// The points moved down, or up, to the ground.
void Drop(const renderer::RayCaster& caster,
          std::vector<geometry::Vec3>& points) {
  constexpr float kFrom_m = 0.9f;
  for (geometry::Vec3& point : points) {
    const renderer::RayHit hit = caster.Cast(
        ToFloat3(point) + worlds::Float3{0, 0, kFrom_m}, {0, 0, -1});
    if (hit.surface != renderer::RayHit::kNothing &&
        hit.distance < 2 * kFrom_m) {
      point.z += kFrom_m - static_cast<double>(hit.distance);
    }
  }
}

}  // namespace

absl::StatusOr<TourWalk> TourWalk::Create(const worlds::World& world,
                                          const renderer::RayCaster& caster,
                                          uint64_t seed) {
  TourWalk walk;
  walk.way_ = PointsAlong(world.tour);
  if (walk.way_.size() < 2 * kRounding + 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("world '", world.name, "' has no tour to walk"));
  }
  walk.way_ = Rounded(walk.way_, kRounding);
  for (int i = 0; i < kRelaxations; ++i) {
    for (geometry::Vec3& point : walk.way_) point = Kept(caster, point);
    walk.way_ = Rounded(walk.way_, kRounding / 3);
  }
  Drop(caster, walk.way_);
  // Nobody's head jumps up a step.
  walk.way_ = Rounded(walk.way_, 2);
  walk.length_m_ = SpaceEvenly(walk.way_);
  base::Random random(seed, 0x70a2);
  for (double& phase : walk.phases_) phase = random.NextUnit();
  walk.start_m_ = random.NextUnit() * walk.length_m_;
  walk.direction_ = random.NextBelow(2) == 0 ? 1 : -1;
  return walk;
}

geometry::Vec3 TourWalk::At(double way_m) const {
  const double count = static_cast<double>(way_.size());
  double place = way_m / length_m_ * count;
  place -= count * std::floor(place / count);
  const size_t first = std::min(static_cast<size_t>(place), way_.size() - 1);
  const double t = place - static_cast<double>(first);
  return (1 - t) * way_[first] + t * way_[(first + 1) % way_.size()];
}

double TourWalk::Wave(int k, double period_s, double time_s) const {
  return std::sin(2 * kPi *
                  (time_s / period_s + phases_[static_cast<size_t>(k)]));
}

geometry::Rigid3 TourWalk::WorldFromCameraAt(double t) const {
  const double way_m = start_m_ + direction_ * kSpeed_mps * t;
  const geometry::Vec3 here = At(way_m);
  // The mean way over the next and the last metre, so that gazes turn slowly.
  const geometry::Vec3 ahead = At(way_m + direction_) - At(way_m - direction_);
  const double z_m = here.z + 1.4 + 0.12 * Wave(0, 7.1, t) +
                     0.05 * Wave(1, 3.1, t) + 0.015 * Wave(2, 0.55, t);
  const double yaw_rad = std::atan2(ahead.y, ahead.x) + 0.75 * Wave(3, 9.7, t) +
                         0.35 * Wave(4, 6.1, t);
  const double pitch_rad =
      -0.15 + 0.14 * Wave(5, 8.3, t) + 0.05 * Wave(6, 2.3, t);
  const geometry::Rigid3 level =
      sensors::LookingFrom({here.x, here.y, z_m}, yaw_rad, pitch_rad);
  const double roll_rad = 0.04 * Wave(7, 5.3, t);
  return {level.rotation * geometry::Rotation3::FromAxisAngle({0, 0, roll_rad}),
          level.translation};
}

absl::StatusOr<CameraPath> MakeCameraPath(const worlds::World& world,
                                          const renderer::RayCaster& caster,
                                          uint64_t seed) {
  if (world.walk_area.half_x_m > 0) {
    const Walk walk(world.walk_area, seed);
    return CameraPath(
        [walk](double time_s) { return walk.WorldFromCameraAt(time_s); });
  }
  TL_ASSIGN_OR_RETURN(TourWalk tour, TourWalk::Create(world, caster, seed));
  return CameraPath([tour = std::move(tour)](double time_s) {
    return tour.WorldFromCameraAt(time_s);
  });
}

}  // namespace treeline::recorder
