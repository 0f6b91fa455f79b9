#include "simulation/sensors/laser_scanner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check_range.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline::sensors {
namespace {

constexpr float kNothing_m = std::numeric_limits<float>::infinity();
constexpr float kRadiansPerDegree = std::numbers::pi_v<float> / 180;
constexpr float kFullIntensity = 4000;
// Where the intensity of a wall is half of that nearby.
constexpr float kHalfIntensity_m = 5;
// Beams between two moments at which the scanner's pose is worked out. In
// between it is mixed evenly, which is off by less than a microradian
// at 3 rad/s.
constexpr size_t kPoseStep = 8;

worlds::Float3 ToFloat3(geometry::Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y),
          static_cast<float>(v.z)};
}

// Where a scanner is, and its x and y axes.
struct ScannerPose {
  worlds::Float3 origin;
  worlds::Float3 x_axis;
  worlds::Float3 y_axis;
};

ScannerPose PoseAt(const geometry::Rigid3& first, const geometry::Rigid3& last,
                   double t) {
  const geometry::Mat3 matrix =
      geometry::Slerp(first.rotation, last.rotation, t).Matrix();
  return {
      ToFloat3(first.translation + t * (last.translation - first.translation)),
      ToFloat3({matrix(0, 0), matrix(1, 0), matrix(2, 0)}),
      ToFloat3({matrix(0, 1), matrix(1, 1), matrix(2, 1)})};
}

struct Beams {
  std::vector<worlds::Float3> origins;
  std::vector<worlds::Float3> directions;  // of unit length
};

// The beams of a scan in the world.
Beams BeamsOf(const std::vector<worlds::Float3>& in_scanner,
              const geometry::Rigid3& first, const geometry::Rigid3& last) {
  Beams beams;
  const size_t count = in_scanner.size();
  beams.origins.reserve(count);
  beams.directions.reserve(count);
  const auto pose_at = [&](size_t beam) {
    return PoseAt(first, last,
                  static_cast<double>(beam) / static_cast<double>(count - 1));
  };
  ScannerPose from = pose_at(0);
  for (size_t begin = 0; begin < count; begin += kPoseStep) {
    const size_t end = std::min(begin + kPoseStep, count);
    const ScannerPose to =
        first == last ? from : pose_at(std::min(end, count - 1));
    const float span = static_cast<float>(std::min(end, count - 1) - begin);
    for (size_t i = begin; i < end; ++i) {
      const float t = span > 0 ? static_cast<float>(i - begin) / span : 0;
      const worlds::Float3 x = worlds::Mix(from.x_axis, to.x_axis, t);
      const worlds::Float3 y = worlds::Mix(from.y_axis, to.y_axis, t);
      beams.origins.push_back(worlds::Mix(from.origin, to.origin, t));
      beams.directions.push_back(in_scanner[i].x * x + in_scanner[i].y * y);
    }
    from = to;
  }
  return beams;
}

std::vector<float> ReflectancesOf(
    const worlds::World& world, const std::vector<worlds::Surface>& surfaces) {
  std::vector<float> reflectances;
  reflectances.reserve(surfaces.size());
  for (const worlds::Surface& surface : surfaces) {
    const worlds::Float3 mean =
        world.textures[static_cast<size_t>(surface.texture)].Mean();
    reflectances.push_back((mean.x + mean.y + mean.z) / 3);
  }
  return reflectances;
}

}  // namespace

absl::Status LaserScannerOptions::Validate() const {
  constexpr double kTurn_rad = 2 * std::numbers::pi;
  TL_RETURN_IF_ERROR(base::CheckRange("laser beams", beams, 2, 100000));
  TL_RETURN_IF_ERROR(base::CheckRange("angle of the first beam (rad)",
                                      angle_min_rad, -kTurn_rad, kTurn_rad));
  TL_RETURN_IF_ERROR(base::CheckRange("angle between beams (rad)",
                                      angle_increment_rad, 1e-6, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("time between beams (s)", beam_interval_s, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("time between scans (s)", scan_interval_s, 1e-6, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("least laser range (m)", range_min_m, 0, 1000));
  TL_RETURN_IF_ERROR(base::CheckRange("largest laser range (m)", range_max_m,
                                      range_min_m, 1000));
  TL_RETURN_IF_ERROR(base::CheckRange("range noise (m)", noise_base_m, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("range noise per m", noise_per_m, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("range step (m)", range_step_m, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("random loss of beams", random_loss, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("grazing angle of beams (deg)", grazing_deg, 0, 90));
  TL_RETURN_IF_ERROR(base::CheckRange("return from glass", glass_return, 0, 1));
  return base::CheckRange("angle of returns from glass (deg)", glass_angle_deg,
                          0, 90);
}

absl::StatusOr<LaserScanner> LaserScanner::Create(
    const worlds::World& world, const LaserScannerOptions& options,
    uint64_t seed) {
  TL_RETURN_IF_ERROR(options.Validate());
  return LaserScanner(world, options, seed);
}

LaserScanner::LaserScanner(const worlds::World& world,
                           const LaserScannerOptions& options, uint64_t seed)
    : options_(options),
      seed_(seed),
      normals_(world),
      reflectances_(ReflectancesOf(world, world.surfaces)) {
  for (const worlds::Body& body : world.bodies) {
    body_reflectances_.push_back(ReflectancesOf(world, body.surfaces));
  }
  directions_.reserve(static_cast<size_t>(options.beams));
  for (int i = 0; i < options.beams; ++i) {
    const double angle_rad =
        options.angle_min_rad + i * options.angle_increment_rad;
    directions_.push_back(
        ToFloat3({std::cos(angle_rad), std::sin(angle_rad), 0}));
  }
}

bool LaserScanner::ReturnsFromGlass(const renderer::WorldSnapshot& snapshot,
                                    const renderer::RayHit& solid,
                                    const renderer::RayHit& pane,
                                    worlds::Float3 direction,
                                    const Chances& chances) const {
  if (pane.surface == renderer::RayHit::kNothing) return false;
  if (solid.surface != renderer::RayHit::kNothing &&
      pane.distance >= solid.distance) {
    return false;
  }
  const float cosine =
      std::min(std::abs(Dot(normals_.At(snapshot, pane), direction)), 1.0f);
  const float angle_deg = std::acos(cosine) / kRadiansPerDegree;
  const float limit_deg = static_cast<float>(options_.glass_angle_deg);
  if (angle_deg >= limit_deg) return false;
  return chances.glass < static_cast<float>(options_.glass_return) *
                             (1 - angle_deg / limit_deg);
}

LaserScanner::Echo LaserScanner::Measure(
    const renderer::WorldSnapshot& snapshot, const renderer::RayHit& hit,
    worlds::Float3 direction, const Chances& chances) const {
  const float range_min_m = static_cast<float>(options_.range_min_m);
  const float range_max_m = static_cast<float>(options_.range_max_m);
  if (hit.surface == renderer::RayHit::kNothing || hit.distance > range_max_m ||
      chances.loss < static_cast<float>(options_.random_loss)) {
    return {kNothing_m, 0};
  }
  // The cosine to the normal is the sine to the surface.
  const float sine = std::abs(Dot(normals_.At(snapshot, hit), direction));
  if (sine <
      std::sin(static_cast<float>(options_.grazing_deg) * kRadiansPerDegree)) {
    return {kNothing_m, 0};
  }
  const float sigma_m = static_cast<float>(options_.noise_base_m) +
                        static_cast<float>(options_.noise_per_m) * hit.distance;
  float range_m = hit.distance + sigma_m * chances.normal;
  if (options_.range_step_m > 0) {
    const float step_m = static_cast<float>(options_.range_step_m);
    range_m = step_m * std::round(range_m / step_m);
  }
  if (range_m < range_min_m) return {-kNothing_m, 0};
  const float reflectance =
      hit.instance == renderer::RayHit::kFixed
          ? reflectances_[hit.surface]
          : body_reflectances_[static_cast<size_t>(
                snapshot.instances()[static_cast<size_t>(hit.instance)].body)]
                              [hit.surface];
  const float far = hit.distance / kHalfIntensity_m;
  return {std::min(range_m, range_max_m),
          kFullIntensity * reflectance * sine / (1 + far * far)};
}

LaserReturns LaserScanner::Scan(
    const renderer::WorldSnapshot& snapshot,
    const geometry::Rigid3& world_from_laser_at_first,
    const geometry::Rigid3& world_from_laser_at_last, uint64_t scan) const {
  const size_t count = directions_.size();
  const Beams beams =
      BeamsOf(directions_, world_from_laser_at_first, world_from_laser_at_last);
  std::vector<renderer::RayHit> hits(count);
  snapshot.CastMany(beams.origins, beams.directions, hits);
  std::vector<renderer::RayHit> panes;
  if (snapshot.fixed().has_glass()) {
    panes.resize(count);
    snapshot.fixed().CastManyAtGlass(beams.origins, beams.directions, panes);
  }

  LaserReturns returns;
  returns.ranges_m.reserve(count);
  returns.intensities.reserve(count);
  base::Random random(seed_ ^ 0x1a5e25ca, scan);
  for (size_t i = 0; i < count; ++i) {
    Chances chances;
    chances.normal = static_cast<float>(random.NextGaussian());
    chances.loss = static_cast<float>(random.NextUnit());
    chances.glass = static_cast<float>(random.NextUnit());
    const worlds::Float3& direction = beams.directions[i];
    const bool is_glass =
        !panes.empty() &&
        ReturnsFromGlass(snapshot, hits[i], panes[i], direction, chances);
    const Echo echo =
        Measure(snapshot, is_glass ? panes[i] : hits[i], direction, chances);
    returns.ranges_m.push_back(echo.range_m);
    returns.intensities.push_back(static_cast<uint16_t>(echo.intensity));
  }
  return returns;
}

}  // namespace treeline::sensors
