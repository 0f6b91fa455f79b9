#include "evaluation/accuracy/evaluation.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/processor_time.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"

namespace treeline::accuracy {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr int kMaxThreads = 1024;

std::string CameraName(const camera::Camera& camera) {
  return absl::StrCat(camera.width(), " x ", camera.height(), " ",
                      camera.ToString());
}

// Localizes the frames of one dataset, one call a frame.
class FrameEvaluator {
 public:
  FrameEvaluator(const localizer::Localizer& localizer,
                 const dataset::Dataset& dataset,
                 const EvaluationOptions& options, const base::Clock& clock)
      : localizer_(localizer),
        dataset_(dataset),
        options_(options),
        clock_(clock),
        calibration_(
            options.calibration.value_or(localizer.info().calibration)) {}

  // Runs the first readable frame once, for nothing but warmth.
  void WarmUp() const {
    for (int i = 0; i < dataset_.size() && !options_.stop.stop_requested();
         ++i) {
      if (Run(i).status.ok()) return;
    }
  }

  FrameResult Run(int i) const {
    FrameResult result;
    const dataset::DatasetFrame& entry = dataset_.frame(i);
    result.stem = entry.stem;
    if (entry.color_camera) result.camera = CameraName(*entry.color_camera);
    if (entry.world_from_camera.has_value()) {
      result.true_world_from_camera = camera::PoseOfSensor(
          *entry.world_from_camera, dataset_.calibration().pose_sensor,
          localizer_.info().calibration.pose_sensor, calibration_);
    }
    result.status = Localize(i, result);
    if (result.status.ok() && result.true_world_from_camera.has_value()) {
      AddError(result);
    }
    return result;
  }

 private:
  static void AddError(FrameResult& result) {
    if (!result.localized() && !result.refused_pose()) return;
    (result.localized() ? result.error : result.refused_error) =
        geometry::ErrorBetween(result.estimate.world_from_camera,
                               *result.true_world_from_camera);
  }

  // The frame as it is asked about; `truth` follows it.
  absl::StatusOr<image::Frame> Perturbed(
      image::Frame frame, const std::string& stem,
      std::optional<geometry::Rigid3>& truth) const {
    if (!frame.calibration) frame.calibration = calibration_;
    TL_ASSIGN_OR_RETURN(
        PerturbedFrame perturbed,
        Perturb(options_.perturbation, std::move(frame), options_.seed, stem));
    if (options_.perturbation.is_foreign()) truth.reset();
    if (truth) *truth = *truth * perturbed.turned_from_sensor.Inverse();
    return std::move(perturbed.frame);
  }

  absl::Status Localize(int i, FrameResult& result) const {
    TL_ASSIGN_OR_RETURN(const dataset::Dataset::Encoded encoded,
                        dataset_.ReadEncoded(i));
    const base::MonotonicTime start = clock_.Now();
    absl::StatusOr<image::Frame> frame = dataset_.Decode(encoded);
    const base::MonotonicTime decoded = clock_.Now();
    if (!frame.ok()) return AnnotateWithFiles(frame.status(), i);
    result.decode_ms = base::MillisecondsBetween(start, decoded);
    if (options_.calibration) frame->calibration = options_.calibration;
    if (!options_.perturbation.steps.empty()) {
      frame = Perturbed(*std::move(frame), result.stem,
                        result.true_world_from_camera);
      if (!frame.ok()) return AnnotateWithFiles(frame.status(), i);
    }
    const localizer::LocalizeOptions query = options_.Query();
    const double cpu_before_ms = base::ThreadProcessorTime_ms();
    const base::MonotonicTime asked = clock_.Now();
    absl::StatusOr<localizer::PoseEstimate> estimate =
        localizer_.Localize(*frame, query);
    const base::MonotonicTime answered = clock_.Now();
    const double cpu_after_ms = base::ThreadProcessorTime_ms();
    if (!estimate.ok()) return AnnotateWithFiles(estimate.status(), i);
    result.latency_ms = base::MillisecondsBetween(asked, answered);
    result.cpu_ms = cpu_after_ms - cpu_before_ms;
    result.estimate = *std::move(estimate);
    return absl::OkStatus();
  }

  // Says which files an error is about.
  absl::Status AnnotateWithFiles(const absl::Status& status, int i) const {
    const dataset::DatasetFrame& entry = dataset_.frame(i);
    if (entry.depth_path.empty())
      return base::Annotate(status, entry.color_path);
    return base::Annotate(
        status, absl::StrCat(entry.color_path, ", ", entry.depth_path));
  }

  const localizer::Localizer& localizer_;
  const dataset::Dataset& dataset_;
  const EvaluationOptions& options_;
  const base::Clock& clock_;
  const camera::RgbdCalibration calibration_;
};

std::optional<Percentiles> PercentilesOf(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return Percentiles{.p50 = *Percentile(values, 50),
                     .p95 = *Percentile(values, 95),
                     .p99 = *Percentile(values, 99)};
}

}  // namespace

absl::Status EvaluationOptions::Validate() const {
  if (threads < 1 || threads > kMaxThreads) {
    return absl::InvalidArgumentError(absl::StrCat(
        "threads must be in [1, ", kMaxThreads, "], not ", threads));
  }
  return absl::OkStatus();
}

localizer::LocalizeOptions EvaluationOptions::Query() const {
  return {.seed = seed, .min_confidence = min_confidence, .stop = stop};
}

absl::StatusOr<std::vector<FrameResult>> Evaluate(
    const localizer::Localizer& localizer, const dataset::Dataset& dataset,
    const EvaluationOptions& options, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  const FrameEvaluator evaluator(localizer, dataset, options, clock);
  evaluator.WarmUp();
  std::vector<FrameResult> results(static_cast<size_t>(dataset.size()));
  {
    base::Progress progress("localizing", dataset.size(), options.quiet);
    base::ParallelFor(dataset.size(), options.threads, [&](int64_t i) {
      if (options.stop.stop_requested()) return;
      results[static_cast<size_t>(i)] = evaluator.Run(static_cast<int>(i));
      progress.Add(1);
    });
  }
  if (options.stop.stop_requested()) {
    return absl::CancelledError("evaluation was interrupted");
  }
  return results;
}

bool IsWithin(const FrameResult& result, const PoseThreshold& threshold) {
  return IsWithin(result.error, threshold);
}

bool IsWithin(const std::optional<geometry::PoseError>& error,
              const PoseThreshold& threshold) {
  return error && error->translation_m < threshold.translation_m &&
         error->rotation_rad * kDegreesPerRadian < threshold.rotation_deg;
}

std::optional<double> CorrectShare(const std::vector<FrameResult>& results,
                                   const PoseThreshold& threshold) {
  int scored = 0;
  int correct = 0;
  for (const FrameResult& result : results) {
    scored += result.true_world_from_camera.has_value();
    correct += IsWithin(result, threshold);
  }
  if (scored == 0) return std::nullopt;
  return static_cast<double>(correct) / scored;
}

EvaluationSummary Summarize(const std::vector<FrameResult>& results) {
  EvaluationSummary summary;
  std::vector<double> translations_m;
  std::vector<double> rotations_deg;
  std::vector<double> latencies_ms;
  std::vector<double> cpus_ms;
  std::vector<double> decodes_ms;
  std::vector<double> samples_ms;
  std::vector<double> forests_ms;
  std::vector<double> poses_ms;
  for (const FrameResult& result : results) {
    ++summary.frames;
    summary.scored += result.true_world_from_camera.has_value();
    summary.localized += result.localized();
    summary.errors += !result.status.ok();
    if (result.decode_ms) decodes_ms.push_back(*result.decode_ms);
    if (result.cpu_ms) cpus_ms.push_back(*result.cpu_ms);
    if (result.latency_ms) latencies_ms.push_back(*result.latency_ms);
    if (result.status.ok()) {
      const localizer::LocalizeTimings& timings = result.estimate.timings;
      samples_ms.push_back(timings.sample_ms);
      forests_ms.push_back(timings.forest_ms);
      poses_ms.push_back(timings.pose_ms);
    }
    if (result.error.has_value()) {
      translations_m.push_back(result.error->translation_m);
      rotations_deg.push_back(result.error->rotation_rad * kDegreesPerRadian);
    }
  }
  summary.correct_5cm_5deg = CorrectShare(results, {0.05, 5});
  summary.correct_2cm_2deg = CorrectShare(results, {0.02, 2});
  summary.median_translation_m = Percentile(std::move(translations_m), 50);
  summary.median_rotation_deg = Percentile(std::move(rotations_deg), 50);
  summary.latency_ms = PercentilesOf(latencies_ms);
  summary.cpu_ms = PercentilesOf(cpus_ms);
  summary.decode_ms = PercentilesOf(decodes_ms);
  summary.sample_ms = PercentilesOf(samples_ms);
  summary.forest_ms = PercentilesOf(forests_ms);
  summary.pose_ms = PercentilesOf(poses_ms);
  return summary;
}

std::optional<double> Percentile(std::vector<double> values, double p) {
  if (values.empty()) return std::nullopt;
  std::ranges::sort(values);
  const double rank = p / 100 * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(std::floor(rank));
  const size_t above = std::min(below + 1, values.size() - 1);
  const double fraction = rank - std::floor(rank);
  return values[below] + fraction * (values[above] - values[below]);
}

}  // namespace treeline::accuracy
