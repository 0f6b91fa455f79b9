// Hypotheses from minimal samples, and their preemptive pruning, whatever the
// samples are.
#ifndef SERVER_CORE_POSE_PREEMPTIVE_RANSAC_H_
#define SERVER_CORE_POSE_PREEMPTIVE_RANSAC_H_

#include <algorithm>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "common/base/random.h"
#include "server/core/pose/minimal_solver.h"

namespace treeline::pose {

struct RansacOptions {
  uint64_t seed = 0;
  int hypotheses = 256;
  // Observations scored between two prunings.
  int block = 100;
};

// Up to options.hypotheses models, each from the first of its draws that is
// consistent.
template <MinimalSolver Solver>
std::vector<Hypothesis<typename Solver::Model>> DrawHypotheses(
    const Solver& solver, const RansacOptions& options,
    const std::stop_token& stop) {
  std::vector<Hypothesis<typename Solver::Model>> hypotheses;
  if (solver.size() < Solver::kMinimum) return hypotheses;
  for (int h = 0; h < options.hypotheses && !stop.stop_requested(); ++h) {
    base::Random random(options.seed,
                        Solver::kStream + static_cast<uint64_t>(h));
    for (int draw = 0; draw < Solver::kMaxDraws; ++draw) {
      if (auto model = solver.Draw(random)) {
        hypotheses.push_back({*model, 0});
        break;
      }
    }
  }
  return hypotheses;
}

// Scores block after block and keeps the better half each time, until one
// hypothesis is left or all observations are seen. The best comes first.
template <MinimalSolver Solver>
void Prune(const Solver& solver, const RansacOptions& options,
           const std::stop_token& stop,
           std::vector<Hypothesis<typename Solver::Model>>& alive) {
  const auto cost = [](const auto& hypothesis) { return hypothesis.cost; };
  size_t seen = 0;
  while (alive.size() > 1 && seen < solver.size() && !stop.stop_requested()) {
    const size_t end =
        std::min(solver.size(), seen + static_cast<size_t>(options.block));
    for (auto& hypothesis : alive) {
      hypothesis.cost += solver.Cost(hypothesis.model, seen, end);
    }
    seen = end;
    std::ranges::stable_sort(alive, {}, cost);
    alive.resize((alive.size() + 1) / 2, alive.front());
    for (auto& hypothesis : alive) {
      solver.Improve(hypothesis, seen, alive.size());
    }
  }
  std::ranges::stable_sort(alive, {}, cost);
}

// Preemptive RANSAC (Nister 2003; thesis 4.2.5) with local optimisation of the
// survivors (LO-RANSAC, Chum 2003). nullopt: nothing was consistent, or `stop`
// was requested. The same input gives the same result.
template <MinimalSolver Solver>
auto PreemptiveRansac(const Solver& solver, const RansacOptions& options,
                      const std::stop_token& stop) {
  using Result =
      std::optional<decltype(solver.Finish(typename Solver::Model()))>;
  auto alive = DrawHypotheses(solver, options, stop);
  if (alive.empty() || stop.stop_requested()) return Result();
  Prune(solver, options, stop, alive);
  if (stop.stop_requested()) return Result();
  return Result(solver.Finish(alive.front().model));
}

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_PREEMPTIVE_RANSAC_H_
