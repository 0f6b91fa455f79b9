// What a number of measurements says as a few figures.
#ifndef COMMON_BASE_SAMPLE_STATISTICS_H_
#define COMMON_BASE_SAMPLE_STATISTICS_H_

#include <vector>

namespace treeline::base {

// The value that a share `part` in [0, 1] of `values` is at most, by nearest
// rank: 0 is the smallest, 1 the largest. 0 if there is none.
double Quantile(std::vector<double> values, double part);

// Of errors, none of which is negative. All 0 if there is none.
struct ErrorSummary {
  double rmse = 0;
  double mean = 0;
  // Of an even number, the mean of the two in the middle.
  double median = 0;
  double max = 0;
};
ErrorSummary Summarize(std::vector<double> errors);

}  // namespace treeline::base

#endif  // COMMON_BASE_SAMPLE_STATISTICS_H_
