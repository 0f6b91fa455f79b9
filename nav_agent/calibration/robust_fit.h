// Robust non-linear least squares for a few unknowns, with uncertainties that
// residuals decide.
#ifndef NAV_AGENT_CALIBRATION_ROBUST_FIT_H_
#define NAV_AGENT_CALIBRATION_ROBUST_FIT_H_

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace treeline::calibration {

// Rows (motions) of a few differences each: first lengths, then angles.
struct FitProblem {
  size_t rows = 0;
  size_t size = 3;         // of a row
  size_t first_angle = 2;  // from here on they are angles
  // The difference of a row at these values of the unknowns; false: the row
  // says nothing there. Must be safe for any values that is_sane passes.
  std::function<bool(size_t row, std::span<const double> at,
                     std::span<double> difference)>
      difference;
  // Of each row, size x size, row-major: relative among rows and within one;
  // lengths and angles are scaled apart by what residuals show.
  std::vector<std::vector<double>> covariances;
  // Of the unknowns: where to begin, what is known beforehand (one standard
  // deviation about it), and the steps of the numeric derivatives.
  std::vector<double> prior;
  std::vector<double> prior_sigma;
  std::vector<double> step;
  // The last ones may be held where they are.
  size_t free = 0;
  std::function<bool(std::span<const double> at)> is_sane;
  // What all rows may err alike, one standard deviation of each difference.
  std::vector<double> bias;
};

struct FitSolution {
  std::vector<double> at;
  // Row-major.
  std::vector<double> covariance;
  // Of each row: its residual in standard deviations; negative: it says
  // nothing.
  std::vector<double> norms;
};

// Minimises the sum of Cauchy kernels of the rows' residuals, in standard
// deviations, and of the priors, by Levenberg and Marquardt's method; then
// scales lengths and angles by their median residuals, and does so again,
// twice. The covariance is that of the least squares, scaled by the residuals,
// or of their sums over kBlocks parts of the rows, whichever is larger, and
// what a bias does. Deterministic.
FitSolution SolveRobustly(const FitProblem& problem);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_ROBUST_FIT_H_
