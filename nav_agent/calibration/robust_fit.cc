#include "nav_agent/calibration/robust_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/sample_statistics.h"
#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using Index = Eigen::Index;

constexpr int kIterations = 40;
constexpr int kScalings = 2;
constexpr double kMadToSigma = 1.4826;
constexpr double kLeastScale = 0.05;

Index At(size_t i) { return static_cast<Index>(i); }

Vector ToVector(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), At(values.size()));
}

double CauchyCost(double squared) {
  const double c2 = kCauchySigmas * kCauchySigmas;
  return 0.5 * c2 * std::log1p(squared / c2);
}
double CauchyWeight(double squared) {
  return 1 / (1 + squared / (kCauchySigmas * kCauchySigmas));
}
// Of a row that says nothing: no solution is better for that.
double MissingCost() { return CauchyCost(100); }

// One row at some values: in standard deviations.
struct Row {
  bool is_there = false;
  Vector residual;
  Matrix jacobian;
  double weight = 0;
};

struct Normal {
  Matrix h;
  Vector g;
  double cost = 0;
};

class Fit {
 public:
  explicit Fit(const FitProblem& problem)
      : problem_(problem),
        prior_(ToVector(problem.prior)),
        prior_precision_(
            ToVector(problem.prior_sigma).cwiseInverse().cwiseAbs2()) {
    for (const std::vector<double>& covariance : problem.covariances) {
      const Index n = At(problem.size);
      const Matrix m = Eigen::Map<const Matrix>(covariance.data(), n, n);
      const Matrix lower = Eigen::LLT<Matrix>(m).matrixL();
      whitening_.push_back(
          lower.triangularView<Eigen::Lower>().solve(Matrix::Identity(n, n)));
    }
  }

  void Scale(double scale_m, double scale_rad) {
    scale_m_ *= scale_m;
    scale_rad_ *= scale_rad;
  }

  Vector Solve(Vector at) const {
    double damping = 1e-4;
    Normal normal = NormalAt(at, RowsAt(at));
    const Vector steps = ToVector(problem_.step);
    for (int i = 0; i < kIterations && damping < 1e8; ++i) {
      Matrix damped = normal.h;
      damped.diagonal() *= 1 + damping;
      const Vector step = damped.ldlt().solve(-normal.g);
      const Vector next = at + step;
      if (!IsSane(next) || CostAt(next) >= normal.cost) {
        damping *= 10;
      } else {
        at = next;
        normal = NormalAt(at, RowsAt(at));
        damping = std::max(damping / 10, 1e-12);
      }
      if ((step.array() / steps.array()).abs().maxCoeff() < 1e-3) break;
    }
    return at;
  }

  std::vector<Row> RowsAt(const Vector& at) const {
    std::vector<Row> rows(problem_.rows);
    for (size_t i = 0; i < rows.size(); ++i) {
      Row row;
      row.is_there = Residual(i, at, row.residual);
      row.jacobian.setZero(At(problem_.size), at.size());
      for (size_t q = 0; q < problem_.free && row.is_there; ++q) {
        const double step = problem_.step[q];
        Vector up = at;
        Vector down = at;
        up[At(q)] += step;
        down[At(q)] -= step;
        Vector a;
        Vector b;
        row.is_there = Residual(i, up, a) && Residual(i, down, b);
        if (row.is_there) row.jacobian.col(At(q)) = (a - b) / (2 * step);
      }
      if (!row.is_there) continue;
      row.weight = CauchyWeight(row.residual.squaredNorm());
      rows[i] = std::move(row);
    }
    return rows;
  }

  Normal NormalAt(const Vector& at, const std::vector<Row>& rows) const {
    Normal normal;
    normal.h = prior_precision_.asDiagonal();
    normal.g = prior_precision_.cwiseProduct(at - prior_);
    normal.cost = PriorCost(at);
    for (const Row& row : rows) {
      if (!row.is_there) {
        normal.cost += MissingCost();
        continue;
      }
      normal.h += row.weight * row.jacobian.transpose() * row.jacobian;
      normal.g += row.weight * row.jacobian.transpose() * row.residual;
      normal.cost += CauchyCost(row.residual.squaredNorm());
    }
    return normal;
  }

  // A difference of a row in standard deviations.
  Vector Whitened(size_t row, Vector difference) const {
    const Index angle = At(problem_.first_angle);
    difference.head(angle) /= scale_m_;
    difference.tail(difference.size() - angle) /= scale_rad_;
    return whitening_[row] * difference;
  }

 private:
  bool Residual(size_t row, const Vector& at, Vector& residual) const {
    Vector difference(At(problem_.size));
    if (!problem_.difference(
            row, {at.data(), static_cast<size_t>(at.size())},
            {difference.data(), static_cast<size_t>(difference.size())})) {
      return false;
    }
    residual = Whitened(row, std::move(difference));
    return true;
  }
  bool IsSane(const Vector& at) const {
    return at.allFinite() &&
           problem_.is_sane({at.data(), static_cast<size_t>(at.size())});
  }
  double PriorCost(const Vector& at) const {
    return 0.5 * prior_precision_.dot((at - prior_).cwiseAbs2());
  }
  double CostAt(const Vector& at) const {
    double cost = PriorCost(at);
    Vector residual;
    for (size_t i = 0; i < problem_.rows; ++i) {
      cost += Residual(i, at, residual) ? CauchyCost(residual.squaredNorm())
                                        : MissingCost();
    }
    return cost;
  }

  const FitProblem& problem_;
  const Vector prior_;
  const Vector prior_precision_;
  double scale_m_ = 1;
  double scale_rad_ = 1;
  std::vector<Matrix> whitening_;
};

// The scale of residuals beside what their covariances say.
std::pair<double, double> ScalesOf(const std::vector<Row>& rows,
                                   size_t first_angle) {
  std::vector<double> m;
  std::vector<double> rad;
  for (const Row& row : rows) {
    if (!row.is_there) continue;
    for (Index i = 0; i < row.residual.size(); ++i) {
      (i < At(first_angle) ? m : rad).push_back(std::abs(row.residual[i]));
    }
  }
  return {std::max(kLeastScale, kMadToSigma * base::Quantile(m, 0.5)),
          std::max(kLeastScale, kMadToSigma * base::Quantile(rad, 0.5))};
}

// What an error that all rows share does to the unknowns.
Matrix CovarianceOfBias(const Fit& fit, const FitProblem& problem,
                        const std::vector<Row>& rows, const Matrix& inverse) {
  Matrix sum = Matrix::Zero(inverse.rows(), At(problem.size));
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    if (!row.is_there) continue;
    for (Index j = 0; j < sum.cols(); ++j) {
      Vector unit = Vector::Zero(sum.cols());
      unit[j] = problem.bias[static_cast<size_t>(j)];
      sum.col(j) += row.weight * row.jacobian.transpose() *
                    fit.Whitened(i, std::move(unit));
    }
  }
  const Matrix shift = inverse * sum;
  return shift * shift.transpose();
}

Matrix CovarianceOf(const Fit& fit, const FitProblem& problem,
                    const std::vector<Row>& rows, const Matrix& h) {
  const Index unknowns = h.rows();
  const Matrix inverse = h.ldlt().solve(Matrix::Identity(unknowns, unknowns));
  double sum = 0;
  double weights = 0;
  constexpr size_t kParts = kBlocks.value;
  std::vector<Vector> blocks(kParts, Vector::Zero(unknowns));
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    if (!row.is_there) continue;
    sum += row.weight * row.residual.squaredNorm();
    weights += static_cast<double>(problem.size) * row.weight;
    blocks[i * kParts / rows.size()] +=
        row.weight * row.jacobian.transpose() * row.residual;
  }
  const double freedom =
      std::max(weights - static_cast<double>(problem.free), 1.0);
  Matrix covariance = std::max(1.0, sum / freedom) * inverse;
  Matrix middle = Matrix::Zero(unknowns, unknowns);
  for (const Vector& block : blocks) middle += block * block.transpose();
  const double parts = kParts;
  const Matrix sandwich = parts / (parts - 1) * inverse * middle * inverse;
  for (Index i = 0; i < unknowns; ++i) {
    const double grow =
        std::sqrt(std::max(1.0, sandwich(i, i) / covariance(i, i)));
    covariance.row(i) *= grow;
    covariance.col(i) *= grow;
  }
  return covariance + CovarianceOfBias(fit, problem, rows, inverse);
}

}  // namespace

FitSolution SolveRobustly(const FitProblem& problem) {
  Fit fit(problem);
  Vector at = fit.Solve(ToVector(problem.prior));
  for (int i = 0; i < kScalings; ++i) {
    const auto [scale_m, scale_rad] =
        ScalesOf(fit.RowsAt(at), problem.first_angle);
    fit.Scale(scale_m, scale_rad);
    at = fit.Solve(at);
  }
  const std::vector<Row> rows = fit.RowsAt(at);
  const Matrix covariance =
      CovarianceOf(fit, problem, rows, fit.NormalAt(at, rows).h);
  FitSolution solution;
  solution.at.assign(at.data(), at.data() + at.size());
  solution.covariance.assign(covariance.data(),
                             covariance.data() + covariance.size());
  for (const Row& row : rows) {
    solution.norms.push_back(row.is_there ? row.residual.norm() : -1);
  }
  return solution;
}

}  // namespace treeline::calibration
