// The square root of a covariance of a pose in the plane.
#ifndef NAV_AGENT_LOCALIZATION_COVARIANCE_ROOT_H_
#define NAV_AGENT_LOCALIZATION_COVARIANCE_ROOT_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "common/base/random.h"

namespace treeline::localization {

// The lower triangle L of L L^T = covariance (Cholesky), in its rows; nullopt
// if that is not positive semidefinite.
inline std::optional<std::array<double, 9>> SquareRoot(
    const std::array<double, 9>& c) {
  std::array<double, 9> root{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j <= i; ++j) {
      double sum = c[3 * i + j];
      if (std::abs(sum - c[3 * j + i]) > 1e-9 * (1 + std::abs(sum)) ||
          !std::isfinite(sum)) {
        return std::nullopt;
      }
      for (size_t k = 0; k < j; ++k) sum -= root[3 * i + k] * root[3 * j + k];
      if (i == j) {
        if (sum < -1e-12) return std::nullopt;
        root[4 * i] = std::sqrt(std::max(sum, 0.0));
      } else {
        // A direction without any spread has no say in the others.
        root[3 * i + j] = root[4 * j] > 0 ? sum / root[4 * j] : 0;
      }
    }
  }
  return root;
}

// A draw from the normal distribution of mean 0 whose covariance has this root.
inline std::array<double, 3> DrawFrom(const std::array<double, 9>& root,
                                      base::Random& random) {
  std::array<double, 3> normal{};
  for (double& value : normal) value = random.NextGaussian();
  std::array<double, 3> drawn{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k <= i; ++k) drawn[i] += root[3 * i + k] * normal[k];
  }
  return drawn;
}

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_COVARIANCE_ROOT_H_
