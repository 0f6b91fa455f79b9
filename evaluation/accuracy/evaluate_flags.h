// The options of `treeline evaluate`.
#ifndef EVALUATION_ACCURACY_EVALUATE_FLAGS_H_
#define EVALUATION_ACCURACY_EVALUATE_FLAGS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/dataset/dataset.h"
#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/feature_pnp_baseline.h"
#include "evaluation/accuracy/foreign_images.h"
#include "evaluation/accuracy/method_spec.h"
#include "evaluation/accuracy/perturbation.h"
#include "evaluation/accuracy/sweep.h"
#include "evaluation/accuracy/thresholds.h"
#include "server/core/localizer/query_options.h"

namespace CLI {
class App;
}

namespace treeline::accuracy {

struct EvaluateFlags {
  // What to evaluate: one of model_path and baseline, or compare.
  std::string model_path;
  std::string baseline;
  std::string compare_text;
  std::string calibration_path;
  std::string models_folder;
  dataset::DatasetOptions dataset;
  dataset::DatasetOptions training;
  localizer::QueryOptions query;
  FeaturePnpOptions features;
  // As given, and what they say.
  std::vector<std::string> threshold_texts;
  std::vector<std::string> foreign_texts;
  std::string perturb_text;
  std::vector<std::string> sweep_texts;
  std::string sweep_methods_text;
  std::vector<MethodSpec> methods;           // of --compare, or the only one
  std::vector<ThresholdRequest> thresholds;  // the standard ones first
  std::vector<NegativeSource> foreign;
  std::vector<Perturbation> perturbations;
  int perturbed_frames = 0;  // evenly spread; 0: all
  std::vector<SweepRequest> sweeps;
  std::vector<MethodSpec> sweep_methods;
  double confidence_threshold = kPublishedConfidence;
  std::optional<double> min_confidence;  // nullopt: the models' own
  std::string json_path;
  std::string csv_path;
  std::string report_path;
  uint64_t seed = 0;
  int threads = 1;
  bool quiet = false;

  bool comparing() const { return !compare_text.empty(); }
};

// Adds all options to `app`. `flags` must live as long as `app`. Texts are
// parsed and checked against each other when the command line is complete: a
// wrong one is wrong usage.
void AddEvaluateFlags(CLI::App& app, EvaluateFlags& flags);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATE_FLAGS_H_
