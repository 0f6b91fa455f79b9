#include "server/core/pose/preemptive_ransac.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "common/geometry/kabsch.h"

namespace treeline::pose {
namespace {

// Refits to all points' inliers once one hypothesis is left.
constexpr int kFinalRefits = 3;

// A prediction along a line is free up to this distance (20 cm), squared.
constexpr float kMaxSlide2_m2 = 0.04f;

// Points and best predictions as separate float arrays: scoring a hypothesis
// is then a loop that compilers vectorise.
struct PackedPoints {
  explicit PackedPoints(const ScenePredictions& scene) {
    const size_t n = scene.size();
    for (std::vector<float>* v : {&cx, &cy, &cz, &wx, &wy, &wz}) v->resize(n);
    for (size_t i = 0; i < n; ++i) {
      const geometry::Vec3& c = scene.point_in_camera[i];
      const geometry::Vec3& w = scene.at(i, 0).mean_in_world;
      cx[i] = static_cast<float>(c.x);
      cy[i] = static_cast<float>(c.y);
      cz[i] = static_cast<float>(c.z);
      wx[i] = static_cast<float>(w.x);
      wy[i] = static_cast<float>(w.y);
      wz[i] = static_cast<float>(w.z);
    }
    if (!scene.has_lines()) return;
    for (std::vector<float>* v : {&dx, &dy, &dz}) v->resize(n);
    for (size_t i = 0; i < n; ++i) {
      const geometry::Vec3& d = scene.line_direction_in_camera[i];
      dx[i] = static_cast<float>(d.x);
      dy[i] = static_cast<float>(d.y);
      dz[i] = static_cast<float>(d.z);
    }
  }
  std::vector<float> cx, cy, cz, wx, wy, wz;
  // Directions of the points' lines, zero for points on none; empty if all are.
  std::vector<float> dx, dy, dz;
};

struct Hypothesis {
  geometry::Rigid3 world_from_camera;
  double energy = 0;
};

// Sum over points [begin, end) of min(1, |residual|^2 / inlier_distance^2),
// where of points on lines the residual across the line counts.
template <bool kLines>
double TruncatedSum(const PackedPoints& p, const geometry::Rigid3& pose,
                    double inlier_distance_m, size_t begin, size_t end) {
  const geometry::Mat3 r = pose.rotation.Matrix();
  float m[9];
  for (size_t i = 0; i < 9; ++i) m[i] = static_cast<float>(r.m[i]);
  const float tx = static_cast<float>(pose.translation.x);
  const float ty = static_cast<float>(pose.translation.y);
  const float tz = static_cast<float>(pose.translation.z);
  const float scale =
      static_cast<float>(1 / (inlier_distance_m * inlier_distance_m));
  // Eight partial sums in a fixed order: vectorisable, and the same on every
  // machine.
  float sums[8] = {};
  for (size_t base = begin; base < end; base += 8) {
    const size_t count = std::min<size_t>(8, end - base);
    for (size_t lane = 0; lane < count; ++lane) {
      const size_t i = base + lane;
      const float dx =
          m[0] * p.cx[i] + m[1] * p.cy[i] + m[2] * p.cz[i] + tx - p.wx[i];
      const float dy =
          m[3] * p.cx[i] + m[4] * p.cy[i] + m[5] * p.cz[i] + ty - p.wy[i];
      const float dz =
          m[6] * p.cx[i] + m[7] * p.cy[i] + m[8] * p.cz[i] + tz - p.wz[i];
      float squared = dx * dx + dy * dy + dz * dz;
      if constexpr (kLines) {
        const float lx = p.dx[i];
        const float ly = p.dy[i];
        const float lz = p.dz[i];
        const float along = dx * (m[0] * lx + m[1] * ly + m[2] * lz) +
                            dy * (m[3] * lx + m[4] * ly + m[5] * lz) +
                            dz * (m[6] * lx + m[7] * ly + m[8] * lz);
        squared =
            std::max(0.0f, squared - std::min(along * along, kMaxSlide2_m2));
      }
      sums[lane] += std::min(1.0f, squared * scale);
    }
  }
  double energy = 0;
  for (float sum : sums) energy += static_cast<double>(sum);
  return energy;
}

double TruncatedEnergy(const PackedPoints& points, const geometry::Rigid3& pose,
                       double inlier_distance_m, size_t begin, size_t end) {
  return points.dx.empty()
             ? TruncatedSum<false>(points, pose, inlier_distance_m, begin, end)
             : TruncatedSum<true>(points, pose, inlier_distance_m, begin, end);
}

std::optional<geometry::Rigid3> DrawHypothesis(const ScenePredictions& scene,
                                               const RansacOptions& options,
                                               uint64_t index) {
  base::Random random(options.seed, 0x7270000000000000 + index);
  const uint32_t n = static_cast<uint32_t>(scene.size());
  for (int draw = 0; draw < options.draws; ++draw) {
    size_t corner[3];
    for (size_t& c : corner) c = random.NextBelow(n);
    bool consistent = true;
    for (int a = 0; a < 3 && consistent; ++a) {
      const size_t i = corner[a];
      const size_t j = corner[(a + 1) % 3];
      const double side =
          geometry::Norm(scene.point_in_camera[i] - scene.point_in_camera[j]);
      if (side < options.min_side_m) {
        consistent = false;
        break;
      }
      const double predicted = geometry::Norm(scene.at(i, 0).mean_in_world -
                                              scene.at(j, 0).mean_in_world);
      consistent = std::abs(side - predicted) <= options.side_tolerance_m;
    }
    if (!consistent) continue;
    geometry::Kabsch kabsch;
    for (size_t c : corner) {
      kabsch.Add(scene.at(c, 0).mean_in_world, scene.point_in_camera[c]);
    }
    if (std::optional<geometry::Rigid3> pose = kabsch.Solve()) return pose;
  }
  return std::nullopt;
}

// Kabsch on the inliers among points [0, end); the pose as it was if that has
// no solution.
RansacResult Refit(const ScenePredictions& scene, const geometry::Rigid3& pose,
                   double inlier_distance_m, size_t end) {
  geometry::Kabsch kabsch;
  int inliers = 0;
  for (size_t i = 0; i < end; ++i) {
    const geometry::Vec3& world = scene.at(i, 0).mean_in_world;
    const geometry::Vec3& camera = scene.point_in_camera[i];
    if (geometry::SquaredNorm(pose * camera - world) <=
        inlier_distance_m * inlier_distance_m) {
      kabsch.Add(world, camera);
      ++inliers;
    }
  }
  return {kabsch.Solve().value_or(pose), inliers};
}

// A survivor of a pruning, fitted to points [0, end).
geometry::Rigid3 Refitted(const ScenePredictions& scene,
                          const geometry::Rigid3& pose,
                          const RansacOptions& options, size_t end,
                          size_t alive) {
  if (options.refinement && alive <= static_cast<size_t>(options.refined)) {
    RefinementOptions refinement = *options.refinement;
    refinement.max_points = end;
    const std::optional<RefinedPose> refined =
        RefineRigid(scene, pose, refinement);
    if (refined) return refined->world_from_camera;
  }
  return Refit(scene, pose, options.inlier_distance_m, end).world_from_camera;
}

// Scores block after block and keeps the better half each time, until one
// hypothesis is left or all points are seen.
void Prune(const ScenePredictions& scene, const PackedPoints& points,
           const RansacOptions& options, const std::stop_token& stop,
           std::vector<Hypothesis>& alive) {
  const auto better = [](const Hypothesis& a, const Hypothesis& b) {
    return a.energy < b.energy;
  };
  size_t seen = 0;
  while (alive.size() > 1 && seen < scene.size() && !stop.stop_requested()) {
    const size_t end =
        std::min(scene.size(), seen + static_cast<size_t>(options.block));
    for (Hypothesis& h : alive) {
      h.energy += TruncatedEnergy(points, h.world_from_camera,
                                  options.inlier_distance_m, seen, end);
    }
    seen = end;
    std::stable_sort(alive.begin(), alive.end(), better);
    alive.resize((alive.size() + 1) / 2);
    for (Hypothesis& h : alive) {
      h.world_from_camera =
          Refitted(scene, h.world_from_camera, options, seen, alive.size());
      h.energy = TruncatedEnergy(points, h.world_from_camera,
                                 options.inlier_distance_m, 0, seen);
    }
  }
  std::stable_sort(alive.begin(), alive.end(), better);
}

}  // namespace

std::optional<RansacResult> PreemptiveRansac(const ScenePredictions& scene,
                                             const RansacOptions& options,
                                             const std::stop_token& stop) {
  if (scene.size() < 3) return std::nullopt;
  std::vector<Hypothesis> alive;
  for (int h = 0; h < options.hypotheses; ++h) {
    if (stop.stop_requested()) return std::nullopt;
    if (auto pose = DrawHypothesis(scene, options, static_cast<uint64_t>(h))) {
      alive.push_back({*pose, 0});
    }
  }
  if (alive.empty()) return std::nullopt;
  Prune(scene, PackedPoints(scene), options, stop, alive);
  if (stop.stop_requested()) return std::nullopt;
  RansacResult result{alive.front().world_from_camera, 0};
  if (options.refinement) {
    result.inliers = Refit(scene, result.world_from_camera,
                           options.inlier_distance_m, scene.size())
                         .inliers;
    return result;
  }
  for (int i = 0; i < kFinalRefits; ++i) {
    result = Refit(scene, result.world_from_camera, options.inlier_distance_m,
                   scene.size());
  }
  return result;
}

}  // namespace treeline::pose
