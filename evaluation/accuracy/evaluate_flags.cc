#include "evaluation/accuracy/evaluate_flags.h"

#include <algorithm>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/tools/dataset_flags.h"

namespace treeline::accuracy {
namespace {

void AddModelFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "What to evaluate";
  app.add_option("--model", flags.model_path, "Model file of `treeline train`")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--baseline", flags.baseline,
                 "A baseline instead of a model: sift-pnp, orb-pnp or "
                 "fast-sift-pnp (features of training keyframes with depth, "
                 "and PnP; needs "
                 "--training-dataset)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"sift-pnp", "orb-pnp", "fast-sift-pnp"}))
      ->group(kGroup);
  app.add_option("--compare", flags.compare_text,
                 absl::StrCat("Several methods side by side, separated by "
                              "commas: ",
                              ComparableNames(),
                              ", or NAME=FILE for a model that is there. Those "
                              "without a file are trained; needs "
                              "--training-dataset"))
      ->type_name("LIST")
      ->group(kGroup);
  app.add_option("--models", flags.models_folder,
                 "Folder for the models that --compare and --sweep train; one "
                 "that is there and was trained with the same options is taken "
                 "as it is. Without it, a temporary folder")
      ->type_name("DIR")
      ->group(kGroup);
  app.add_option("--calibration", flags.calibration_path,
                 "Calibration of `treeline calibrate`: of the queries, in "
                 "place of the model's, or of a baseline's keyframes")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--samples", flags.query.samples, "Pixels sampled a query")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--leaves", flags.query.backtracking_leaves,
                 "Leaves that backtracking visits in each tree")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--first-samples", flags.query.first_samples,
                 "Of those, how many a pose is first sought with")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--settled-inliers", flags.query.settled_inliers,
                 "They are enough if so many support it")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--first-leaves", flags.query.first_leaves,
                 "Leaves visited first; --leaves of them where no descriptor "
                 "is within --good-distance")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--good-distance", flags.query.good_distance,
                 "Descriptors this close are good enough")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--features", flags.query.features,
                 "SIFT features taken from a query (method sift, and sift-pnp "
                 "on a structure from motion)")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--hypotheses", flags.query.hypotheses,
                 "Pose hypotheses a query")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
}

void AddTrainingFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "Training frames";
  app.add_option("--training-dataset", flags.training.uri,
                 "Recording that a baseline learns; with a model, where the "
                 "report finds its training cameras if what the model recorded "
                 "is not there")
      ->type_name("URI")
      ->group(kGroup);
  app.add_option("--training-frames", flags.training.frame_list,
                 "Its frame list")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--training-poses", flags.training.pose_file,
                 "Its poses, in place of its own")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--keyframes", flags.features.keyframes,
                 "Training frames that a baseline keeps, evenly spread; 0: all")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
}

// An option that may stand several times, with one value each.
void AddRepeated(CLI::App& app, const char* name,
                 std::vector<std::string>& values, const char* type,
                 const char* group, const std::string& help) {
  app.add_option(name, values, help)
      ->allow_extra_args(false)
      ->type_name(type)
      ->group(group);
}

void AddMeasureFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "What to measure";
  AddRepeated(
      app, "--threshold", flags.threshold_texts, "CM,DEG", kGroup,
      "Another threshold beside 5,5, 2,2 and 10,10 (and 1%,5 of structures "
      "from motion); PERCENT%,DEG is "
      "relative to the scene's size. May be repeated");
  AddRepeated(app, "--foreign", flags.foreign_texts, "URI[,FRAMES]", kGroup,
              "A recording of another place, none of whose frames may be "
              "localized; its cameras may follow "
              "(URI;color-camera=CAMERA;depth-camera=CAMERA). builtin[,N] for "
              "noise, blank walls, black and gradients. May be repeated");
  app.add_option("--perturb", flags.perturb_text,
                 "Accuracy on changed frames: KIND, KIND:STRENGTH, or all, "
                 "separated by commas; with '+' one after the other "
                 "(no-depth+all). The kinds are listed below")
      ->type_name("LIST")
      ->group(kGroup);
  app.add_option("--perturb-frames", flags.perturbed_frames,
                 "Of the recording, evenly spread; 0: all")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--confidence-threshold", flags.confidence_threshold,
                 "Confidence from which an answer is to be relied on")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("P")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--min-confidence", flags.min_confidence,
                 "Least confidence of an answer, in place of the model's; 0 "
                 "answers with every pose that was found")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("P")
      ->group(kGroup);
  AddRepeated(app, "--sweep", flags.sweep_texts, "NAME=VALUES", kGroup,
              "Accuracy and time as an option changes: backtracking=1..32, "
              "samples=100..1000:100, hypotheses=16,64,256, trees=1..10, "
              "balanced-levels=0..10. May be repeated");
  app.add_option("--sweep-methods", flags.sweep_methods_text,
                 "Methods to sweep, of those compared; without it, the first "
                 "forest")
      ->type_name("LIST")
      ->group(kGroup);
}

void AddOutputFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "Running and output";
  app.add_option("--json", flags.json_path, "Write all results here")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--csv", flags.csv_path,
                 "Write a line a frame (and perturbation) here")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--report", flags.report_path,
                 "Write a page with charts and pictures here (HTML)")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--seed", flags.seed, "Seed of every query")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--threads", flags.threads,
                 "Frames at a time; latencies mean something only with 1")
      ->check(CLI::Range(1, 1024))
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_flag("--quiet", flags.quiet, "No progress bar")->group(kGroup);
}

// The value, or wrong usage of the option.
template <typename T>
T OrUsageError(const char* option, absl::StatusOr<T> value) {
  if (!value.ok()) {
    throw CLI::ValidationError(option, std::string(value.status().message()));
  }
  return *std::move(value);
}

void ParseTexts(EvaluateFlags& flags) {
  flags.thresholds = StandardThresholds();
  for (const std::string& text : flags.threshold_texts) {
    const auto threshold = OrUsageError("--threshold", ParseThreshold(text));
    if (std::ranges::count(flags.thresholds, threshold) > 0) continue;
    flags.thresholds.push_back(threshold);
  }
  // Centimetres say nothing where the unit of length is not known.
  const std::string& uri = flags.dataset.uri;
  if ((absl::StartsWith(uri, "colmap:") || absl::StartsWith(uri, "nvm:")) &&
      std::ranges::count(flags.thresholds, true, &ThresholdRequest::relative) ==
          0) {
    flags.thresholds.push_back(kRelativeThreshold);
  }
  for (const std::string& text : flags.foreign_texts) {
    flags.foreign.push_back(
        OrUsageError("--foreign", ParseForeignSource(text)));
  }
  if (!flags.perturb_text.empty()) {
    flags.perturbations =
        OrUsageError("--perturb", ParsePerturbations(flags.perturb_text));
  }
  for (const std::string& text : flags.sweep_texts) {
    flags.sweeps.push_back(OrUsageError("--sweep", ParseSweep(text)));
  }
  if (flags.comparing()) {
    flags.methods = OrUsageError("--compare", ParseMethods(flags.compare_text));
  } else if (!flags.baseline.empty()) {
    flags.methods = {OrUsageError("--baseline", ParseMethod(flags.baseline))};
  } else {
    flags.methods.emplace_back().model_path = flags.model_path;
  }
}

bool IsForest(const MethodSpec& spec) {
  return !spec.baseline && !spec.backtracking_leaves;
}

void ChooseSweepMethods(EvaluateFlags& flags) {
  if (flags.sweeps.empty()) return;
  if (flags.sweep_methods_text.empty()) {
    const auto first = std::ranges::find_if(flags.methods, IsForest);
    if (first != flags.methods.end()) flags.sweep_methods.push_back(*first);
  } else {
    for (const absl::string_view name :
         absl::StrSplit(flags.sweep_methods_text, ',')) {
      const auto spec = std::ranges::find_if(
          flags.methods, [&](const auto& m) { return m.name == name; });
      if (spec == flags.methods.end() || !IsForest(*spec)) {
        throw CLI::ValidationError(
            "--sweep-methods",
            absl::StrCat("\"", name, "\" is no forest of --compare"));
      }
      flags.sweep_methods.push_back(*spec);
    }
  }
  if (flags.sweep_methods.empty()) {
    throw CLI::ValidationError("--sweep", "there is no forest to sweep");
  }
}

// What CLI11 cannot say by itself. Throws, as its validators do.
void CheckUsage(EvaluateFlags& flags) {
  const bool single = !flags.baseline.empty() || !flags.model_path.empty();
  if (!single && !flags.comparing()) {
    throw CLI::RequiredError("--model, --baseline or --compare");
  }
  if (single && flags.comparing()) {
    throw CLI::ValidationError(
        "--compare",
        "goes without --model and --baseline: NAME=FILE in its "
        "list is a model, sift-pnp and orb-pnp are baselines");
  }
  if (flags.training.uri.empty() && (!flags.training.frame_list.empty() ||
                                     !flags.training.pose_file.empty())) {
    throw CLI::RequiredError(
        "--training-dataset (for --training-frames and --training-poses)");
  }
  ParseTexts(flags);
  ChooseSweepMethods(flags);
  const bool learns =
      std::ranges::any_of(flags.methods,
                          [](const MethodSpec& spec) {
                            return spec.NeedsTraining() || spec.baseline;
                          }) ||
      std::ranges::any_of(flags.sweeps, [](const SweepRequest& sweep) {
        return sweep.variable == SweepVariable::kBalancedLevels;
      });
  if (learns && flags.training.uri.empty()) {
    throw CLI::RequiredError("--training-dataset (for what is to be learned)");
  }
}

}  // namespace

void AddEvaluateFlags(CLI::App& app, EvaluateFlags& flags) {
  AddModelFlags(app, flags);
  tools::AddDatasetFlags(app, flags.dataset);
  AddTrainingFlags(app, flags);
  AddMeasureFlags(app, flags);
  AddOutputFlags(app, flags);
  app.parse_complete_callback([&flags] { CheckUsage(flags); });
}

}  // namespace treeline::accuracy
