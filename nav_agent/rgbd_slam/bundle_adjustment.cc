#include "nav_agent/rgbd_slam/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>

#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/rgbd_slam/pose_block.h"

namespace treeline::rgbd_slam {
namespace {

// How a point in a camera's frame differs from a sighting of it.
template <typename T>
void SightingError(const PointSighting& sighting, const Pinhole& pinhole,
                   const T* p, T* residual) {
  const double inverse_sigma = 1 / sighting.sigma_px;
  // A point behind the camera has no image: keep the division finite.
  const T z = p[2] > T(0.05) ? p[2] : T(0.05);
  residual[0] =
      inverse_sigma * (pinhole.fx * p[0] / z + pinhole.cx - sighting.pixel.x);
  residual[1] =
      inverse_sigma * (pinhole.fy * p[1] / z + pinhole.cy - sighting.pixel.y);
  if (sighting.depth_m > 0) {
    residual[2] =
        (p[2] - sighting.depth_m) / FeatureDepthSigma_m(sighting.depth_m);
  } else {
    residual[2] = T(0);
  }
}

class MovingCameraError {
 public:
  MovingCameraError(const PointSighting& sighting, const Pinhole& pinhole)
      : sighting_(sighting), pinhole_(pinhole) {}

  template <typename T>
  bool operator()(const T* camera_from_map, const T* point, T* residual) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera_from_map, point, p);
    for (int i = 0; i < 3; ++i) p[i] += camera_from_map[3 + i];
    SightingError(sighting_, pinhole_, p, residual);
    return true;
  }

 private:
  const PointSighting sighting_;
  const Pinhole pinhole_;
};

class FixedCameraError {
 public:
  FixedCameraError(const PointSighting& sighting, const Pinhole& pinhole,
                   const geometry::Rigid3& camera_from_map)
      : sighting_(sighting),
        pinhole_(pinhole),
        rotation_(camera_from_map.rotation.Matrix()),
        translation_(camera_from_map.translation) {}

  template <typename T>
  bool operator()(const T* point, T* residual) const {
    T p[3];
    for (int i = 0; i < 3; ++i) {
      p[i] = rotation_(i, 0) * point[0] + rotation_(i, 1) * point[1] +
             rotation_(i, 2) * point[2] + translation_[i];
    }
    SightingError(sighting_, pinhole_, p, residual);
    return true;
  }

 private:
  const PointSighting sighting_;
  const Pinhole pinhole_;
  const geometry::Mat3 rotation_;
  const geometry::Vec3 translation_;
};

// Which keyframes move, which hold, and by which landmarks.
struct Selection {
  std::vector<int> moving;
  std::vector<int> fixed;
  std::vector<int> landmarks;
};

// Those with the most sightings among the selected keyframes, at least two.
void LimitLandmarks(const SlamMap& map, int limit, Selection& selection) {
  std::vector<char> is_selected(static_cast<size_t>(map.keyframe_count()), 0);
  for (const int k : selection.moving) is_selected[static_cast<size_t>(k)] = 1;
  for (const int k : selection.fixed) is_selected[static_cast<size_t>(k)] = 1;
  std::vector<std::pair<int, int>> ranked;
  for (const int l : selection.landmarks) {
    int count = 0;
    for (const Sighting& sighting : map.landmark(l).sightings) {
      count += is_selected[static_cast<size_t>(sighting.keyframe)];
    }
    if (count >= 2) ranked.emplace_back(-count, l);
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > static_cast<size_t>(limit)) {
    ranked.resize(static_cast<size_t>(limit));
  }
  selection.landmarks.clear();
  for (const auto& entry : ranked) selection.landmarks.push_back(entry.second);
}

class Bundle {
 public:
  Bundle(const Selection& selection, SlamMap* map)
      : selection_(selection), map_(*map) {
    for (const int k : selection.moving) {
      camera_of_[k] = cameras_.size();
      cameras_.push_back(ToBlock(map->keyframe(k).map_from_camera.Inverse()));
    }
    for (const int k : selection.fixed) {
      fixed_[k] = map->keyframe(k).map_from_camera.Inverse();
    }
    for (const int l : selection.landmarks) {
      const geometry::Vec3 p = map->landmark(l).point_in_map;
      points_.push_back({p.x, p.y, p.z});
    }
  }

  bool Solve(int iterations) {
    ceres::Problem::Options problem_options;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(problem_options);
    ceres::HuberLoss loss(std::sqrt(kMaxSquaredError3));
    const auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (size_t i = 0; i < selection_.landmarks.size(); ++i) {
      ordering->AddElementToGroup(points_[i].data(), 0);
      AddSightings(i, &loss, problem);
    }
    for (PoseBlock& camera : cameras_) {
      if (!problem.HasParameterBlock(camera.data())) continue;
      ordering->AddElementToGroup(camera.data(), 1);
    }
    if (problem.NumResidualBlocks() == 0) return false;
    ceres::Solver::Options options;
    options.linear_solver_type =
        cameras_.size() <= 20 ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = ordering;
    options.max_num_iterations = iterations;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = 1e-4;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary.IsSolutionUsable();
  }

  void Apply() {
    const std::set<int> solved(selection_.landmarks.begin(),
                               selection_.landmarks.end());
    for (size_t i = 0; i < cameras_.size(); ++i) {
      const int k = selection_.moving[i];
      const geometry::Rigid3 map_from_camera = FromBlock(cameras_[i]).Inverse();
      const geometry::Rigid3 new_from_old =
          map_from_camera * map_.keyframe(k).map_from_camera.Inverse();
      map_.keyframe(k).map_from_camera = map_from_camera;
      // Those beyond the limit follow the keyframe that made them.
      for (const int l : map_.keyframe(k).landmarks) {
        if (l == kNoLandmark || solved.contains(l)) continue;
        Landmark& left_out = map_.landmark(l);
        if (left_out.reference != k) continue;
        left_out.point_in_map = new_from_old * left_out.point_in_map;
      }
    }
    for (size_t i = 0; i < points_.size(); ++i) {
      map_.landmark(selection_.landmarks[i]).point_in_map = {
          points_[i][0], points_[i][1], points_[i][2]};
    }
    for (const int l : selection_.landmarks) ForgetOutliers(l);
  }

 private:
  void AddSightings(size_t i, ceres::LossFunction* loss,
                    ceres::Problem& problem) {
    const Landmark& landmark = map_.landmark(selection_.landmarks[i]);
    for (const Sighting& sighting : landmark.sightings) {
      const PointSighting measured = map_.MeasurementOf(sighting);
      if (const auto camera = camera_of_.find(sighting.keyframe);
          camera != camera_of_.end()) {
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<MovingCameraError, 3, 6, 3>(
                new MovingCameraError(measured, map_.pinhole())),
            loss, cameras_[camera->second].data(), points_[i].data());
      } else if (const auto fixed = fixed_.find(sighting.keyframe);
                 fixed != fixed_.end()) {
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<FixedCameraError, 3, 3>(
                new FixedCameraError(measured, map_.pinhole(), fixed->second)),
            loss, points_[i].data());
      }
    }
  }

  void ForgetOutliers(int l) {
    // A landmark that one of the selected keyframes sees wrongly was matched
    // wrongly there; twice the bound, since what was matched was within it.
    const std::vector<Sighting> sightings = map_.landmark(l).sightings;
    for (const Sighting& sighting : sightings) {
      if (!camera_of_.contains(sighting.keyframe)) continue;
      const PointSighting measured = map_.MeasurementOf(sighting);
      const double squared = SquaredError(
          measured, map_.pinhole(),
          map_.keyframe(sighting.keyframe).map_from_camera.Inverse());
      if (squared > 2 * kMaxSquaredError3) map_.RemoveSighting(l, sighting);
    }
  }

  const Selection& selection_;
  SlamMap& map_;
  std::unordered_map<int, size_t> camera_of_;
  std::unordered_map<int, geometry::Rigid3> fixed_;
  std::vector<PoseBlock> cameras_;
  std::vector<std::array<double, 3>> points_;
};

class RelativePoseError {
 public:
  explicit RelativePoseError(const KeyframeEdge& edge)
      : to_from_from_(ToBlock(edge.from_from_to.Inverse())),
        weight_(std::sqrt(static_cast<double>(std::max(1, edge.shared)))) {}

  // The blocks are camera_from_map of both.
  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    // error = to_from_from * from_from_map * map_from_to
    T from_turn[4];
    T to_turn[4];
    T measured_turn[4];
    const T measured[3] = {T(to_from_from_[0]), T(to_from_from_[1]),
                           T(to_from_from_[2])};
    ceres::AngleAxisToQuaternion(from, from_turn);
    ceres::AngleAxisToQuaternion(to, to_turn);
    ceres::AngleAxisToQuaternion(measured, measured_turn);
    T expected[4];
    ceres::QuaternionProduct(measured_turn, from_turn, expected);
    const T back[4] = {to_turn[0], -to_turn[1], -to_turn[2], -to_turn[3]};
    T error[4];
    ceres::QuaternionProduct(expected, back, error);
    T turn[3];
    ceres::QuaternionToAngleAxis(error, turn);
    T shift[3];
    ceres::AngleAxisRotatePoint(measured, from + 3, shift);
    T turned[3];
    ceres::QuaternionRotatePoint(error, to + 3, turned);
    for (size_t i = 0; i < 3; ++i) {
      residual[i] = weight_ / kSigma_rad * turn[i];
      residual[3 + i] =
          weight_ / kSigma_m * (shift[i] + to_from_from_[3 + i] - turned[i]);
    }
    return true;
  }

 private:
  // Of the relative pose that a single landmark would give.
  static constexpr double kSigma_rad = 0.02;
  static constexpr double kSigma_m = 0.05;

  const PoseBlock to_from_from_;
  const double weight_;
};

}  // namespace

absl::Status BundleOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("bundle.window", window, 1, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("bundle.fixed", fixed, 1, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("bundle.landmarks", landmarks, 10, 100000));
  return base::CheckRange("bundle.iterations", iterations, 1, 100);
}

void AdjustLocally(int keyframe, const BundleOptions& options, SlamMap* map) {
  Selection selection{.moving = {keyframe}, .fixed = {}, .landmarks = {}};
  std::vector<Covisible> window = {{keyframe, 0}};
  for (const Covisible& other : map->CovisibleWith(keyframe, 10)) {
    if (static_cast<int>(selection.moving.size()) >= options.window) break;
    selection.moving.push_back(other.keyframe);
    window.push_back(other);
  }
  selection.landmarks = map->LandmarksOf(window, 20000);
  for (const Covisible& other : map->KeyframesThatSee(selection.landmarks, 1)) {
    if (static_cast<int>(selection.fixed.size()) >= options.fixed) break;
    if (std::find(selection.moving.begin(), selection.moving.end(),
                  other.keyframe) == selection.moving.end()) {
      selection.fixed.push_back(other.keyframe);
    }
  }
  if (selection.fixed.empty()) {
    // Something has to stay: the oldest.
    const auto oldest =
        std::min_element(selection.moving.begin(), selection.moving.end());
    selection.fixed.push_back(*oldest);
    selection.moving.erase(oldest);
  }
  LimitLandmarks(*map, options.landmarks, selection);
  Bundle bundle(selection, map);
  if (bundle.Solve(options.iterations)) bundle.Apply();
}

void AdjustSubmap(int submap, const BundleOptions& options, SlamMap* map) {
  Selection selection;
  for (int k = 0; k < map->keyframe_count(); ++k) {
    if (map->keyframe(k).submap != submap) continue;
    (selection.fixed.empty() ? selection.fixed : selection.moving).push_back(k);
  }
  if (selection.moving.empty()) return;
  for (int l = 0; l < map->landmark_count(); ++l) {
    if (!map->landmark(l).is_erased) selection.landmarks.push_back(l);
  }
  LimitLandmarks(*map, options.landmarks, selection);
  Bundle bundle(selection, map);
  if (bundle.Solve(options.iterations)) bundle.Apply();
}

void OptimizeKeyframes(std::span<const KeyframeEdge> edges,
                       std::span<const KeyframeEdge> loops, int submap,
                       int max_iterations, SlamMap* map) {
  const auto count = static_cast<size_t>(map->keyframe_count());
  std::vector<PoseBlock> cameras;
  int first = -1;
  for (int k = 0; k < map->keyframe_count(); ++k) {
    cameras.push_back(ToBlock(map->keyframe(k).map_from_camera.Inverse()));
    if (first < 0 && map->keyframe(k).submap == submap) first = k;
  }
  ceres::Problem problem;
  const auto add = [&](const KeyframeEdge& edge, bool is_loop) {
    if (map->keyframe(edge.from).submap != submap ||
        map->keyframe(edge.to).submap != submap) {
      return;
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<RelativePoseError, 6, 6, 6>(
            new RelativePoseError(edge)),
        is_loop ? new ceres::HuberLoss(5) : nullptr,
        cameras[static_cast<size_t>(edge.from)].data(),
        cameras[static_cast<size_t>(edge.to)].data());
  };
  for (const KeyframeEdge& edge : edges) add(edge, false);
  for (const KeyframeEdge& loop : loops) add(loop, true);
  if (first < 0 || problem.NumResidualBlocks() == 0) return;
  double* const anchor = cameras[static_cast<size_t>(first)].data();
  if (problem.HasParameterBlock(anchor)) {
    problem.SetParameterBlockConstant(anchor);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;
  std::vector<geometry::Rigid3> poses(count);
  for (size_t k = 0; k < count; ++k) {
    poses[k] = problem.HasParameterBlock(cameras[k].data())
                   ? FromBlock(cameras[k]).Inverse()
                   : map->keyframe(static_cast<int>(k)).map_from_camera;
  }
  map->MoveKeyframes(poses);
}

}  // namespace treeline::rgbd_slam
