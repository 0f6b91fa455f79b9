#include "nav_agent/mapping/scan_bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "common/base/parallel_for.h"

namespace treeline::mapping {
namespace {

// Beyond so many standard deviations, surfels are not of one surface.
constexpr double kReach = 3;
// The last deviation is reached after this part of the rounds; they end once
// nothing moves by as much any more.
constexpr double kNarrowing = 0.6;
constexpr double kStill_m = 5e-4;
constexpr double kCauchySigmas = 2;
constexpr int kAlignRounds = 6;
// Surfaces whose normal has more of a pair's untold direction tell nothing.
constexpr double kTold = 0.3;

using Jacobian = std::array<double, 3>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Normal equations of N unknowns.
template <size_t N>
struct Normal {
  std::array<double, N*(N + 1) / 2> upper{};
  std::array<double, N> gradient{};

  void Add(double weight, double residual, const std::array<double, N>& j) {
    size_t k = 0;
    for (size_t r = 0; r < N; ++r) {
      const double wj = weight * j[r];
      gradient[r] += wj * residual;
      for (size_t c = r; c < N; ++c) upper[k++] += wj * j[c];
    }
  }
  Eigen::Matrix<double, N, N> Matrix() const {
    Eigen::Matrix<double, N, N> m;
    size_t k = 0;
    for (size_t r = 0; r < N; ++r) {
      for (size_t c = r; c < N; ++c) {
        const auto row = static_cast<Eigen::Index>(r);
        const auto column = static_cast<Eigen::Index>(c);
        m(row, column) = m(column, row) = upper[k++];
      }
    }
    return m;
  }
};

// Calls add(weight, off_m, j_a, j_b) for each surfel of `a` that lies upon one
// of `b`: how far off it is, and how that changes with both poses.
template <typename Function>
void ForEachUpon(std::span<const Surfel> a, const geometry::Rigid2& map_from_a,
                 const ScanSurfels& b, const geometry::Rigid2& map_from_b,
                 double sigma_m, double min_cosine, const Function& add) {
  const geometry::Rigid2 b_from_a = map_from_b.Inverse() * map_from_a;
  const double c = std::cos(b_from_a.yaw_rad);
  const double s = std::sin(b_from_a.yaw_rad);
  const double cb = std::cos(map_from_b.yaw_rad);
  const double sb = std::sin(map_from_b.yaw_rad);
  const double inverse_2sigma2 = 1 / (2 * sigma_m * sigma_m);
  const double max_off_m = kReach * sigma_m;
  for (const Surfel& p : a) {
    // In b's axes.
    const geometry::Vec2 arm = {c * p.x - s * p.y, s * p.x + c * p.y};
    const geometry::Vec2 at = b_from_a.translation + arm;
    const Surfel* q = b.Near(at);
    if (q == nullptr) continue;
    const geometry::Vec2 normal = {q->normal_x, q->normal_y};
    const geometry::Vec2 own = {c * p.normal_x - s * p.normal_y,
                                s * p.normal_x + c * p.normal_y};
    if (geometry::Dot(own, normal) < min_cosine) continue;
    const double off_m = geometry::Dot(normal, at - geometry::Vec2{q->x, q->y});
    if (std::abs(off_m) > max_off_m) continue;
    const double nx = cb * normal.x - sb * normal.y;
    const double ny = sb * normal.x + cb * normal.y;
    add(std::exp(-off_m * off_m * inverse_2sigma2), off_m,
        Jacobian{nx, ny, geometry::Cross(arm, normal)},
        Jacobian{-nx, -ny, -geometry::Cross(at, normal)});
  }
}

double SigmaOf(int round, const ScanBundleOptions& options) {
  const double part =
      std::min(1.0, static_cast<double>(round) / (kNarrowing * options.rounds));
  return options.first_sigma_m *
         std::pow(options.last_sigma_m / options.first_sigma_m, part);
}

Normal<6> NormalOf(const ScanSurfels& a, const geometry::Rigid2& map_from_a,
                   const ScanSurfels& b, const geometry::Rigid2& map_from_b,
                   geometry::Vec2 untold, double sigma_m, double min_cosine) {
  Normal<6> sum;
  const auto tells = [&](const Jacobian& j) {
    return std::abs(j[0] * untold.x + j[1] * untold.y) <= kTold;
  };
  ForEachUpon(a.surfels(), map_from_a, b, map_from_b, sigma_m, min_cosine,
              [&](double weight, double off_m, const Jacobian& j_a,
                  const Jacobian& j_b) {
                if (!tells(j_a)) return;
                sum.Add(weight, off_m,
                        {j_a[0], j_a[1], j_a[2], j_b[0], j_b[1], j_b[2]});
              });
  ForEachUpon(b.surfels(), map_from_b, a, map_from_a, sigma_m, min_cosine,
              [&](double weight, double off_m, const Jacobian& j_b,
                  const Jacobian& j_a) {
                if (!tells(j_a)) return;
                sum.Add(weight, off_m,
                        {j_a[0], j_a[1], j_a[2], j_b[0], j_b[1], j_b[2]});
              });
  return sum;
}

void AddPrior(const PoseConstraint& prior,
              std::span<const geometry::Rigid2> poses, Matrix6* h, Vector6* g) {
  const geometry::Rigid2& from = poses[static_cast<size_t>(prior.from)];
  const geometry::Rigid2& to = poses[static_cast<size_t>(prior.to)];
  const double c = std::cos(from.yaw_rad);
  const double s = std::sin(from.yaw_rad);
  const geometry::Vec2 d = to.translation - from.translation;
  const Eigen::Vector3d e(
      c * d.x + s * d.y - prior.from_from_to.translation.x,
      -s * d.x + c * d.y - prior.from_from_to.translation.y,
      geometry::NormalizedAngle_rad(to.yaw_rad - from.yaw_rad -
                                    prior.from_from_to.yaw_rad));
  Eigen::Matrix<double, 3, 6> j = Eigen::Matrix<double, 3, 6>::Zero();
  j << -c, -s, -s * d.x + c * d.y, c, s, 0,  //
      s, -c, -c * d.x - s * d.y, -s, c, 0,   //
      0, 0, -1, 0, 0, 1;
  Eigen::Matrix3d covariance;
  for (int i = 0; i < 9; ++i) {
    covariance(i / 3, i % 3) = prior.covariance[static_cast<size_t>(i)];
  }
  Eigen::Matrix3d precision = covariance.inverse();
  if (prior.may_be_wrong) {
    // Cauchy's kernel, two standard deviations wide.
    precision *=
        1 / (1 + e.dot(precision * e) / (kCauchySigmas * kCauchySigmas));
  }
  *h = j.transpose() * precision * j;
  *g = j.transpose() * precision * e;
}

class NormalEquations {
 public:
  explicit NormalEquations(size_t poses)
      : gradient_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * poses))) {
  }

  void Add(int a, int b, const Matrix6& h, const Vector6& g) {
    const std::array<int, 2> of = {3 * a, 3 * b};
    for (int r = 0; r < 6; ++r) {
      const int row = of[static_cast<size_t>(r / 3)] + r % 3;
      gradient_[row] += g[r];
      for (int col = 0; col < 6; ++col) {
        const int column = of[static_cast<size_t>(col / 3)] + col % 3;
        if (row >= column) triplets_.emplace_back(row, column, h(r, col));
      }
    }
  }
  // Empty if there is no solution.
  Eigen::VectorXd Solve() {
    const Eigen::Index size = gradient_.size();
    for (int i = 0; i < 3; ++i) triplets_.emplace_back(i, i, 1e12);
    for (int i = 3; i < size; ++i) triplets_.emplace_back(i, i, 1e-3);
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(triplets_.begin(), triplets_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>
        factor(matrix);
    if (factor.info() != Eigen::Success) return {};
    return factor.solve(-gradient_);
  }

 private:
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::VectorXd gradient_;
};

}  // namespace

bool ScanBundleOptions::IsValid() const {
  return overlap_m > 0 && rounds >= 1 && first_sigma_m > 0 &&
         last_sigma_m > 0 && surfel_sigma_m > 0 && min_cosine < 1 &&
         threads >= 1 && surfels.reach_m > 0 && surfels.min_points >= 2 &&
         surfels.max_off_m > 0 && surfels.spacing_m >= 0;
}

bool AdjustBundle(std::span<const ScanSurfels> scans,
                  std::span<const ScanPair> pairs,
                  std::span<const PoseConstraint> priors,
                  const ScanBundleOptions& options,
                  std::vector<geometry::Rigid2>* map_from_scans) {
  std::vector<geometry::Rigid2> poses = *map_from_scans;
  const double weight = 1 / (options.surfel_sigma_m * options.surfel_sigma_m);
  std::vector<Normal<6>> normals(pairs.size());
  for (int round = 0; round < options.rounds; ++round) {
    const double sigma_m = SigmaOf(round, options);
    base::ParallelFor(
        static_cast<int64_t>(pairs.size()), options.threads, [&](int64_t i) {
          const auto a = static_cast<size_t>(pairs[static_cast<size_t>(i)].a);
          const auto b = static_cast<size_t>(pairs[static_cast<size_t>(i)].b);
          normals[static_cast<size_t>(i)] =
              NormalOf(scans[a], poses[a], scans[b], poses[b],
                       pairs[static_cast<size_t>(i)].untold, sigma_m,
                       options.min_cosine);
        });
    NormalEquations equations(poses.size());
    for (size_t i = 0; i < pairs.size(); ++i) {
      const Vector6 gradient(normals[i].gradient.data());
      equations.Add(pairs[i].a, pairs[i].b, weight * normals[i].Matrix(),
                    weight * gradient);
    }
    for (const PoseConstraint& prior : priors) {
      Matrix6 h;
      Vector6 g;
      AddPrior(prior, poses, &h, &g);
      equations.Add(prior.from, prior.to, h, g);
    }
    const Eigen::VectorXd step = equations.Solve();
    if (step.size() == 0 || !step.allFinite()) return false;
    double largest = 0;
    for (size_t i = 1; i < poses.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(3 * i);
      poses[i].translation.x += step[k];
      poses[i].translation.y += step[k + 1];
      poses[i].yaw_rad =
          geometry::NormalizedAngle_rad(poses[i].yaw_rad + step[k + 2]);
      largest = std::max({largest, std::abs(step[k]), std::abs(step[k + 1])});
    }
    if (round > kNarrowing * options.rounds && largest < kStill_m) break;
  }
  *map_from_scans = std::move(poses);
  return true;
}

geometry::Rigid2 AlignWithBundle(std::span<const Surfel> surfels,
                                 std::span<const PlacedSurfels> others,
                                 const geometry::Rigid2& guess, double sigma_m,
                                 double sigma_rad,
                                 const ScanBundleOptions& options) {
  const Eigen::Matrix3d prior =
      Eigen::Vector3d(1 / (sigma_m * sigma_m), 1 / (sigma_m * sigma_m),
                      1 / (sigma_rad * sigma_rad))
          .asDiagonal();
  const double weight = 1 / (options.surfel_sigma_m * options.surfel_sigma_m);
  geometry::Rigid2 pose = guess;
  for (int round = 0; round < kAlignRounds; ++round) {
    Normal<3> sum;
    for (const PlacedSurfels& other : others) {
      ForEachUpon(surfels, pose, *other.scan, other.map_from_scan,
                  options.last_sigma_m, options.min_cosine,
                  [&](double w, double off_m, const Jacobian& j,
                      const Jacobian&) { sum.Add(w, off_m, j); });
    }
    const Eigen::Vector3d off(
        pose.translation.x - guess.translation.x,
        pose.translation.y - guess.translation.y,
        geometry::NormalizedAngle_rad(pose.yaw_rad - guess.yaw_rad));
    const Eigen::Vector3d gradient(sum.gradient.data());
    const Eigen::Matrix3d precision = weight * sum.Matrix() + prior;
    const Eigen::Vector3d step =
        -precision.llt().solve(weight * gradient + prior * off);
    pose.translation = pose.translation + geometry::Vec2{step.x(), step.y()};
    pose.yaw_rad = geometry::NormalizedAngle_rad(pose.yaw_rad + step.z());
    if (step.head<2>().norm() < kStill_m) break;
  }
  return pose;
}

}  // namespace treeline::mapping
