#include "evaluation/accuracy/perturbation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"
#include "opencv2/core.hpp"

namespace treeline::accuracy {
namespace {

constexpr absl::string_view kAll = "all";
constexpr absl::string_view kAsItIs = "as it is";
// Combinations that a list may come to.
constexpr size_t kMaxPerturbations = 1000;

absl::Status BadPerturbation(absl::string_view text, absl::string_view why) {
  return absl::InvalidArgumentError(
      absl::StrCat("perturbation \"", text, "\": ", why));
}

std::string StepName(const Perturbation::Step& step) {
  if (step.kind->strengths.empty()) return step.kind->name;
  return absl::StrFormat("%s:%g", step.kind->name, step.strength);
}

// The kind at its usual strengths.
void AddUsual(const PerturbationKind& kind,
              std::vector<Perturbation::Step>& steps) {
  if (kind.strengths.empty()) steps.push_back({&kind, 0});
  for (const double strength : kind.strengths) {
    steps.push_back({&kind, strength});
  }
}

absl::Status CheckStrength(const PerturbationKind& kind, double strength) {
  if (!(strength >= kind.min_strength && strength <= kind.max_strength)) {
    return BadPerturbation(
        kind.name,
        absl::StrFormat("its strength must be in [%g, %g], not %g",
                        kind.min_strength, kind.max_strength, strength));
  }
  if (kind.apply == Rotate && std::fmod(strength, 90) != 0) {
    return BadPerturbation(kind.name,
                           "degrees must be a multiple of 90; roll takes any");
  }
  return absl::OkStatus();
}

// What one word stands for: all of these in turn.
absl::StatusOr<std::vector<Perturbation::Step>> ParseStep(
    absl::string_view word) {
  std::vector<Perturbation::Step> steps;
  if (word == kAll) {
    for (const PerturbationKind& kind : PerturbationKinds()) {
      AddUsual(kind, steps);
    }
    return steps;
  }
  const std::vector<absl::string_view> parts = absl::StrSplit(word, ':');
  const auto kind = std::ranges::find_if(
      PerturbationKinds(),
      [&](const PerturbationKind& k) { return parts[0] == k.name; });
  if (kind == PerturbationKinds().end()) {
    const auto name = [](std::string* out, const PerturbationKind& k) {
      absl::StrAppend(out, k.name);
    };
    return BadPerturbation(
        word, absl::StrCat("it must be all or one of ",
                           absl::StrJoin(PerturbationKinds(), ", ", name)));
  }
  if (parts.size() == 1) {
    AddUsual(*kind, steps);
    return steps;
  }
  double strength = 0;
  if (parts.size() != 2 || kind->strengths.empty() ||
      !absl::SimpleAtod(parts[1], &strength)) {
    return BadPerturbation(word, kind->strengths.empty()
                                     ? "it has no strength"
                                     : "it must be KIND or KIND:STRENGTH");
  }
  TL_RETURN_IF_ERROR(CheckStrength(*kind, strength));
  return std::vector<Perturbation::Step>{{&*kind, strength}};
}

// Of "a+b": each of a with each of b.
absl::StatusOr<std::vector<Perturbation>> ParseEntry(absl::string_view entry) {
  std::vector<Perturbation> chains(1);
  for (const absl::string_view word : absl::StrSplit(entry, '+')) {
    TL_ASSIGN_OR_RETURN(const std::vector<Perturbation::Step> steps,
                        ParseStep(word));
    std::vector<Perturbation> longer;
    for (const Perturbation& chain : chains) {
      for (const Perturbation::Step& step : steps) {
        longer.push_back(chain);
        longer.back().steps.push_back(step);
      }
    }
    if (longer.size() > kMaxPerturbations) {
      return BadPerturbation(entry, "too many combinations");
    }
    chains = std::move(longer);
  }
  return chains;
}

uint64_t Mixed(uint64_t hash, absl::string_view text) {
  for (const char c : text) {
    hash = base::MixBits(hash + static_cast<unsigned char>(c) + 1);
  }
  return hash;
}

}  // namespace

const std::vector<PerturbationKind>& PerturbationKinds() {
  // Light, sharpness, what is seen, orientation, depth. Never destroyed: others
  // point into it.
  static const auto& kinds = *new std::vector<PerturbationKind>{
      {"grey", {0.5, 1}, 0, 1, "mixed with grey, share", false, Grey},
      {"white-balance",
       {0.25, 0.4},
       -1,
       1,
       "red x (1 + s), blue x (1 - s)",
       false,
       WhiteBalance},
      {"gamma", {0.5, 2}, 0.05, 20, "(value / 255)^s", false, Gamma},
      {"exposure", {0.6, 0.35}, 0, 20, "values times s", false, Exposure},
      {"light",
       {0.5, 1},
       -8,
       8,
       "a warm lamp on one side, stops",
       false,
       Light},
      {"blur", {9, 17}, 1, 200, "motion over s px", false, MotionBlur},
      {"defocus", {1.5, 3}, 0.1, 50, "Gaussian of s px", false, Defocus},
      {"noise", {12, 25}, 0, 255, "Gaussian of s / 255", false, Noise},
      {"jpeg", {30, 10}, 1, 100, "quality s", false, Jpeg},
      {"cover",
       {0.2, 0.4},
       0,
       1,
       "a plain thing before a share s",
       false,
       Cover},
      {"crop", {0.75, 0.5}, 0.05, 1, "a window of s of each side", false, Crop},
      {"scale", {0.5, 2}, 0.05, 8, "resized by s", false, Scale},
      {"distort", {-0.1, -0.2}, -1, 1, "another lens, k1 = s", false, Distort},
      {"focal",
       {1.05, 1.15},
       0.2,
       5,
       "stated focal length s times the true",
       false,
       WrongFocalLength},
      {"assumed",
       {0.8, 1.25},
       0.2,
       5,
       "no camera stated: pinhole, focal length s times the true",
       false,
       AssumedLens},
      {"guessed",
       {0.8, 1.25},
       0.2,
       5,
       "a guess is stated: pinhole, focal length s times the true",
       false,
       GuessedLens},
      {"rotate",
       {90, 180, 270},
       -360,
       360,
       "clockwise by s degrees",
       false,
       Rotate},
      {"roll", {15, 45}, -360, 360, "clockwise by any s degrees", false, Roll},
      {"mirror", {}, 0, 0, "left and right exchanged: foreign", true, Mirror},
      {"depth-holes",
       {0.3, 0.6},
       0,
       1,
       "share s not measured",
       false,
       DepthHoles},
      {"depth-noise",
       {0.005, 0.015},
       0,
       1,
       "Gaussian of s / m x depth^2",
       false,
       DepthNoise},
      {"depth-scale",
       {1.02, 1.05},
       0.1,
       10,
       "depth times s",
       false,
       DepthScaled},
      {"depth-offset",
       {0.01, 0.03},
       -1,
       1,
       "s m further away",
       false,
       DepthOffset},
      {"no-depth", {}, 0, 0, "colour alone", false, NoDepth}};
  return kinds;
}

bool Perturbation::is_foreign() const {
  return std::ranges::any_of(
      steps, [](const Step& step) { return step.kind->is_foreign; });
}

std::string Perturbation::Name() const {
  if (steps.empty()) return std::string(kAsItIs);
  return absl::StrJoin(steps, "+", [](std::string* out, const Step& step) {
    absl::StrAppend(out, StepName(step));
  });
}

absl::StatusOr<std::vector<Perturbation>> ParsePerturbations(
    absl::string_view text) {
  std::vector<Perturbation> perturbations;
  for (const absl::string_view entry : absl::StrSplit(text, ',')) {
    TL_ASSIGN_OR_RETURN(std::vector<Perturbation> parsed, ParseEntry(entry));
    for (Perturbation& perturbation : parsed) {
      if (std::ranges::count(perturbations, perturbation.Name(),
                             &Perturbation::Name) > 0) {
        continue;
      }
      perturbations.push_back(std::move(perturbation));
    }
  }
  return perturbations;
}

std::string PerturbationHelp() {
  std::string help;
  for (const PerturbationKind& kind : PerturbationKinds()) {
    const std::string strengths = absl::StrJoin(kind.strengths, ", ");
    absl::StrAppendFormat(&help, "  %-14s %-14s %s\n", kind.name, strengths,
                          kind.what);
  }
  return help;
}

absl::StatusOr<PerturbedFrame> Perturb(const Perturbation& perturbation,
                                       image::Frame frame, uint64_t seed,
                                       absl::string_view frame_name) {
  PerturbedFrame view{std::move(frame), {}};
  if (!view.frame.calibration) {
    return absl::InvalidArgumentError(
        "a frame is perturbed together with its calibration, and has none");
  }
  try {
    for (const Perturbation::Step& step : perturbation.steps) {
      base::Random random(seed, Mixed(Mixed(0, step.kind->name), frame_name));
      const absl::Status status = step.kind->apply(step.strength, random, view);
      if (!status.ok()) return base::Annotate(status, StepName(step));
    }
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("OpenCV: ", error.what()));
  }
  return view;
}

}  // namespace treeline::accuracy
