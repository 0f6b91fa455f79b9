#include "server/core/training/surface_consistency.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

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

std::optional<camera::Pixel> RayOf(const camera::Camera& camera, int pixel) {
  return camera.Unproject({static_cast<double>(pixel % camera.width()),
                           static_cast<double>(pixel / camera.width())});
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

std::optional<geometry::Vec3> DepthPoint(
    const PosedDepth& frame, const camera::RgbdCalibration& calibration, int u,
    int v) {
  const image::DepthImage& depth = frame.depth;
  if (u < 0 || v < 0 || u >= depth.width || v >= depth.height) {
    return std::nullopt;
  }
  const int pixel = v * depth.width + u;
  if (!image::IsMeasured(depth.values[static_cast<size_t>(pixel)])) {
    return std::nullopt;
  }
  return DepthPoint(frame, calibration, pixel, RayOf(calibration.depth, pixel));
}

struct SurfacePoint {
  geometry::Vec3 point;
  geometry::Vec3 normal;
};

// The surface at a depth pixel, from its neighbours right, left, below, above.
std::optional<SurfacePoint> SurfaceAt(
    const PosedDepth& frame, const camera::RgbdCalibration& calibration, int u,
    int v) {
  const auto at = [&](int du, int dv) {
    return DepthPoint(frame, calibration, u + du, v + dv);
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
      Pair pair{i, j, {}, {}, {}, {}};
      int overlap = 0;
      for (int k = 0;
           k < 4 * kPointsPerPair && pair.pixels.size() < kPointsPerPair; ++k) {
        const uint32_t pixel = random.NextBelow(
            static_cast<uint32_t>(frames[i].depth.values.size()));
        const int width = frames[i].depth.width;
        const auto from =
            SurfaceAt(frames[i], nominal, static_cast<int>(pixel) % width,
                      static_cast<int>(pixel) / width);
        if (!from) continue;
        pair.pixels.push_back(pixel);
        const geometry::Vec3 moved = to_from * from->point;
        if (moved.z <= 0.1) continue;
        const camera::Pixel p = nominal.depth.Project(moved);
        if (!(std::abs(p.x) < 1e5 && std::abs(p.y) < 1e5)) continue;
        const auto to =
            DepthPoint(frames[j], nominal, static_cast<int>(std::lround(p.x)),
                       static_cast<int>(std::lround(p.y)));
        overlap += to && std::abs(to->z - moved.z) < kOverlapDistance_m;
      }
      if (overlap < kMinOverlap * kPointsPerPair) continue;
      pairs_.push_back(std::move(pair));
      ++found;
    }
  }
}

void SurfaceConsistency::Associate(const camera::RgbdCalibration& calibration) {
  depth_camera_ = calibration.depth;
  for (Pair& pair : pairs_) {
    const PosedDepth& from = frames_[pair.from];
    const PosedDepth& to = frames_[pair.to];
    const geometry::Rigid3 to_from = WorldFromDepth(to, calibration).Inverse() *
                                     WorldFromDepth(from, calibration);
    pair.partners.assign(pair.pixels.size(), Partner{});
    pair.rays.assign(pair.pixels.size(), std::nullopt);
    pair.partner_rays.assign(pair.pixels.size(), std::nullopt);
    for (size_t i = 0; i < pair.pixels.size(); ++i) {
      const int pixel = static_cast<int>(pair.pixels[i]);
      pair.rays[i] = RayOf(depth_camera_, pixel);
      const auto point = DepthPoint(from, calibration, pixel, pair.rays[i]);
      if (!point) continue;
      const geometry::Vec3 moved = to_from * *point;
      if (moved.z <= 0.1) continue;
      const camera::Pixel p = calibration.depth.Project(moved);
      if (!(std::abs(p.x) < 1e5 && std::abs(p.y) < 1e5)) continue;
      const int u = static_cast<int>(std::lround(p.x));
      const int v = static_cast<int>(std::lround(p.y));
      const auto surface = SurfaceAt(to, calibration, u, v);
      if (!surface) continue;
      pair.partners[i] = {v * to.depth.width + u, surface->normal};
      pair.partner_rays[i] = RayOf(depth_camera_, pair.partners[i].pixel);
    }
  }
}

template <typename Visit>
void SurfaceConsistency::VisitPoints(const camera::RgbdCalibration& calibration,
                                     const Visit& visit) const {
  const bool rays_are_known = calibration.depth == depth_camera_;
  size_t slot = 0;
  for (const Pair& pair : pairs_) {
    const PosedDepth& from = frames_[pair.from];
    const PosedDepth& to = frames_[pair.to];
    const geometry::Rigid3 to_from = WorldFromDepth(to, calibration).Inverse() *
                                     WorldFromDepth(from, calibration);
    for (size_t i = 0; i < pair.pixels.size(); ++i) {
      const size_t this_slot = slot++;
      const Partner& partner = pair.partners[i];
      if (partner.pixel < 0) continue;
      const int pixel = static_cast<int>(pair.pixels[i]);
      const auto point = DepthPoint(
          from, calibration, pixel,
          rays_are_known ? pair.rays[i] : RayOf(calibration.depth, pixel));
      const auto surface =
          DepthPoint(to, calibration, partner.pixel,
                     rays_are_known ? pair.partner_rays[i]
                                    : RayOf(calibration.depth, partner.pixel));
      if (!point || !surface) continue;
      // In measured units: a larger scale must not look better (or worse) for
      // its own sake, as it would where the camera only turns.
      const double distance =
          geometry::Dot(partner.normal, to_from * *point - *surface) /
          calibration.depth_scale;
      const double sigma = std::hypot(
          features::DepthSigma_m(point->z / calibration.depth_scale),
          features::DepthSigma_m(surface->z / calibration.depth_scale));
      visit(this_slot, distance, sigma);
    }
  }
}

void SurfaceConsistency::Residuals(const camera::RgbdCalibration& calibration,
                                   std::vector<double>& residuals) const {
  size_t slots = 0;
  for (const Pair& pair : pairs_) slots += pair.pixels.size();
  residuals.assign(slots, 0);
  VisitPoints(calibration, [&](size_t slot, double distance, double sigma) {
    residuals[slot] = distance / sigma;
  });
}

double SurfaceConsistency::Rms_m(const camera::RgbdCalibration& calibration,
                                 double cutoff_m) const {
  double squares = 0;
  int64_t count = 0;
  VisitPoints(calibration, [&](size_t, double distance, double) {
    if (std::abs(distance) > cutoff_m) return;
    squares += distance * distance;
    ++count;
  });
  return count == 0 ? 0 : std::sqrt(squares / static_cast<double>(count));
}

}  // namespace treeline::training
