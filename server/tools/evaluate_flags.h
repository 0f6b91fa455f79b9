// The options of `treeline evaluate`.
#ifndef SERVER_TOOLS_EVALUATE_FLAGS_H_
#define SERVER_TOOLS_EVALUATE_FLAGS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "common/dataset/dataset.h"
#include "server/core/localizer/query_options.h"
#include "server/tools/confidence_report.h"
#include "server/tools/feature_pnp_baseline.h"
#include "server/tools/foreign_images.h"
#include "server/tools/method_spec.h"
#include "server/tools/sweep.h"
#include "server/tools/thresholds.h"

namespace CLI {
class App;
}

namespace treeline {

struct EvaluateFlags {
  // What to evaluate: one of model_path and baseline, or compare.
  std::string model_path;
  std::string baseline;
  std::string compare_text;
  std::string calibration_path;
  std::string models_folder;
  DatasetOptions dataset;
  DatasetOptions training;
  QueryOptions query;
  FeaturePnpOptions features;
  // As given, and what they say.
  std::vector<std::string> threshold_texts;
  std::vector<std::string> foreign_texts;
  std::vector<std::string> sweep_texts;
  std::string sweep_methods_text;
  std::vector<MethodSpec> methods;           // of --compare, or the only one
  std::vector<ThresholdRequest> thresholds;  // the standard ones first
  std::vector<ForeignSource> foreign;
  std::vector<SweepRequest> sweeps;
  std::vector<MethodSpec> sweep_methods;
  double confidence_threshold = kPublishedConfidence;
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

}  // namespace treeline

#endif  // SERVER_TOOLS_EVALUATE_FLAGS_H_
