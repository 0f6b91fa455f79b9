#include "common/base/sample_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::base {

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto last = static_cast<double>(values.size() - 1);
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(std::ceil(part * last));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

ErrorSummary Summarize(std::vector<double> errors) {
  ErrorSummary summary;
  if (errors.empty()) return summary;
  std::sort(errors.begin(), errors.end());
  for (const double error : errors) {
    summary.mean += error;
    summary.rmse += error * error;
  }
  const auto count = static_cast<double>(errors.size());
  summary.mean /= count;
  summary.rmse = std::sqrt(summary.rmse / count);
  const size_t middle = errors.size() / 2;
  summary.median = errors.size() % 2 == 1
                       ? errors[middle]
                       : 0.5 * (errors[middle - 1] + errors[middle]);
  summary.max = errors.back();
  return summary;
}

}  // namespace treeline::base
