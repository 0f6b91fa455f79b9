#include "common/base/sample_statistics.h"

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

TEST(QuantileTest, IsAValueThatWasMeasured) {
  EXPECT_EQ(Quantile({}, 0.5), 0);
  EXPECT_EQ(Quantile({7}, 0.99), 7);
  EXPECT_EQ(Quantile({3, 1, 2}, 0), 1);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 1), 3);
  EXPECT_EQ(Quantile({4, 3, 2, 1}, 0.5), 3);
}

TEST(ErrorSummaryTest, IsOfAllErrors) {
  const ErrorSummary none = Summarize({});
  EXPECT_EQ(none.rmse, 0);
  EXPECT_EQ(none.max, 0);
  const ErrorSummary even = Summarize({4, 0, 3, 1});
  EXPECT_EQ(even.mean, 2);
  EXPECT_EQ(even.median, 2);
  EXPECT_EQ(even.max, 4);
  EXPECT_DOUBLE_EQ(even.rmse * even.rmse, 6.5);
  EXPECT_EQ(Summarize({5, 1, 2}).median, 2);
}

}  // namespace
}  // namespace treeline::base
