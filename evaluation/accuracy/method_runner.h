// Builds one method after the other, and learns about each all that was asked.
#ifndef EVALUATION_ACCURACY_METHOD_RUNNER_H_
#define EVALUATION_ACCURACY_METHOD_RUNNER_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "evaluation/accuracy/evaluate_flags.h"
#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/method_spec.h"
#include "evaluation/accuracy/sweep.h"
#include "server/core/localizer/localizer.h"
#include "server/tools/model_store.h"

namespace treeline::accuracy {

class MethodRunner {
 public:
  // Opens the recordings. `flags` must outlive the runner.
  static absl::StatusOr<MethodRunner> Open(const EvaluateFlags& flags,
                                           const std::stop_token& stop);

  // Every method of flags.methods, in their order. One that cannot be trained,
  // opened or asked says so in its status, and the rest goes on. CANCELLED.
  absl::StatusOr<std::vector<EvaluatedMethod>> EvaluateMethods();

  // Every sweep over every method of flags.sweep_methods; `evaluated` is what
  // EvaluateMethods gave. A line ends at the first point that fails, with a
  // message in `problems`, and the rest goes on. CANCELLED.
  absl::StatusOr<std::vector<Sweep>> RunSweeps(
      const std::vector<EvaluatedMethod>& evaluated,
      std::vector<std::string>& problems);

 private:
  MethodRunner(const EvaluateFlags& flags, std::stop_token stop,
               dataset::Dataset dataset,
               std::optional<dataset::Dataset> training,
               std::optional<camera::RgbdCalibration> calibration,
               tools::ModelStore store);

  absl::Status Evaluate(const MethodSpec& spec, EvaluatedMethod& method);
  absl::StatusOr<std::string> ModelPath(const MethodSpec& spec) const;
  absl::StatusOr<std::unique_ptr<localizer::Localizer>> Build(
      const MethodSpec& spec, EvaluatedMethod& method);
  absl::StatusOr<EvaluationOptions> Options(
      const MethodSpec& spec, const forest::ModelInfo& info) const;
  // Asks about the frames as they are, and with every perturbation.
  // Says on stderr which cameras count, where some were given.
  void TellCameras(const std::optional<camera::RgbdCalibration>& query,
                   const camera::RgbdCalibration& scene) const;
  absl::Status AddPerturbed(const localizer::Localizer& localizer,
                            EvaluationOptions options,
                            EvaluatedMethod& method) const;
  absl::Status AddDetails(const localizer::Localizer& localizer,
                          const MethodSpec& spec,
                          const EvaluationOptions& options,
                          EvaluatedMethod& method) const;
  std::vector<geometry::Rigid3> TrainingPoses(
      const forest::ModelInfo& info) const;
  // Adds to `line` a point a value, until one fails.
  absl::Status RunLine(const MethodSpec& spec, const SweepRequest& request,
                       const EvaluatedMethod& evaluated, SweepLine& line) const;
  absl::StatusOr<SweepPoint> RunPoint(const MethodSpec& spec,
                                      const SweepRequest& request, int value,
                                      const std::string& base_model) const;

  const EvaluateFlags& flags_;
  const std::stop_token stop_;
  const dataset::Dataset dataset_;
  const std::optional<dataset::Dataset> training_;
  const std::optional<camera::RgbdCalibration>
      calibration_;  // of --calibration
  tools::ModelStore store_;
  // Of the first model that was opened: what baselines register depth with.
  std::optional<camera::RgbdCalibration> estimated_calibration_;
};

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_METHOD_RUNNER_H_
