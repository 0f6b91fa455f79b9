#include "nav_agent/mapping/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::mapping {
namespace {

Eigen::Matrix3d ToMatrix(const Covariance3& c) {
  Eigen::Matrix3d m;
  m << c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8];
  return 0.5 * (m + m.transpose());
}

// W with W^T W = S^-1.
Eigen::Matrix3d Whitening(const Covariance3& covariance) {
  const Eigen::Matrix3d lower =
      Eigen::LLT<Eigen::Matrix3d>(ToMatrix(covariance)).matrixL();
  return lower.triangularView<Eigen::Lower>().solve(
      Eigen::Matrix3d::Identity());
}

template <typename T>
T WrappedAngle(const T& angle) {
  using std::floor;
  constexpr double kTurn = 2 * std::numbers::pi;
  return angle - kTurn * floor((angle + std::numbers::pi) / kTurn);
}

class RelativePose {
 public:
  explicit RelativePose(const PoseConstraint& constraint)
      : measured_(constraint.from_from_to),
        whitening_(Whitening(constraint.covariance)) {}

  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    using std::cos;
    using std::sin;
    const T c = cos(from[2]);
    const T s = sin(from[2]);
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    const T e[3] = {c * dx + s * dy - measured_.translation.x,
                    -s * dx + c * dy - measured_.translation.y,
                    WrappedAngle<T>(to[2] - from[2] - measured_.yaw_rad)};
    for (int i = 0; i < 3; ++i) {
      residual[i] = whitening_(i, 0) * e[0] + whitening_(i, 1) * e[1] +
                    whitening_(i, 2) * e[2];
    }
    return true;
  }

 private:
  const geometry::Rigid2 measured_;
  const Eigen::Matrix3d whitening_;
};

class Climb {
 public:
  explicit Climb(const PoseConstraint& constraint)
      : climb_m_(constraint.climb_m), weight_(1 / constraint.climb_sigma_m) {}

  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    *residual = weight_ * (*to - *from - climb_m_);
    return true;
  }

 private:
  const double climb_m_;
  const double weight_;
};

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.function_tolerance = 1e-7;
  return solver;
}

ceres::LossFunction* LossOf(const PoseConstraint& constraint,
                            const PoseGraphOptions& options) {
  return constraint.may_be_wrong ? new ceres::CauchyLoss(options.kernel_sigmas)
                                 : nullptr;
}

bool IsFinitePose(const geometry::Rigid2& pose) {
  return std::isfinite(pose.translation.x) &&
         std::isfinite(pose.translation.y) && std::isfinite(pose.yaw_rad);
}

absl::Status Check(const PoseConstraint& constraint, size_t poses) {
  const auto is_pose = [poses](int index) {
    return index >= 0 && static_cast<size_t>(index) < poses;
  };
  if (!is_pose(constraint.from) || !is_pose(constraint.to) ||
      constraint.from == constraint.to) {
    return absl::InvalidArgumentError(
        absl::StrCat("a constraint between poses ", constraint.from, " and ",
                     constraint.to, " of ", poses));
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(ToMatrix(constraint.covariance));
  if (!IsFinitePose(constraint.from_from_to) ||
      !ToMatrix(constraint.covariance).allFinite() ||
      factor.info() != Eigen::Success) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the constraint between poses ", constraint.from, " and ",
        constraint.to, " is not finite, or its covariance not positive"));
  }
  return absl::OkStatus();
}

}  // namespace

double SquaredError(const PoseConstraint& constraint,
                    std::span<const geometry::Rigid2> poses) {
  const geometry::Rigid2& from = poses[static_cast<size_t>(constraint.from)];
  const geometry::Rigid2& to = poses[static_cast<size_t>(constraint.to)];
  const double a[3] = {from.translation.x, from.translation.y, from.yaw_rad};
  const double b[3] = {to.translation.x, to.translation.y, to.yaw_rad};
  double e[3] = {};
  const RelativePose error(constraint);
  error(a, b, e);
  return e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
}

Covariance3 Turned(const Covariance3& covariance, double yaw_rad) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  Eigen::Matrix3d turn;
  turn << c, -s, 0, s, c, 0, 0, 0, 1;
  const Eigen::Matrix3d m = turn * ToMatrix(covariance) * turn.transpose();
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1),
          m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

absl::Status OptimizePoseGraph(std::span<const PoseConstraint> constraints,
                               const PoseGraphOptions& options,
                               std::vector<geometry::Rigid2>* map_from_poses) {
  std::vector<std::array<double, 3>> values;
  for (const geometry::Rigid2& pose : *map_from_poses) {
    if (!IsFinitePose(pose)) {
      return absl::InvalidArgumentError("a pose that is not finite");
    }
    values.push_back({pose.translation.x, pose.translation.y, pose.yaw_rad});
  }
  if (values.size() < 2 || constraints.empty()) return absl::OkStatus();
  ceres::Problem problem;
  for (std::array<double, 3>& value : values) {
    problem.AddParameterBlock(value.data(), 3);
  }
  problem.SetParameterBlockConstant(values[0].data());
  for (const PoseConstraint& constraint : constraints) {
    if (absl::Status status = Check(constraint, values.size()); !status.ok()) {
      return status;
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<RelativePose, 3, 3, 3>(
            new RelativePose(constraint)),
        LossOf(constraint, options),
        values[static_cast<size_t>(constraint.from)].data(),
        values[static_cast<size_t>(constraint.to)].data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options), &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return absl::InternalError(
        absl::StrCat("the pose graph was not solved: ", summary.message));
  }
  for (size_t i = 1; i < values.size(); ++i) {
    (*map_from_poses)[i] = {{values[i][0], values[i][1]},
                            geometry::NormalizedAngle_rad(values[i][2])};
  }
  return absl::OkStatus();
}

absl::Status OptimizeHeights(std::span<const PoseConstraint> constraints,
                             const PoseGraphOptions& options,
                             std::vector<double>* heights_m) {
  std::vector<double> values = *heights_m;
  ceres::Problem problem;
  for (const PoseConstraint& constraint : constraints) {
    const auto from = static_cast<size_t>(constraint.from);
    const auto to = static_cast<size_t>(constraint.to);
    if (constraint.from < 0 || constraint.to < 0 || from >= values.size() ||
        to >= values.size() || from == to) {
      return absl::InvalidArgumentError(
          absl::StrCat("a climb between poses ", constraint.from, " and ",
                       constraint.to, " of ", values.size()));
    }
    if (!std::isfinite(constraint.climb_sigma_m)) continue;
    if (!std::isfinite(constraint.climb_m) || !(constraint.climb_sigma_m > 0) ||
        !std::isfinite(values[from]) || !std::isfinite(values[to])) {
      return absl::InvalidArgumentError("a climb that is not finite");
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Climb, 1, 1, 1>(new Climb(constraint)),
        LossOf(constraint, options), &values[from], &values[to]);
  }
  if (problem.NumResidualBlocks() == 0) return absl::OkStatus();
  if (problem.HasParameterBlock(values.data())) {
    problem.SetParameterBlockConstant(values.data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options), &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return absl::InternalError(
        absl::StrCat("heights were not solved: ", summary.message));
  }
  *heights_m = std::move(values);
  return absl::OkStatus();
}

}  // namespace treeline::mapping
