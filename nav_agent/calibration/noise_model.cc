#include "nav_agent/calibration/noise_model.h"

#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

constexpr double kStep = 1.2;
constexpr double kLargest = 1.0;
// Turns and straight motions, at least.
constexpr int kFewest = 5;

// One channel: an error and the two magnitudes that it may grow with.
struct Sample {
  double error = 0;
  double first = 0;
  double second = 0;
};

double NegativeLogLikelihood(std::span<const Sample> samples, double a,
                             double b) {
  double sum = 0;
  for (const Sample& sample : samples) {
    const double sigma = a * sample.first + b * sample.second;
    const double z = sample.error / sigma;
    sum += std::log(sigma) + 0.5 * z * z;
  }
  return sum;
}

std::pair<double, double> MostLikely(std::span<const Sample> samples) {
  std::pair<double, double> best;
  double least = std::numeric_limits<double>::infinity();
  for (double a = kNoiseFloor; a <= kLargest; a *= kStep) {
    for (double b = kNoiseFloor; b <= kLargest; b *= kStep) {
      const double value = NegativeLogLikelihood(samples, a, b);
      if (value < least) {
        least = value;
        best = {a, b};
      }
    }
  }
  return best;
}

}  // namespace

std::optional<localization::OdometryNoise> FitNoise(
    std::span<const MotionError> errors) {
  std::vector<Sample> yaw;
  std::vector<Sample> along;
  int turns = 0;
  int straight = 0;
  for (const MotionError& error : errors) {
    const double turn_rad = std::abs(error.turn_rad);
    if (turn_rad > 0.5 * kWindowTurn_rad) ++turns;
    if (error.way_m > 0.5 * kWindowWay_m && turn_rad < 0.1) ++straight;
    // Of motions of no length there are none; sigma is never 0.
    yaw.push_back({error.yaw_rad, turn_rad + 1e-3, error.way_m + 1e-3});
    along.push_back({error.along_m, error.way_m + 1e-3, turn_rad + 1e-3});
  }
  if (turns < kFewest || straight < kFewest) return std::nullopt;
  localization::OdometryNoise noise;
  std::tie(noise.turn_from_turn, noise.turn_from_drive) = MostLikely(yaw);
  std::tie(noise.drive_from_drive, noise.drive_from_turn) = MostLikely(along);
  return noise;
}

}  // namespace treeline::calibration
