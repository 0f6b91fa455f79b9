#include "nav_agent/calibration/calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"
#include "nav_agent/calibration/noise_model.h"
#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

using Vector = Eigen::Matrix<double, kQuantities, 1>;
using Matrix = Eigen::Matrix<double, kQuantities, kQuantities>;
using Rows = Eigen::Matrix<double, 3, kQuantities>;

constexpr int kIterations = 40;
constexpr double kMadToSigma = 1.4826;

Vector ToVector(const Setup& setup) {
  Vector v;
  for (int i = 0; i < kQuantities; ++i) {
    v[i] = ValueOf(setup, static_cast<Quantity>(i));
  }
  return v;
}

Setup ToSetup(const Vector& v) {
  Setup setup;
  for (int i = 0; i < kQuantities; ++i) {
    SetValue(setup, static_cast<Quantity>(i), v[i]);
  }
  return setup;
}

// The laser's motion by the wheels.
std::optional<geometry::Rigid2> Predicted(const WheelPath& path,
                                          const Setup& setup,
                                          const LaserMotion& motion) {
  const auto base =
      path.Motion(motion.begin_s - setup.laser_delay_s,
                  motion.end_s - setup.laser_delay_s, setup.wheels);
  if (!base) return std::nullopt;
  return setup.base_from_laser.Inverse() * *base * setup.base_from_laser;
}

Eigen::Vector3d Difference(const geometry::Rigid2& a,
                           const geometry::Rigid2& b) {
  return {a.translation.x - b.translation.x, a.translation.y - b.translation.y,
          geometry::NormalizedAngle_rad(a.yaw_rad - b.yaw_rad)};
}

Eigen::Matrix3d Whitening(const mapping::Covariance3& c, double scale_m,
                          double scale_rad) {
  Eigen::Matrix3d m;
  m << c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8];
  const Eigen::Vector3d scale(scale_m, scale_m, scale_rad);
  m = scale.asDiagonal() * m * scale.asDiagonal();
  const Eigen::Matrix3d lower = Eigen::LLT<Eigen::Matrix3d>(m).matrixL();
  return lower.triangularView<Eigen::Lower>().solve(
      Eigen::Matrix3d::Identity());
}

Vector PriorSigmas(double track_m) {
  Vector v;
  v << kPriorScale, kPriorScale, kPriorScale * track_m, kPriorMount_m,
      kPriorMount_m, kPriorYaw_rad, kPriorDelay_s;
  return v;
}

Vector Steps() {
  Vector v;
  v << 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 4e-3;
  return v;
}

// One stretch at a setup: whitened.
struct Row {
  bool is_there = false;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  Rows jacobian = Rows::Zero();
  // From metres and radians.
  Eigen::Matrix3d whitening = Eigen::Matrix3d::Zero();
  double weight = 0;
};

struct Normal {
  Matrix h = Matrix::Zero();
  Vector g = Vector::Zero();
  double cost = 0;
};

double CauchyCost(double squared) {
  const double c2 = kCauchySigmas * kCauchySigmas;
  return 0.5 * c2 * std::log1p(squared / c2);
}
double CauchyWeight(double squared) {
  return 1 / (1 + squared / (kCauchySigmas * kCauchySigmas));
}

// Of a stretch that is not in the readings: no solution is better for that.
const double kMissingCost = CauchyCost(100);

class Fit {
 public:
  Fit(const WheelPath& path, std::span<const LaserMotion> motions,
      const Setup& prior, bool shows_delay)
      : path_(path),
        motions_(motions),
        prior_(ToVector(prior)),
        quantities_(shows_delay ? kQuantities : kQuantities - 1) {
    const Vector sigmas = PriorSigmas(prior.wheels.track_m);
    prior_precision_ = sigmas.cwiseInverse().cwiseAbs2();
    SetScales(1, 1);
  }

  void SetScales(double scale_m, double scale_rad) {
    whitening_.clear();
    for (const LaserMotion& motion : motions_) {
      whitening_.push_back(Whitening(motion.covariance, scale_m, scale_rad));
    }
  }

  Vector Solve(Vector at) const {
    double damping = 1e-4;
    Normal normal = NormalAt(at, RowsAt(at));
    for (int i = 0; i < kIterations; ++i) {
      Matrix damped = normal.h;
      damped.diagonal() *= 1 + damping;
      const Vector step = damped.ldlt().solve(-normal.g);
      const Vector next = at + step;
      if (!IsSane(next)) {
        damping *= 10;
        continue;
      }
      if (CostAt(next) < normal.cost) {
        at = next;
        normal = NormalAt(at, RowsAt(at));
        damping = std::max(damping / 10, 1e-12);
      } else {
        damping *= 10;
      }
      if (damping > 1e8 ||
          (step.array() / Steps().array()).abs().maxCoeff() < 1e-3) {
        break;
      }
    }
    return at;
  }

  std::vector<Row> RowsAt(const Vector& at) const {
    std::vector<Row> rows(motions_.size());
    const Vector steps = Steps();
    const Setup setup = ToSetup(at);
    for (size_t i = 0; i < motions_.size(); ++i) {
      const auto predicted = Predicted(path_, setup, motions_[i]);
      if (!predicted) continue;
      Row row;
      row.is_there = true;
      row.whitening = whitening_[i];
      row.residual =
          whitening_[i] * Difference(*predicted, motions_[i].begin_from_end);
      for (int q = 0; q < quantities_; ++q) {
        Vector up = at;
        Vector down = at;
        up[q] += steps[q];
        down[q] -= steps[q];
        const auto a = Predicted(path_, ToSetup(up), motions_[i]);
        const auto b = Predicted(path_, ToSetup(down), motions_[i]);
        row.is_there = row.is_there && a.has_value() && b.has_value();
        if (!row.is_there) break;
        row.jacobian.col(q) =
            whitening_[i] * Difference(*a, *b) / (2 * steps[q]);
      }
      row.weight = CauchyWeight(row.residual.squaredNorm());
      if (row.is_there) rows[i] = row;
    }
    return rows;
  }

  Normal NormalAt(const Vector& at, std::span<const Row> rows) const {
    Normal normal;
    normal.h.diagonal() = prior_precision_;
    normal.g = prior_precision_.cwiseProduct(at - prior_);
    normal.cost = PriorCost(at);
    for (const Row& row : rows) {
      if (!row.is_there) {
        normal.cost += kMissingCost;
        continue;
      }
      normal.h += row.weight * row.jacobian.transpose() * row.jacobian;
      normal.g += row.weight * row.jacobian.transpose() * row.residual;
      normal.cost += CauchyCost(row.residual.squaredNorm());
    }
    return normal;
  }

 private:
  bool IsSane(const Vector& at) const {
    return at.allFinite() && at[0] > 0.1 && at[1] > 0.1 && at[2] > 0.02 &&
           std::abs(at[6]) < 2;
  }
  double PriorCost(const Vector& at) const {
    return 0.5 * prior_precision_.dot((at - prior_).cwiseAbs2());
  }
  double CostAt(const Vector& at) const {
    double cost = PriorCost(at);
    const Setup setup = ToSetup(at);
    for (size_t i = 0; i < motions_.size(); ++i) {
      const auto predicted = Predicted(path_, setup, motions_[i]);
      if (!predicted) {
        cost += kMissingCost;
        continue;
      }
      cost += CauchyCost(
          (whitening_[i] * Difference(*predicted, motions_[i].begin_from_end))
              .squaredNorm());
    }
    return cost;
  }

  const WheelPath& path_;
  std::span<const LaserMotion> motions_;
  const Vector prior_;
  // The delay is the last.
  const int quantities_;
  Vector prior_precision_;
  std::vector<Eigen::Matrix3d> whitening_;
};

// Residuals' scale beside what matching says, without outliers.
std::pair<double, double> ScalesOf(std::span<const Row> rows) {
  std::vector<double> m;
  std::vector<double> rad;
  for (const Row& row : rows) {
    if (!row.is_there) continue;
    m.push_back(std::abs(row.residual[0]));
    m.push_back(std::abs(row.residual[1]));
    rad.push_back(std::abs(row.residual[2]));
  }
  return {std::max(0.05, kMadToSigma * base::Quantile(m, 0.5)),
          std::max(0.05, kMadToSigma * base::Quantile(rad, 0.5))};
}

// Where the laser looks, at a first look: how the directions differ into which
// base and laser moved in motions that are nearly straight. As assumed if there
// are none.
double FirstYaw_rad(const WheelPath& path, std::span<const LaserMotion> motions,
                    const Setup& assumed) {
  geometry::Vec2 sum;
  for (const LaserMotion& motion : motions) {
    const auto base = path.Motion(motion.begin_s, motion.end_s, assumed.wheels);
    if (!base || std::abs(base->yaw_rad) > 0.1) continue;
    const geometry::Vec2 b = base->translation;
    const geometry::Vec2 l = motion.begin_from_end.translation;
    // b is R l.
    sum = sum + geometry::Vec2{geometry::Dot(l, b), geometry::Cross(l, b)};
  }
  return geometry::Norm(sum) < 1 ? assumed.base_from_laser.yaw_rad
                                 : std::atan2(sum.y, sum.x);
}

struct Solution {
  Vector at;
  Matrix covariance;
  std::vector<Row> rows;
};

// What an error that all matches share does to the quantities.
Matrix CovarianceOfBias(std::span<const Row> rows, const Matrix& inverse) {
  Eigen::Matrix<double, kQuantities, 3> sum;
  sum.setZero();
  for (const Row& row : rows) {
    if (row.is_there) {
      sum += row.weight * row.jacobian.transpose() * row.whitening;
    }
  }
  const Eigen::Vector3d bias(kMatchBias_m, kMatchBias_m, kMatchBias_rad);
  const Eigen::Matrix<double, kQuantities, 3> shift =
      inverse * sum * bias.asDiagonal();
  return shift * shift.transpose();
}

// The larger of the two covariances, variance by variance, and what matching is
// biased by.
Matrix CovarianceOf(std::span<const Row> rows, const Normal& normal) {
  const Matrix inverse = normal.h.ldlt().solve(Matrix::Identity());
  double sum = 0;
  double weights = 0;
  std::array<Vector, kBlocks.value> blocks;
  blocks.fill(Vector::Zero());
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    if (!row.is_there) continue;
    sum += row.weight * row.residual.squaredNorm();
    weights += 3 * row.weight;
    blocks[i * blocks.size() / rows.size()] +=
        row.weight * row.jacobian.transpose() * row.residual;
  }
  const double scale =
      std::max(1.0, sum / std::max(weights - kQuantities, 1.0));
  Matrix covariance = scale * inverse;
  Matrix middle = Matrix::Zero();
  for (const Vector& block : blocks) middle += block * block.transpose();
  const double blocks_count = kBlocks.value;
  const Matrix sandwich =
      inverse * middle * inverse * (blocks_count / (blocks_count - 1));
  for (int i = 0; i < kQuantities; ++i) {
    const double grow =
        std::sqrt(std::max(1.0, sandwich(i, i) / covariance(i, i)));
    covariance.row(i) *= grow;
    covariance.col(i) *= grow;
  }
  covariance += CovarianceOfBias(rows, inverse);
  covariance(kQuantities - 1, kQuantities - 1) += kDelayBias_s * kDelayBias_s;
  return covariance;
}

Solution SolveAll(const WheelPath& path, std::span<const LaserMotion> motions,
                  const Setup& assumed, bool shows_delay) {
  Setup start = assumed;
  start.base_from_laser.yaw_rad = FirstYaw_rad(path, motions, assumed);
  Fit fit(path, motions, start, shows_delay);
  Solution solution;
  solution.at = fit.Solve(ToVector(start));
  double scale_m = 1;
  double scale_rad = 1;
  for (int i = 0; i < 2; ++i) {
    const auto [m, rad] = ScalesOf(fit.RowsAt(solution.at));
    scale_m *= m;
    scale_rad *= rad;
    fit.SetScales(scale_m, scale_rad);
    solution.at = fit.Solve(solution.at);
  }
  solution.rows = fit.RowsAt(solution.at);
  solution.covariance =
      CovarianceOf(solution.rows, fit.NormalAt(solution.at, solution.rows));
  return solution;
}

double KnownSigma(Quantity quantity, double track_m) {
  switch (quantity) {
    case Quantity::kLeftScale:
    case Quantity::kRightScale:
      return kKnownScale;
    case Quantity::kTrack:
      return kKnownTrack * track_m;
    case Quantity::kLaserX:
    case Quantity::kLaserY:
      return kKnownMount_m;
    case Quantity::kLaserYaw:
      return kKnownYaw_rad;
    case Quantity::kLaserDelay:
      return kKnownDelay_s;
  }
  return 0;
}

Residuals ResidualsOf(std::span<const Eigen::Vector3d> differences) {
  std::vector<double> m;
  std::vector<double> rad;
  for (const Eigen::Vector3d& d : differences) {
    m.push_back(std::hypot(d[0], d[1]));
    rad.push_back(std::abs(d[2]));
  }
  const base::ErrorSummary in_m = base::Summarize(m);
  const base::ErrorSummary in_rad = base::Summarize(rad);
  return {in_m.median, in_rad.median, in_m.rmse, in_rad.rmse};
}

void Check(const WheelPath& path, const Solution& solution,
           const LaserMotions& found, Calibration& calibration) {
  std::vector<Eigen::Vector3d> before;
  std::vector<Eigen::Vector3d> after;
  for (size_t i = 0; i < found.motions.size(); ++i) {
    const LaserMotion& motion = found.motions[i];
    const auto b = Predicted(path, calibration.assumed, motion);
    const auto a = Predicted(path, calibration.found, motion);
    if (!a || !b || !solution.rows[i].is_there) continue;
    const bool is_outlier = solution.rows[i].residual.norm() > kOutlierSigmas;
    calibration.outliers += is_outlier ? 1 : 0;
    calibration.motions.push_back({motion, *b, *a, is_outlier});
    if (is_outlier) continue;
    before.push_back(Difference(*b, motion.begin_from_end));
    after.push_back(Difference(*a, motion.begin_from_end));
  }
  calibration.before = ResidualsOf(before);
  calibration.after = ResidualsOf(after);
}

// Takes over what is known.
void TakeKnown(const Solution& solution, Calibration& calibration) {
  calibration.found = calibration.assumed;
  for (int i = 0; i < kQuantities; ++i) {
    const auto q = static_cast<Quantity>(i);
    Estimate& estimate = calibration.estimates[static_cast<size_t>(i)];
    estimate.sigma = std::sqrt(solution.covariance(i, i));
    estimate.is_known =
        estimate.sigma < KnownSigma(q, calibration.assumed.wheels.track_m);
    estimate.value =
        estimate.is_known ? solution.at[i] : ValueOf(calibration.assumed, q);
    SetValue(calibration.found, q, estimate.value);
    for (int j = 0; j < kQuantities; ++j) {
      calibration.covariance[static_cast<size_t>(i * kQuantities + j)] =
          solution.covariance(i, j);
    }
  }
}

void HoldOut(const WheelPath& path, const LaserMotions& found, bool shows_delay,
             Calibration& calibration) {
  std::array<std::vector<LaserMotion>, 2> halves;
  const size_t count = found.motions.size();
  for (size_t i = 0; i < count; ++i) {
    halves[(i * kBlocks.value / count) % 2].push_back(found.motions[i]);
  }
  std::vector<Eigen::Vector3d> differences;
  for (size_t half = 0; half < 2; ++half) {
    Calibration of_other;
    of_other.assumed = calibration.assumed;
    TakeKnown(
        SolveAll(path, halves[1 - half], calibration.assumed, shows_delay),
        of_other);
    for (const CheckedMotion& checked : calibration.motions) {
      if (checked.is_outlier ||
          std::none_of(halves[half].begin(), halves[half].end(),
                       [&](const LaserMotion& motion) {
                         return motion.begin_s == checked.laser.begin_s;
                       })) {
        continue;
      }
      const auto p = Predicted(path, of_other.found, checked.laser);
      if (p)
        differences.push_back(Difference(*p, checked.laser.begin_from_end));
    }
  }
  calibration.held_out = ResidualsOf(differences);
}

// Turns by scans against turns by the gyroscope: a line through both.
std::optional<Gyroscope> FitGyroscope(const WheelPath& path,
                                      const Calibration& calibration) {
  if (!path.HasGyroscope(calibration.assumed.wheels.track_m)) {
    return std::nullopt;
  }
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  std::vector<std::array<double, 3>> samples;
  for (const CheckedMotion& checked : calibration.motions) {
    if (checked.is_outlier) continue;
    const double delay_s = calibration.found.laser_delay_s;
    const auto turn = path.GyroscopeTurn_rad(checked.laser.begin_s - delay_s,
                                             checked.laser.end_s - delay_s);
    if (!turn) continue;
    const double time_s = checked.laser.end_s - checked.laser.begin_s;
    const Eigen::Vector2d row(*turn, time_s);
    const double told = checked.laser.begin_from_end.yaw_rad;
    h += row * row.transpose();
    g += row * told;
    samples.push_back({*turn, time_s, told});
  }
  if (samples.size() < static_cast<size_t>(kMinMotions)) return std::nullopt;
  const Eigen::Vector2d at = h.ldlt().solve(g);
  double squares = 0;
  for (const auto& [turn, time_s, told] : samples) {
    const double e = told - at[0] * turn - at[1] * time_s;
    squares += e * e;
  }
  const Eigen::Matrix2d covariance =
      squares / static_cast<double>(samples.size() - 2) * h.inverse();
  const double scale_sigma = std::sqrt(covariance(0, 0));
  const double bias_sigma = std::sqrt(covariance(1, 1));
  if (!std::isfinite(scale_sigma) || !std::isfinite(bias_sigma)) {
    return std::nullopt;
  }
  return Gyroscope{{at[0], scale_sigma, scale_sigma < kKnownScale},
                   {at[1], bias_sigma, true}};
}

std::vector<MotionError> ErrorsOf(const Calibration& calibration) {
  std::vector<MotionError> errors;
  const geometry::Rigid2& mount = calibration.found.base_from_laser;
  for (const CheckedMotion& checked : calibration.motions) {
    if (checked.is_outlier) continue;
    const geometry::Rigid2 by_scans =
        mount * checked.laser.begin_from_end * mount.Inverse();
    const geometry::Rigid2 by_wheels = mount * checked.after * mount.Inverse();
    const geometry::Rigid2 error = by_scans.Inverse() * by_wheels;
    const double way_m = geometry::Norm(by_wheels.translation);
    const double course_rad =
        std::atan2(by_wheels.translation.y, by_wheels.translation.x) -
        by_wheels.yaw_rad;
    errors.push_back({way_m, by_wheels.yaw_rad,
                      geometry::Dot(error.translation, {std::cos(course_rad),
                                                        std::sin(course_rad)}),
                      error.yaw_rad});
  }
  return errors;
}

double FitsTolerance(Quantity quantity, double track_m) {
  switch (quantity) {
    case Quantity::kLeftScale:
    case Quantity::kRightScale:
      return kFitsScale;
    case Quantity::kTrack:
      return kFitsScale * track_m;
    case Quantity::kLaserX:
    case Quantity::kLaserY:
      return kFitsMount_m;
    case Quantity::kLaserYaw:
      return kFitsYaw_rad;
    case Quantity::kLaserDelay:
      return kFitsDelay_s;
  }
  return 0;
}

}  // namespace

Calibration CalibrateFromMotions(const WheelPath& path, const Setup& assumed,
                                 const LaserMotions& motions,
                                 bool shows_delay) {
  Calibration calibration;
  calibration.assumed = assumed;
  calibration.stretches = motions.stretches;
  calibration.unmatched = motions.unmatched;
  calibration.disagreed = motions.disagreed;
  const Solution solution =
      SolveAll(path, motions.motions, assumed, shows_delay);
  TakeKnown(solution, calibration);
  Check(path, solution, motions, calibration);
  HoldOut(path, motions, shows_delay, calibration);
  calibration.gyroscope = FitGyroscope(path, calibration);
  const auto noise = FitNoise(ErrorsOf(calibration));
  calibration.has_noise = noise.has_value();
  if (noise) calibration.noise = *noise;
  return calibration;
}

absl::StatusOr<Calibration> Calibrate(const Drive& drive, const Setup& assumed,
                                      std::stop_token stop) {
  const WheelPath path(drive.readings, drive.longest_gap_s);
  TL_ASSIGN_OR_RETURN(const LaserMotions motions,
                      MeasureLaserMotions(drive, path, std::move(stop)));
  return CalibrateFromMotions(path, assumed, motions, drive.shows_delay);
}

std::vector<Misfit> FindMisfits(const Calibration& calibration) {
  std::vector<Misfit> misfits;
  for (int i = 0; i < kQuantities; ++i) {
    const auto q = static_cast<Quantity>(i);
    const Estimate& estimate = calibration.Of(q);
    const double assumed = ValueOf(calibration.assumed, q);
    const double off =
        q == Quantity::kLaserYaw
            ? std::abs(geometry::NormalizedAngle_rad(estimate.value - assumed))
            : std::abs(estimate.value - assumed);
    const double allowed =
        std::max(kFitsSigmas * estimate.sigma,
                 FitsTolerance(q, calibration.assumed.wheels.track_m));
    if (estimate.is_known && off > allowed) {
      misfits.push_back({q, assumed, estimate.value, estimate.sigma});
    }
  }
  return misfits;
}

}  // namespace treeline::calibration
