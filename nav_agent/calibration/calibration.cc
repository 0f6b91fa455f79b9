#include "nav_agent/calibration/calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"
#include "nav_agent/calibration/parameters.h"
#include "nav_agent/calibration/robust_fit.h"

namespace treeline::calibration {
namespace {

std::vector<double> ToNumbers(const Setup& setup) {
  std::vector<double> numbers;
  for (int i = 0; i < kQuantities; ++i) {
    numbers.push_back(ValueOf(setup, static_cast<Quantity>(i)));
  }
  return numbers;
}

Setup ToSetup(std::span<const double> numbers) {
  Setup setup;
  for (int i = 0; i < kQuantities; ++i) {
    SetValue(setup, static_cast<Quantity>(i), numbers[static_cast<size_t>(i)]);
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

// Along x, along y (m), in yaw (rad).
using Difference3 = std::array<double, 3>;

Difference3 Difference(const geometry::Rigid2& a, const geometry::Rigid2& b) {
  return {a.translation.x - b.translation.x, a.translation.y - b.translation.y,
          geometry::NormalizedAngle_rad(a.yaw_rad - b.yaw_rad)};
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

FitSolution SolveAll(const WheelPath& path,
                     std::span<const LaserMotion> motions, const Setup& assumed,
                     bool shows_delay) {
  Setup start = assumed;
  start.base_from_laser.yaw_rad = FirstYaw_rad(path, motions, assumed);
  FitProblem problem;
  problem.rows = motions.size();
  problem.difference = [&](size_t row, std::span<const double> at,
                           std::span<double> difference) {
    const auto predicted = Predicted(path, ToSetup(at), motions[row]);
    if (!predicted) return false;
    const Difference3 d = Difference(*predicted, motions[row].begin_from_end);
    std::copy(d.begin(), d.end(), difference.begin());
    return true;
  };
  for (const LaserMotion& motion : motions) {
    problem.covariances.emplace_back(motion.covariance.begin(),
                                     motion.covariance.end());
  }
  problem.prior = ToNumbers(start);
  problem.prior_sigma = {
      kPriorScale,   kPriorScale,   kPriorScale * assumed.wheels.track_m,
      kPriorMount_m, kPriorMount_m, kPriorYaw_rad,
      kPriorDelay_s};
  problem.step = {1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 4e-3};
  // The delay is the last.
  problem.free =
      static_cast<size_t>(shows_delay ? kQuantities : kQuantities - 1);
  problem.is_sane = [](std::span<const double> at) {
    return at[0] > 0.1 && at[1] > 0.1 && at[2] > 0.02 && std::abs(at[6]) < 2;
  };
  problem.bias = {kMatchBias_m, kMatchBias_m, kMatchBias_rad};
  FitSolution solution = SolveRobustly(problem);
  solution.covariance.back() += kDelayBias_s * kDelayBias_s;
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

Residuals ResidualsOf(std::span<const Difference3> differences) {
  std::vector<double> m;
  std::vector<double> rad;
  for (const Difference3& d : differences) {
    m.push_back(std::hypot(d[0], d[1]));
    rad.push_back(std::abs(d[2]));
  }
  const base::ErrorSummary in_m = base::Summarize(m);
  const base::ErrorSummary in_rad = base::Summarize(rad);
  return {in_m.median, in_rad.median, in_m.rmse, in_rad.rmse};
}

void Check(const WheelPath& path, const FitSolution& solution,
           const LaserMotions& found, Calibration& calibration) {
  std::vector<Difference3> before;
  std::vector<Difference3> after;
  for (size_t i = 0; i < found.motions.size(); ++i) {
    const LaserMotion& motion = found.motions[i];
    const auto b = Predicted(path, calibration.assumed, motion);
    const auto a = Predicted(path, calibration.found, motion);
    if (!a || !b || solution.norms[i] < 0) continue;
    const bool is_outlier = solution.norms[i] > kOutlierSigmas;
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
void TakeKnown(const FitSolution& solution, Calibration& calibration) {
  calibration.found = calibration.assumed;
  for (int i = 0; i < kQuantities; ++i) {
    const auto q = static_cast<Quantity>(i);
    Estimate& estimate = calibration.estimates[static_cast<size_t>(i)];
    estimate.sigma = std::sqrt(
        solution.covariance[static_cast<size_t>(i * kQuantities + i)]);
    estimate.is_known =
        estimate.sigma < KnownSigma(q, calibration.assumed.wheels.track_m);
    estimate.value = estimate.is_known ? solution.at[static_cast<size_t>(i)]
                                       : ValueOf(calibration.assumed, q);
    SetValue(calibration.found, q, estimate.value);
  }
  std::copy(solution.covariance.begin(), solution.covariance.end(),
            calibration.covariance.begin());
}

void HoldOut(const WheelPath& path, const LaserMotions& found, bool shows_delay,
             Calibration& calibration) {
  std::array<std::vector<LaserMotion>, 2> halves;
  const size_t count = found.motions.size();
  for (size_t i = 0; i < count; ++i) {
    halves[(i * kBlocks.value / count) % 2].push_back(found.motions[i]);
  }
  std::vector<Difference3> differences;
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

std::vector<MotionError> ErrorsOf(const WheelPath& path,
                                  const Calibration& calibration) {
  std::vector<MotionError> errors;
  const geometry::Rigid2& mount = calibration.found.base_from_laser;
  const double delay_s = calibration.found.laser_delay_s;
  const bool has_gyroscope =
      path.HasGyroscope(calibration.assumed.wheels.track_m);
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
    double yaw_error_rad = error.yaw_rad;
    if (has_gyroscope) {
      const auto turn = path.GyroscopeTurn_rad(checked.laser.begin_s - delay_s,
                                               checked.laser.end_s - delay_s);
      if (!turn) continue;
      yaw_error_rad = *turn - by_scans.yaw_rad;
    }
    errors.push_back({way_m, by_wheels.yaw_rad,
                      geometry::Dot(error.translation, {std::cos(course_rad),
                                                        std::sin(course_rad)}),
                      yaw_error_rad});
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
  const FitSolution solution =
      SolveAll(path, motions.motions, assumed, shows_delay);
  TakeKnown(solution, calibration);
  Check(path, solution, motions, calibration);
  HoldOut(path, motions, shows_delay, calibration);
  calibration.gyroscope = FitGyroscope(path, calibration);
  const std::vector<MotionError> errors = ErrorsOf(path, calibration);
  calibration.noise = FitNoise(errors);
  if (assumed.noise && calibration.noise) {
    calibration.excess = ExcessOver(*assumed.noise, errors);
  }
  return calibration;
}

absl::StatusOr<Calibration> Calibrate(const Drive& drive, const Setup& assumed,
                                      const std::stop_token& stop) {
  const WheelPath path(drive.readings, drive.longest_gap_s);
  TL_ASSIGN_OR_RETURN(const LaserMotions motions,
                      MeasureLaserMotions(drive, path, stop));
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

std::string NoiseMisfit(const Calibration& calibration) {
  const NoiseExcess& excess = calibration.excess;
  if (std::max(excess.yaw, excess.along) <= kFitsNoise) return "";
  return absl::StrFormat(
      "odometry errs %.1f times (along) and %.1f times (in yaw) as much as the "
      "odometry noise says",
      excess.along, excess.yaw);
}

}  // namespace treeline::calibration
