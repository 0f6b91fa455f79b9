#include "nav_agent/behavior/next_best_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav_agent/behavior/relocalization_parameters.h"

namespace treeline::behavior {
namespace {

double DirectionOf(size_t i) {
  return 2 * std::numbers::pi * static_cast<double>(i) /
         static_cast<double>(NextBestView::kDirections);
}

// How much pictures of such a distance tell, in [0, 1].
double WorthOf(double range_m) {
  if (range_m <= kMinWorthRange_m) return 0;
  if (range_m < kFullWorthRange_m) {
    return (range_m - kMinWorthRange_m) /
           (kFullWorthRange_m - kMinWorthRange_m);
  }
  return std::min(1.0, kFarWorthRange_m / range_m);
}

// From what is seen in a field of view.
double PriorOf(const std::vector<double>& ranges_m) {
  double worth = 0;
  int steps = 0;
  for (size_t i = 0; i < ranges_m.size(); ++i) {
    worth += WorthOf(ranges_m[i]) / static_cast<double>(ranges_m.size());
    if (i > 0 && std::abs(ranges_m[i] - ranges_m[i - 1]) > kRangeStep_m)
      ++steps;
  }
  // Things at different distances: corners that are not only paint.
  const double structure = std::min(1.0, steps / kFullStructureSteps);
  return kViewPriorBase + kViewPriorWorth * worth +
         kViewPriorStructure * worth * structure;
}

}  // namespace

void NextBestView::Begin(const geometry::Rigid2& odom_from_base) {
  here_ = odom_from_base;
  prior_.fill(kUnseenPrior);
  is_seen_.fill(false);
  promise_.fill(0);
  known_.fill(0);
}

double NextBestView::MovedFrom_m(const geometry::Rigid2& odom_from_base) const {
  return here_.has_value()
             ? geometry::Norm(odom_from_base.translation - here_->translation)
             : 0;
}

void NextBestView::AddScan(const geometry::Rigid2& odom_from_base,
                           const std::vector<geometry::Vec2>& ends) {
  if (ends.empty()) return;
  double first_rad = 10;
  double last_rad = -10;
  for (const geometry::Vec2 end : ends) {
    const double angle_rad = std::atan2(end.y, end.x);
    first_rad = std::min(first_rad, angle_rad);
    last_rad = std::max(last_rad, angle_rad);
  }
  for (size_t i = 0; i < kDirections; ++i) {
    const double middle_rad =
        geometry::NormalizedAngle_rad(DirectionOf(i) - odom_from_base.yaw_rad);
    // Only what was seen whole.
    if (middle_rad - kHalfView_rad < first_rad - kViewEdgeSlack_rad ||
        middle_rad + kHalfView_rad > last_rad + kViewEdgeSlack_rad) {
      continue;
    }
    std::vector<double> ranges_m;
    for (const geometry::Vec2 end : ends) {
      const double away_rad =
          geometry::NormalizedAngle_rad(std::atan2(end.y, end.x) - middle_rad);
      if (std::abs(away_rad) <= kHalfView_rad)
        ranges_m.push_back(geometry::Norm(end));
    }
    if (ranges_m.size() < kMinViewBeams) continue;
    const double prior = PriorOf(ranges_m);
    prior_[i] = is_seen_[i] ? std::max(prior_[i], prior) : prior;
    is_seen_[i] = true;
  }
}

void NextBestView::AddAnswer(double yaw_in_odom_rad, double promise) {
  for (size_t i = 0; i < kDirections; ++i) {
    const double away =
        geometry::NormalizedAngle_rad(DirectionOf(i) - yaw_in_odom_rad) /
        kSharedView_rad;
    const double share = std::exp(-0.5 * away * away);
    const double sum = known_[i] + share;
    promise_[i] = (promise_[i] * known_[i] + promise * share) / sum;
    known_[i] = sum;
  }
}

double NextBestView::Chance(double yaw_in_odom_rad) const {
  const double turn = yaw_in_odom_rad / (2 * std::numbers::pi) *
                      static_cast<double>(kDirections);
  const auto i =
      static_cast<size_t>(static_cast<int64_t>(std::llround(turn)) +
                          int64_t{1000} * static_cast<int64_t>(kDirections)) %
      kDirections;
  // Of what is known for sure, asking again brings nothing new.
  const double known = std::min(1.0, known_[i]);
  return (1 - known) * prior_[i] + known * promise_[i] * kKnownWorth;
}

std::optional<double> NextBestView::Next(double yaw_in_odom_rad,
                                         std::optional<double> near_rad,
                                         double least) const {
  std::optional<double> best_rad;
  double best = -1e9;
  for (size_t i = 0; i < kDirections; ++i) {
    const double direction_rad = DirectionOf(i);
    double chance = Chance(direction_rad);
    if (near_rad.has_value()) {
      const double away =
          (std::abs(geometry::NormalizedAngle_rad(direction_rad - *near_rad)) -
           kSecondView_rad) /
          kSecondViewWidth_rad;
      // Not where it has looked already.
      chance += kSecondViewGain * (1 - std::min(1.0, known_[i])) *
                std::exp(-0.5 * away * away);
    }
    if (chance < least) continue;
    const double value =
        chance - kTurnCost_per_rad * std::abs(geometry::NormalizedAngle_rad(
                                         direction_rad - yaw_in_odom_rad));
    if (value > best) {
      best = value;
      best_rad = geometry::NormalizedAngle_rad(direction_rad);
    }
  }
  return best_rad;
}

}  // namespace treeline::behavior
