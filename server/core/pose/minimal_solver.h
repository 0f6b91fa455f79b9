// What RANSAC asks of a kind of observation.
#ifndef SERVER_CORE_POSE_MINIMAL_SOLVER_H_
#define SERVER_CORE_POSE_MINIMAL_SOLVER_H_

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/base/random.h"

namespace treeline::pose {

// A model, and its cost on the observations that were looked at so far.
template <typename Model>
struct Hypothesis {
  Model model;
  double cost = 0;
};

// A minimal solver makes models from as few observations as determine one, and
// knows what all others cost under a model. Observations are in random order,
// or in order of confidence.
//
//   kStream      Random streams kStream + hypothesis are its own.
//   kMinimum     Fewer observations give no model.
//   kMaxDraws    Samples drawn for a hypothesis before it is given up.
//   Draw         A model of observations drawn at random; nullopt if they
//                contradict each other, or determine nothing.
//   Cost         Sum over observations [begin, end), each in [0, 1].
//   Improve      Local optimisation on observations [0, seen): may replace a
//                hypothesis by a better one, with its cost on all of them;
//                `survivors` are left, and the fewer, the more it may cost.
//   Finish       The winner as the caller wants it.
//
// All are functions of their arguments and the observations alone.
template <typename S>
concept MinimalSolver = requires(const S& solver, base::Random& random,
                                 const typename S::Model& model,
                                 Hypothesis<typename S::Model>& hypothesis,
                                 size_t n) {
  { S::kStream } -> std::convertible_to<uint64_t>;
  { S::kMinimum } -> std::convertible_to<size_t>;
  { S::kMaxDraws } -> std::convertible_to<int>;
  { solver.size() } -> std::same_as<size_t>;
  { solver.Draw(random) } -> std::same_as<std::optional<typename S::Model>>;
  { solver.Cost(model, n, n) } -> std::same_as<double>;
  { solver.Improve(hypothesis, n, n) } -> std::same_as<void>;
  solver.Finish(model);
};

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_MINIMAL_SOLVER_H_
