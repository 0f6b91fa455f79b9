// RANSAC alone, on a problem that can be seen through: the place where most
// numbers lie.
#include "server/core/pose/preemptive_ransac.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"
#include "server/core/pose/point_line_solver.h"
#include "server/core/pose/point_solver.h"
#include "server/core/pose/ray_solver.h"

namespace treeline::pose {
namespace {

static_assert(MinimalSolver<PointSolver>);
static_assert(MinimalSolver<PointLineSolver>);
static_assert(MinimalSolver<RaySolver>);

// A model is a number, and any one observation determines it.
class PlaceSolver {
 public:
  using Model = double;
  static constexpr uint64_t kStream = 7;
  static constexpr size_t kMinimum = 1;
  static constexpr int kMaxDraws = 5;

  explicit PlaceSolver(std::vector<double> numbers)
      : numbers_(std::move(numbers)) {}

  size_t size() const { return numbers_.size(); }
  std::optional<double> Draw(base::Random& random) const {
    ++draws;
    const double x =
        numbers_[random.NextBelow(static_cast<uint32_t>(numbers_.size()))];
    if (std::isnan(x)) return std::nullopt;
    return x;
  }
  double Cost(double place, size_t begin, size_t end) const {
    ++costs;
    double sum = 0;
    for (size_t i = begin; i < end; ++i) {
      const double d = numbers_[i] - place;
      sum += std::min(1.0, d * d);
    }
    return sum;
  }
  void Improve(Hypothesis<double>& hypothesis, size_t seen,
               size_t survivors) const {
    survivors_seen.push_back(survivors);
    double sum = 0;
    double count = 0;
    for (size_t i = 0; i < seen; ++i) {
      if (std::abs(numbers_[i] - hypothesis.model) > 1) continue;
      sum += numbers_[i];
      ++count;
    }
    if (count > 0) hypothesis.model = sum / count;
  }
  // Another type than the model's.
  struct Answer {
    double place = 0;
  };
  Answer Finish(double place) const { return {place}; }

  mutable int draws = 0;
  mutable int costs = 0;
  mutable std::vector<size_t> survivors_seen;

 private:
  const std::vector<double> numbers_;
};
static_assert(MinimalSolver<PlaceSolver>);

// 40 of 100 numbers lie around 3, with a standard deviation of 0.2.
std::vector<double> Numbers() {
  base::Random random(1, 0);
  std::vector<double> numbers;
  for (int i = 0; i < 100; ++i) {
    numbers.push_back(i % 5 < 2 ? 3 + 0.2 * random.NextGaussian()
                                : random.NextUniform(-50, 50));
  }
  return numbers;
}

TEST(PreemptiveRansacTest, FindsWhereMostLie) {
  const PlaceSolver solver(Numbers());
  const auto answer = PreemptiveRansac(solver, {.hypotheses = 32}, {});
  ASSERT_TRUE(answer.has_value());
  // The mean of 40: 0.2 / sqrt(40) = 0.03, and the few others within 1 pull.
  EXPECT_NEAR(answer->place, 3, 0.15);
}

TEST(PreemptiveRansacTest, AHypothesisDependsOnItsOwnIndexAlone) {
  const PlaceSolver solver(Numbers());
  const auto few = DrawHypotheses(solver, {.seed = 4, .hypotheses = 10}, {});
  const auto many = DrawHypotheses(solver, {.seed = 4, .hypotheses = 20}, {});
  ASSERT_EQ(few.size(), 10u);
  ASSERT_EQ(many.size(), 20u);
  for (size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].model, many[i].model);
  }
  const auto other = DrawHypotheses(solver, {.seed = 5, .hypotheses = 10}, {});
  EXPECT_NE(few[0].model, other[0].model);
}

TEST(PreemptiveRansacTest, EachBlockIsScoredForTheSurvivorsAlone) {
  const PlaceSolver solver(Numbers());
  ASSERT_TRUE(
      PreemptiveRansac(solver, {.hypotheses = 8, .block = 10}, {}).has_value());
  // 8 on the first block, 4 on the second and 2 on the third.
  EXPECT_EQ(solver.costs, 8 + 4 + 2);
  EXPECT_EQ(solver.survivors_seen, (std::vector<size_t>{4, 4, 4, 4, 2, 2, 1}));
}

TEST(PreemptiveRansacTest, StopsScoringWithTheLastObservation) {
  const PlaceSolver solver(Numbers());
  const auto answer =
      PreemptiveRansac(solver, {.hypotheses = 64, .block = 100}, {});
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(solver.costs, 64);
}

TEST(PreemptiveRansacTest, GivesAHypothesisUpAfterSoManyDraws) {
  const PlaceSolver solver(std::vector<double>(10, std::nan("")));
  EXPECT_FALSE(PreemptiveRansac(solver, {.hypotheses = 3}, {}).has_value());
  EXPECT_EQ(solver.draws, 3 * PlaceSolver::kMaxDraws);
}

TEST(PreemptiveRansacTest, NothingComesOfNothingOrOfAStop) {
  EXPECT_FALSE(PreemptiveRansac(PlaceSolver({}), {}, {}).has_value());
  std::stop_source stop;
  stop.request_stop();
  const PlaceSolver solver(Numbers());
  EXPECT_FALSE(PreemptiveRansac(solver, {}, stop.get_token()).has_value());
  EXPECT_EQ(solver.costs, 0);
}

}  // namespace
}  // namespace treeline::pose
