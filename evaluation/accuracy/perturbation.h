// Queries as they were not recorded: the kinds of change that
// `treeline evaluate --perturb` knows, and how they are named.
#ifndef EVALUATION_ACCURACY_PERTURBATION_H_
#define EVALUATION_ACCURACY_PERTURBATION_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "evaluation/accuracy/perturbation_effects.h"

namespace treeline::accuracy {

// One kind of change. A table of these lies behind all else here.
struct PerturbationKind {
  const char* name;
  // What it is asked with unless told otherwise, weaker first; empty: it has no
  // strength.
  std::vector<double> strengths;
  double min_strength;
  double max_strength;
  // For the help: what changes, and what strength means.
  const char* what;
  // The result shows a place that does not exist: every answer is wrong.
  bool is_foreign;
  absl::Status (*apply)(double strength, base::Random& random,
                        PerturbedFrame& view);
};

const std::vector<PerturbationKind>& PerturbationKinds();

// Changes that are made one after the other.
struct Perturbation {
  struct Step {
    const PerturbationKind* kind = nullptr;  // of PerturbationKinds()
    double strength = 0;
  };
  std::vector<Step> steps;  // empty: the frame as it is

  bool is_foreign() const;
  // As ParsePerturbations reads it: "gamma:0.5", "no-depth+rotate:90"; "as it
  // is" where there is no step.
  std::string Name() const;
};

// Entries separated by commas: KIND:STRENGTH, KIND for its usual strengths, or
// "all" for all kinds; joined with '+' they are done one after the other, each
// with each ("no-depth+all"). No entry twice. INVALID_ARGUMENT for what is
// unknown, out of range, or nothing.
absl::StatusOr<std::vector<Perturbation>> ParsePerturbations(
    absl::string_view text);

// Kinds with their usual strengths, a line each: for the help.
std::string PerturbationHelp();

// `frame` with its calibration, changed. Draws depend on the seed, the kind and
// the frame's name, not on strength: the same place is covered a little or
// much. Errors: INVALID_ARGUMENT where a step cannot be done to such a frame.
absl::StatusOr<PerturbedFrame> Perturb(const Perturbation& perturbation,
                                       image::Frame frame, uint64_t seed,
                                       absl::string_view frame_name);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_PERTURBATION_H_
