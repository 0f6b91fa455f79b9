// Wheels, track, the laser's place and its delay, from one drive.
#ifndef NAV_AGENT_CALIBRATION_CALIBRATION_H_
#define NAV_AGENT_CALIBRATION_CALIBRATION_H_

#include <array>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/calibration/drive.h"
#include "nav_agent/calibration/laser_motions.h"
#include "nav_agent/calibration/noise_model.h"
#include "nav_agent/calibration/setup.h"
#include "nav_agent/calibration/wheel_path.h"

namespace treeline::calibration {

// A number, one standard deviation of it, and whether this drive shows it: if
// not, `value` is what was assumed.
struct Estimate {
  double value = 0;
  double sigma = 0;
  bool is_known = false;
};

// The yaw rate as a gyroscope tells it: scale * told + bias is the turn.
struct Gyroscope {
  Estimate scale;
  Estimate bias_radps;
};

// What wheels and scans differ by over the stretches, half of them below, and
// the root of the mean square of those that are no outliers.
struct Residuals {
  double median_m = 0;
  double median_rad = 0;
  double rms_m = 0;
  double rms_rad = 0;
};

// One stretch, with what wheels make of it before and after.
struct CheckedMotion {
  LaserMotion laser;
  geometry::Rigid2 before;  // the laser's motion by the wheels, as assumed
  geometry::Rigid2 after;   // and as calibrated
  bool is_outlier = false;
};

struct Calibration {
  Setup assumed;
  // What is not known is as assumed.
  Setup found;
  std::array<Estimate, kQuantities> estimates{};
  // Of found, in Quantity's order, row-major; what is not known has the
  // variance that was left of what is known beforehand.
  std::array<double, kQuantities * kQuantities> covariance{};
  std::optional<Gyroscope> gyroscope;
  // Of wheels as calibrated, and of turns by the gyroscope where there is one:
  // as the robot takes its odometry. Without outliers. An upper bound, as it
  // includes what matching errs. nullopt: turns or straight stretches lack.
  std::optional<NoiseFit> noise;
  // Against assumed.noise; of that, all 0 without it.
  NoiseExcess excess;

  std::vector<CheckedMotion> motions;
  int outliers = 0;
  int stretches = 0;
  int unmatched = 0;
  int disagreed = 0;
  Residuals before;
  Residuals after;
  // Each half of the drive in turn (every second of a dozen blocks), with the
  // setup that the other half gives.
  Residuals held_out;

  const Estimate& Of(Quantity quantity) const {
    return estimates[static_cast<size_t>(quantity)];
  }
};

// The Setup that makes wheels and scans agree best: for each stretch with the
// laser's motion M by its scans, the base's motion O(s_l, s_r, track, delay) by
// the wheels and the mount X = base_from_laser, the error of X^-1 O X against
// M, in standard deviations, is minimised over all stretches with a Cauchy
// kernel, by Levenberg and Marquardt's method. The model is that of A. Censi,
// A. Franchi, L. Marchionni, G. Oriolo, "Simultaneous calibration of odometry
// and sensor parameters for mobile robots", T-RO 29(2), 2013, with the delay
// added and solved iteratively, since his closed form needs motions of which
// the delay is known.
//
// Uncertainty: that of the least squares, scaled by the residuals, or that of
// their sums over kBlocks parts of the drive (a cluster-robust sandwich),
// whichever is larger: errors of neighbouring stretches are not independent. An
// error of kMatchBias_m and kMatchBias_rad that all matches share is added.
// Weak priors (parameters.h) hold what the drive does not show; what is not
// known better than kKnown... is returned as assumed.
//
// The errors of MeasureLaserMotions.
absl::StatusOr<Calibration> Calibrate(const Drive& drive, const Setup& assumed,
                                      const std::stop_token& stop = {});
// The same with the laser's motions at hand, at least kMinMotions of them.
// shows_delay: as Drive has it; else the delay is as assumed.
Calibration CalibrateFromMotions(const WheelPath& path, const Setup& assumed,
                                 const LaserMotions& motions,
                                 bool shows_delay = true);

// One quantity that a recording does not agree with.
struct Misfit {
  Quantity quantity;
  double assumed = 0;
  double found = 0;
  double sigma = 0;
};
// What of `assumed` the drive contradicts: known, and off by more than
// kFitsSigmas of its uncertainty and than kFits... allows.
std::vector<Misfit> FindMisfits(const Calibration& calibration);
// What to say if odometry errs more than assumed.noise says, by more than
// kFitsNoise; empty if not, or if nothing is assumed or measured. A robot that
// errs less is not spoken of.
std::string NoiseMisfit(const Calibration& calibration);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_CALIBRATION_H_
