#include "nav_agent/calibration/noise_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

constexpr double kLargest = core::kMostNoise;
// From the middle to either end, and from there to the next ones.
constexpr double kStep = 1.2;
constexpr int kSteps = 15;
constexpr double kFineStep = 1.03;
constexpr int kFineSteps = 4;
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

// The most likely of a grid: `steps` up and down from the middle.
std::pair<double, double> MostLikelyAbout(std::span<const Sample> samples,
                                          std::pair<double, double> middle,
                                          double step, int steps) {
  std::pair<double, double> best = middle;
  double least = std::numeric_limits<double>::infinity();
  for (int i = -steps; i <= steps; ++i) {
    const double a =
        std::clamp(middle.first * std::pow(step, i), +kNoiseFloor, kLargest);
    for (int j = -steps; j <= steps; ++j) {
      const double b =
          std::clamp(middle.second * std::pow(step, j), +kNoiseFloor, kLargest);
      const double value = NegativeLogLikelihood(samples, a, b);
      if (value < least) {
        least = value;
        best = {a, b};
      }
    }
  }
  return best;
}

std::pair<double, double> MostLikely(std::span<const Sample> samples) {
  // The middle of what is allowed.
  const double middle = std::sqrt(kNoiseFloor * kLargest);
  return MostLikelyAbout(
      samples, MostLikelyAbout(samples, {middle, middle}, kStep, kSteps),
      kFineStep, kFineSteps);
}

// Of motions of no length there are none; sigma is never 0.
Sample YawOf(const MotionError& error) {
  return {error.yaw_rad, std::abs(error.turn_rad) + 1e-3, error.way_m + 1e-3};
}
Sample AlongOf(const MotionError& error) {
  return {error.along_m, error.way_m + 1e-3, std::abs(error.turn_rad) + 1e-3};
}

core::MeasuredOdometryNoise NoiseOf(std::span<const MotionError> errors) {
  std::vector<Sample> yaw;
  std::vector<Sample> along;
  for (const MotionError& error : errors) {
    yaw.push_back(YawOf(error));
    along.push_back(AlongOf(error));
  }
  core::MeasuredOdometryNoise noise;
  std::tie(noise.turn_from_turn, noise.turn_from_drive) = MostLikely(yaw);
  std::tie(noise.drive_from_drive, noise.drive_from_turn) = MostLikely(along);
  return noise;
}

// Delete-a-block jackknife about the mean of the estimates (Efron 1982); no
// better than a step of the grid.
core::MeasuredOdometryNoise SigmaOf(std::span<const MotionError> errors) {
  std::vector<core::MeasuredOdometryNoise> without;
  for (int block = 0; block < kBlocks; ++block) {
    const size_t begin = errors.size() * static_cast<size_t>(block) / kBlocks;
    const size_t end =
        errors.size() * (static_cast<size_t>(block) + 1) / kBlocks;
    std::vector<MotionError> rest(errors.begin(),
                                  errors.begin() + static_cast<long>(begin));
    rest.insert(rest.end(), errors.begin() + static_cast<long>(end),
                errors.end());
    without.push_back(NoiseOf(rest));
  }
  core::MeasuredOdometryNoise sigma;
  for (const auto& [name, value] : core::kNoiseKeys) {
    double mean = 0;
    for (const auto& noise : without) mean += noise.*value / kBlocks;
    double squares = 0;
    for (const auto& noise : without) {
      squares += (noise.*value - mean) * (noise.*value - mean);
    }
    sigma.*value = std::max(std::sqrt(squares * (kBlocks - 1) / kBlocks),
                            (kFineStep - 1) * mean);
  }
  return sigma;
}

}  // namespace

std::optional<NoiseFit> FitNoise(std::span<const MotionError> errors) {
  int turns = 0;
  int straight = 0;
  for (const MotionError& error : errors) {
    const double turn_rad = std::abs(error.turn_rad);
    if (turn_rad > 0.5 * kWindowTurn_rad) ++turns;
    if (error.way_m > 0.5 * kWindowWay_m && turn_rad < 0.1) ++straight;
  }
  if (turns < kFewest || straight < kFewest) return std::nullopt;
  return NoiseFit{.noise = NoiseOf(errors), .sigma = SigmaOf(errors)};
}

NoiseExcess ExcessOver(const core::MeasuredOdometryNoise& noise,
                       std::span<const MotionError> errors) {
  if (errors.empty()) return {};
  const auto square = [](const Sample& sample, double a, double b) {
    const double z = sample.error / (a * sample.first + b * sample.second);
    return z * z;
  };
  double yaw = 0;
  double along = 0;
  for (const MotionError& error : errors) {
    yaw += square(YawOf(error), noise.turn_from_turn, noise.turn_from_drive);
    along +=
        square(AlongOf(error), noise.drive_from_drive, noise.drive_from_turn);
  }
  const auto count = static_cast<double>(errors.size());
  return {.yaw = std::sqrt(yaw / count), .along = std::sqrt(along / count)};
}

}  // namespace treeline::calibration
