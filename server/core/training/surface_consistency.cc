#include "server/core/training/surface_consistency.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "server/core/features/rgbd_samples.h"

namespace treeline::training {
namespace {

// Pairs are compared whose viewing directions differ by this much (rad): less
// says nothing about the calibration, more sees little in common.
constexpr double kMinAngle_rad = 8 * std::numbers::pi / 180;
constexpr double kMaxAngle_rad = 60 * std::numbers::pi / 180;
constexpr int kPairsPerFrame = 5;
constexpr int kPointsPerPair = 400;
// At least this share of the points of a pair must fall on a surface within
// kOverlapDistance_m of them.
constexpr double kMinOverlap = 0.3;
constexpr double kOverlapDistance_m = 0.15;

// A surface's neighbourhood for its normal (px), and how much depth may jump
// across it (share of the depth).
constexpr int kNormalStep_px = 4;
constexpr double kMaxJump = 0.03;

geometry::Rigid3 WorldFromDepth(const PosedDepth& frame,
                                const camera::RgbdCalibration& calibration) {
  return calibration.pose_sensor == camera::RgbdSensor::kColor
             ? frame.world_from_sensor * calibration.color_from_depth
             : frame.world_from_sensor;
}

// At a pixel of the depth image with that ray.
std::optional<geometry::Vec3> DepthPoint(
    const PosedDepth& frame, const camera::RgbdCalibration& calibration,
    int pixel, const std::optional<camera::Pixel>& ray) {
  const uint16_t value = frame.depth.values[static_cast<size_t>(pixel)];
  if (!ray || !image::IsMeasured(value)) return std::nullopt;
  const double z = value * frame.depth.unit_m * calibration.depth_scale;
  return geometry::Vec3{ray->x * z, ray->y * z, z};
}

// `rays` are those of all pixels.
std::optional<geometry::Vec3> DepthPoint(
    const PosedDepth& frame, const camera::RgbdCalibration& calibration,
    std::span<const std::optional<camera::Pixel>> rays, int u, int v) {
  const image::DepthImage& depth = frame.depth;
  if (u < 0 || v < 0 || u >= depth.width || v >= depth.height) {
    return std::nullopt;
  }
  const int pixel = v * depth.width + u;
  return DepthPoint(frame, calibration, pixel,
                    rays[static_cast<size_t>(pixel)]);
}

double MeasuredDepth_m(const PosedDepth& frame, uint32_t pixel) {
  return frame.depth.values[pixel] * frame.depth.unit_m;
}

// From one frame's depth camera to another's, in measured depth.
struct Motion {
  geometry::Mat3 rotation;
  geometry::Vec3 translation;
  bool has_known_rays = false;
};

// The ray of a pixel through cameras that hardly differ from one whose ray is
// known: a step of Newton's method, with that camera's derivative.
class NearbyRay {
 public:
  NearbyRay(const camera::Camera& camera, uint32_t pixel, camera::Pixel ray)
      : pixel_{static_cast<double>(pixel %
                                   static_cast<uint32_t>(camera.width())),
               static_cast<double>(pixel /
                                   static_cast<uint32_t>(camera.width()))},
        ray_(ray) {
    constexpr double kStep = 1e-4;
    const auto derivative = [&](double dx, double dy) {
      const camera::Pixel plus = camera.Project({ray.x + dx, ray.y + dy, 1});
      const camera::Pixel minus = camera.Project({ray.x - dx, ray.y - dy, 1});
      return camera::Pixel{(plus.x - minus.x) / (2 * kStep),
                           (plus.y - minus.y) / (2 * kStep)};
    };
    const camera::Pixel by_x = derivative(kStep, 0);
    const camera::Pixel by_y = derivative(0, kStep);
    const double determinant = by_x.x * by_y.y - by_y.x * by_x.y;
    inverse_ = {by_y.y / determinant, -by_y.x / determinant,
                -by_x.y / determinant, by_x.x / determinant};
  }

  camera::Pixel Through(const camera::Camera& camera) const {
    const camera::Pixel seen = camera.Project({ray_.x, ray_.y, 1});
    const double dx = pixel_.x - seen.x;
    const double dy = pixel_.y - seen.y;
    return {ray_.x + inverse_[0] * dx + inverse_[1] * dy,
            ray_.y + inverse_[2] * dx + inverse_[3] * dy};
  }

 private:
  const camera::Pixel pixel_;
  const camera::Pixel ray_;
  std::array<double, 4> inverse_{};  // of the derivative, row-major
};

struct SurfacePoint {
  geometry::Vec3 point;
  geometry::Vec3 normal;
};

// The surface at a depth pixel, from its neighbours right, left, below, above.
std::optional<SurfacePoint> SurfaceAt(
    const PosedDepth& frame, const camera::RgbdCalibration& calibration,
    std::span<const std::optional<camera::Pixel>> rays, int u, int v) {
  const auto at = [&](int du, int dv) {
    return DepthPoint(frame, calibration, rays, u + du, v + dv);
  };
  const auto center = at(0, 0);
  const auto right = at(kNormalStep_px, 0);
  const auto left = at(-kNormalStep_px, 0);
  const auto below = at(0, kNormalStep_px);
  const auto above = at(0, -kNormalStep_px);
  if (!center || !right || !left || !below || !above) return std::nullopt;
  for (const auto& neighbour : {right, left, below, above}) {
    if (std::abs(neighbour->z - center->z) > kMaxJump * center->z) {
      return std::nullopt;
    }
  }
  const geometry::Vec3 normal =
      geometry::Cross(*right - *left, *below - *above);
  const double norm = geometry::Norm(normal);
  if (!(norm > 0)) return std::nullopt;
  return SurfacePoint{*center, normal / norm};
}

}  // namespace

SurfaceConsistency::SurfaceConsistency(const std::vector<PosedDepth>& frames,
                                       const camera::RgbdCalibration& nominal)
    : frames_(frames) {
  SetCalibration(nominal, /*threads=*/1);
  std::vector<geometry::Rigid3> world_from_depth;
  for (const PosedDepth& frame : frames) {
    world_from_depth.push_back(WorldFromDepth(frame, nominal));
  }
  for (size_t i = 0; i < frames.size(); ++i) {
    base::Random random(0, i);
    int found = 0;
    const uint32_t n = static_cast<uint32_t>(frames.size());
    for (int attempt = 0; attempt < 60 && found < kPairsPerFrame; ++attempt) {
      const size_t j = random.NextBelow(n);
      const double angle = geometry::AngleBetween_rad(
          world_from_depth[i].rotation, world_from_depth[j].rotation);
      if (i == j || angle < kMinAngle_rad || angle > kMaxAngle_rad) continue;
      const geometry::Rigid3 to_from =
          world_from_depth[j].Inverse() * world_from_depth[i];
      Pair pair{i, j, {}, {}};
      int overlap = 0;
      for (int k = 0;
           k < 4 * kPointsPerPair && pair.pixels.size() < kPointsPerPair; ++k) {
        const uint32_t pixel = random.NextBelow(
            static_cast<uint32_t>(frames[i].depth.values.size()));
        const int width = frames[i].depth.width;
        const auto from = SurfaceAt(frames[i], nominal, rays_,
                                    static_cast<int>(pixel) % width,
                                    static_cast<int>(pixel) / width);
        if (!from) continue;
        pair.pixels.push_back(pixel);
        const geometry::Vec3 moved = to_from * from->point;
        if (moved.z <= 0.1) continue;
        const camera::Pixel p = nominal.depth.Project(moved);
        if (!(std::abs(p.x) < 1e5 && std::abs(p.y) < 1e5)) continue;
        const auto to = DepthPoint(frames[j], nominal, rays_,
                                   static_cast<int>(std::lround(p.x)),
                                   static_cast<int>(std::lround(p.y)));
        overlap += to && std::abs(to->z - moved.z) < kOverlapDistance_m;
      }
      if (overlap < kMinOverlap * kPointsPerPair) continue;
      pairs_.push_back(std::move(pair));
      ++found;
    }
  }
}

void SurfaceConsistency::SetCalibration(
    const camera::RgbdCalibration& calibration, int threads) {
  calibration_ = calibration;
  const camera::Camera& camera = calibration.depth;
  const size_t width = static_cast<size_t>(camera.width());
  rays_.resize(width * static_cast<size_t>(camera.height()));
  base::ParallelFor(camera.height(), threads, [&](int64_t v) {
    const size_t row = static_cast<size_t>(v) * width;
    for (size_t u = 0; u < width; ++u) {
      rays_[row + u] =
          camera.Unproject({static_cast<double>(u), static_cast<double>(v)});
    }
  });
}

void SurfaceConsistency::Associate(const camera::RgbdCalibration& calibration,
                                   int threads) {
  SetCalibration(calibration, threads);
  base::ParallelFor(pairs(), threads, [&](int64_t i) {
    AssociatePair(pairs_[static_cast<size_t>(i)]);
  });
}

void SurfaceConsistency::AssociatePair(Pair& pair) const {
  const PosedDepth& from = frames_[pair.from];
  const PosedDepth& to = frames_[pair.to];
  const geometry::Rigid3 to_from = WorldFromDepth(to, calibration_).Inverse() *
                                   WorldFromDepth(from, calibration_);
  pair.partners.assign(pair.pixels.size(), Partner{});
  for (size_t i = 0; i < pair.pixels.size(); ++i) {
    const int pixel = static_cast<int>(pair.pixels[i]);
    const auto point =
        DepthPoint(from, calibration_, pixel, rays_[pair.pixels[i]]);
    if (!point) continue;
    const geometry::Vec3 moved = to_from * *point;
    if (moved.z <= 0.1) continue;
    const camera::Pixel p = calibration_.depth.Project(moved);
    if (!(std::abs(p.x) < 1e5 && std::abs(p.y) < 1e5)) continue;
    const int u = static_cast<int>(std::lround(p.x));
    const int v = static_cast<int>(std::lround(p.y));
    const auto surface = SurfaceAt(to, calibration_, rays_, u, v);
    if (!surface) continue;
    pair.partners[i] = {v * to.depth.width + u, surface->normal};
  }
}

void SurfaceConsistency::PairResiduals(
    const Pair& pair, std::span<const camera::RgbdCalibration> calibrations,
    std::span<double> residuals) const {
  const PosedDepth& from = frames_[pair.from];
  const PosedDepth& to = frames_[pair.to];
  std::vector<Motion> motions;
  for (const camera::RgbdCalibration& calibration : calibrations) {
    const geometry::Rigid3 to_from = WorldFromDepth(to, calibration).Inverse() *
                                     WorldFromDepth(from, calibration);
    motions.push_back({to_from.rotation.Matrix(),
                       to_from.translation / calibration.depth_scale,
                       calibration.depth == calibration_.depth});
  }
  for (size_t i = 0; i < pair.pixels.size(); ++i) {
    const std::span<double> of_point =
        residuals.subspan(i * motions.size(), motions.size());
    const Partner& partner = pair.partners[i];
    if (partner.pixel < 0) continue;
    const Ray& known = rays_[pair.pixels[i]];
    const Ray& partner_known = rays_[static_cast<size_t>(partner.pixel)];
    if (!known || !partner_known) continue;
    // In measured units: a larger scale must not look better (or worse) for
    // its own sake, as it would where the camera only turns.
    const double from_z = MeasuredDepth_m(from, pair.pixels[i]);
    const double to_z =
        MeasuredDepth_m(to, static_cast<uint32_t>(partner.pixel));
    const double weight = 1 / std::hypot(features::DepthSigma_m(from_z),
                                         features::DepthSigma_m(to_z));
    const NearbyRay ray(calibration_.depth, pair.pixels[i], *known);
    const NearbyRay partner_ray(calibration_.depth,
                                static_cast<uint32_t>(partner.pixel),
                                *partner_known);
    for (size_t k = 0; k < motions.size(); ++k) {
      const Motion& motion = motions[k];
      const camera::Camera& camera = calibrations[k].depth;
      const camera::Pixel a =
          motion.has_known_rays ? *known : ray.Through(camera);
      const camera::Pixel b =
          motion.has_known_rays ? *partner_known : partner_ray.Through(camera);
      const geometry::Vec3 moved =
          motion.rotation * geometry::Vec3{from_z * a.x, from_z * a.y, from_z} +
          motion.translation;
      const geometry::Vec3 surface{to_z * b.x, to_z * b.y, to_z};
      of_point[k] = weight * geometry::Dot(partner.normal, moved - surface);
    }
  }
}

void SurfaceConsistency::Residuals(
    std::span<const camera::RgbdCalibration> calibrations, int threads,
    std::vector<double>& residuals) const {
  std::vector<size_t> first;
  size_t points = 0;
  for (const Pair& pair : pairs_) {
    first.push_back(points);
    points += pair.pixels.size();
  }
  residuals.assign(points * calibrations.size(), 0);
  base::ParallelFor(pairs(), threads, [&](int64_t p) {
    const Pair& pair = pairs_[static_cast<size_t>(p)];
    PairResiduals(pair, calibrations,
                  std::span(residuals).subspan(
                      first[static_cast<size_t>(p)] * calibrations.size(),
                      pair.pixels.size() * calibrations.size()));
  });
}

double SurfaceConsistency::Rms_m(double cutoff_m) const {
  double squares = 0;
  int64_t count = 0;
  for (const Pair& pair : pairs_) {
    const PosedDepth& from = frames_[pair.from];
    const PosedDepth& to = frames_[pair.to];
    const geometry::Rigid3 to_from =
        WorldFromDepth(to, calibration_).Inverse() *
        WorldFromDepth(from, calibration_);
    for (size_t i = 0; i < pair.pixels.size(); ++i) {
      const Partner& partner = pair.partners[i];
      if (partner.pixel < 0) continue;
      const auto point =
          DepthPoint(from, calibration_, static_cast<int>(pair.pixels[i]),
                     rays_[pair.pixels[i]]);
      const auto surface =
          DepthPoint(to, calibration_, partner.pixel,
                     rays_[static_cast<size_t>(partner.pixel)]);
      if (!point || !surface) continue;
      const double distance =
          geometry::Dot(partner.normal, to_from * *point - *surface) /
          calibration_.depth_scale;
      if (std::abs(distance) > cutoff_m) continue;
      squares += distance * distance;
      ++count;
    }
  }
  return count == 0 ? 0 : std::sqrt(squares / static_cast<double>(count));
}

}  // namespace treeline::training
