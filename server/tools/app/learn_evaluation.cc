#include "server/tools/app/learn_evaluation.h"

#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "evaluation/accuracy/answer_counts.h"
#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/evaluation.h"
#include "evaluation/accuracy/foreign_images.h"
#include "evaluation/accuracy/perturbation.h"
#include "evaluation/accuracy/query_calibration.h"
#include "evaluation/accuracy/report_pictures.h"
#include "server/core/localizer/localizer.h"

namespace treeline::tools_app {
namespace {

using accuracy::FrameResult;
using localizer::DepthUse;

// Enough for shares to 5 percentage points.
constexpr int kMaxFrames = 300;
constexpr int kMissedPictures = 6;
constexpr const char* kForeign = "builtin,40";

// Up to `count` frames, evenly spread over the recording.
dataset::Dataset EvenlySpread(const dataset::Dataset& dataset, int count) {
  if (dataset.size() <= count) return dataset;
  std::vector<int> frames;
  for (int64_t k = 0; k < count; ++k) {
    frames.push_back(static_cast<int>(k * dataset.size() / count));
  }
  return dataset.Subset(frames);
}

bool HasDepth(const dataset::Dataset& dataset) {
  for (int i = 0; i < dataset.size(); ++i) {
    if (!dataset.frame(i).depth_path.empty()) return true;
  }
  return false;
}

std::optional<double> TranslationPercentile(
    const std::vector<FrameResult>& results, double p) {
  std::vector<double> errors_m;
  for (const FrameResult& result : results) {
    if (result.error) errors_m.push_back(result.error->translation_m);
  }
  return accuracy::Percentile(std::move(errors_m), p);
}

learning::HeldOutTrial TrialOf(const std::string& queries,
                               const std::vector<FrameResult>& results,
                               const accuracy::PoseThreshold& right) {
  const accuracy::AnswerCounts counts =
      accuracy::CountAnswers(results, right, accuracy::kPublishedConfidence);
  const accuracy::EvaluationSummary summary = accuracy::Summarize(results);
  learning::HeldOutTrial trial{
      .queries = queries,
      .frames = counts.frames,
      .answered = counts.answered,
      .right = counts.right,
      .wrong = counts.wrong,
      .median_translation_m = summary.median_translation_m,
      .median_rotation_deg = summary.median_rotation_deg,
      .p90_translation_m = TranslationPercentile(results, 90),
      .cpu_ms = {}};
  if (counts.cpu_ms) trial.cpu_ms = counts.cpu_ms->p50;
  return trial;
}

std::string ReasonText(localizer::NotLocalizedReason reason) {
  switch (reason) {
    case localizer::NotLocalizedReason::kTooFewSamples:
      return "too little in it to look at";
    case localizer::NotLocalizedReason::kPoorlyConstrained:
      return "what was recognised leaves the pose uncertain";
    case localizer::NotLocalizedReason::kLowConfidence:
      return "a pose was found, and not believed";
    case localizer::NotLocalizedReason::kContradictsDepth:
      return "its depth is not what the pose would see";
    case localizer::NotLocalizedReason::kUnknownCamera:
      return "its focal length is not known";
    default:
      return "not recognised";
  }
}

std::string WhyMissed(const FrameResult& result, bool units_are_metres) {
  if (!result.status.ok()) return std::string(result.status.message());
  if (!result.localized()) return ReasonText(result.estimate.reason);
  if (!result.error) return "its true pose is not known";
  return absl::StrFormat(
      "off by %s and %.1f degrees",
      learning::LengthText(result.error->translation_m, units_are_metres),
      result.error->rotation_rad * 180 / std::numbers::pi);
}

// The frames that were not answered rightly, as indices.
std::vector<int> Missed(const std::vector<FrameResult>& results,
                        const accuracy::PoseThreshold& right) {
  std::vector<int> missed;
  for (size_t i = 0; i < results.size(); ++i) {
    if (results[i].true_world_from_camera &&
        !accuracy::IsWithin(results[i], right)) {
      missed.push_back(static_cast<int>(i));
    }
  }
  return missed;
}

class HeldOutEvaluator {
 public:
  HeldOutEvaluator(const localizer::Localizer& localizer,
                   dataset::Dataset frames, accuracy::EvaluationOptions options)
      : localizer_(localizer),
        frames_(std::move(frames)),
        options_(std::move(options)) {}

  absl::StatusOr<HeldOutEvaluation> Run() {
    const bool metres = localizer_.info().units_are_metres;
    const bool asks_with_depth =
        HasDepth(frames_) && localizer_.depth_use() != DepthUse::kIgnored;
    TL_RETURN_IF_ERROR(
        Ask(asks_with_depth ? "colour and depth" : "colour alone", {}));
    if (asks_with_depth && localizer_.depth_use() == DepthUse::kWhereGiven) {
      TL_ASSIGN_OR_RETURN(std::vector<accuracy::Perturbation> no_depth,
                          accuracy::ParsePerturbations("no-depth"));
      TL_RETURN_IF_ERROR(Ask("colour alone", std::move(no_depth.front())));
    }
    evaluation_.right_within =
        metres
            ? absl::StrFormat("%g cm and %g degrees",
                              100 * right_.translation_m, right_.rotation_deg)
            : absl::StrFormat("1 %% of the scene's size and %g degrees",
                              right_.rotation_deg);
    TL_RETURN_IF_ERROR(AskAboutNothing());
    return std::move(evaluation_);
  }

 private:
  absl::Status Ask(const std::string& queries,
                   accuracy::Perturbation perturbation) {
    options_.perturbation = std::move(perturbation);
    TL_ASSIGN_OR_RETURN(
        const std::vector<FrameResult> results,
        accuracy::Evaluate(localizer_, frames_, options_, base::SteadyClock()));
    options_.perturbation = {};
    const bool metres = localizer_.info().units_are_metres;
    right_ = accuracy::RightWithin(results, metres);
    evaluation_.trials.push_back(TrialOf(queries, results, right_));
    const std::vector<int> missed = Missed(results, right_);
    if (static_cast<int>(missed.size()) <= evaluation_.missed) {
      return absl::OkStatus();
    }
    evaluation_.missed = static_cast<int>(missed.size());
    evaluation_.missed_world_from_camera.clear();
    for (const int frame : missed) {
      evaluation_.missed_world_from_camera.push_back(
          *results[static_cast<size_t>(frame)].true_world_from_camera);
    }
    TakePictures(results, missed);
    return absl::OkStatus();
  }

  // Evenly spread: neighbours show the same.
  void TakePictures(const std::vector<FrameResult>& results,
                    const std::vector<int>& missed) {
    std::vector<accuracy::PictureChoice> choices;
    const int64_t count = static_cast<int64_t>(missed.size());
    const int64_t shown = std::min<int64_t>(count, kMissedPictures);
    for (int64_t k = 0; k < shown; ++k) {
      choices.push_back(
          {.frame =
               missed[static_cast<size_t>((2 * k + 1) * count / (2 * shown))],
           .kind = accuracy::PictureKind::kWorst});
    }
    evaluation_.pictures.clear();
    for (accuracy::ReportPicture& picture :
         accuracy::TakePictures(localizer_, frames_, choices, options_)) {
      const FrameResult& result =
          results[static_cast<size_t>(picture.choice.frame)];
      evaluation_.pictures.push_back(
          {result.stem, WhyMissed(result, localizer_.info().units_are_metres),
           std::move(picture.jpeg)});
    }
  }

  absl::Status AskAboutNothing() {
    TL_ASSIGN_OR_RETURN(const accuracy::NegativeSource source,
                        accuracy::ParseForeignSource(kForeign));
    TL_ASSIGN_OR_RETURN(
        const std::vector<accuracy::NegativeTally> tallies,
        accuracy::AskForeign(localizer_, {source},
                             accuracy::kPublishedConfidence, options_));
    for (const accuracy::NegativeTally& tally : tallies) {
      evaluation_.foreign_pictures += tally.images - tally.refused;
      evaluation_.foreign_answered += tally.accepted;
    }
    return absl::OkStatus();
  }

  const localizer::Localizer& localizer_;
  const dataset::Dataset frames_;
  accuracy::EvaluationOptions options_;
  accuracy::PoseThreshold right_;
  HeldOutEvaluation evaluation_;
};

}  // namespace

absl::StatusOr<HeldOutEvaluation> EvaluateHeldOut(
    const std::string& model_path, const dataset::Dataset& held_out,
    const dataset::DatasetOptions& options, uint64_t seed, bool quiet,
    const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<localizer::Localizer> localizer,
                      localizer::OpenLocalizer(model_path));
  accuracy::EvaluationOptions evaluation;
  evaluation.seed = seed;
  evaluation.threads =
      std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 64);
  evaluation.calibration = accuracy::QueryCalibration(
      held_out, options, localizer->info().calibration);
  evaluation.quiet = quiet;
  evaluation.stop = stop;
  TL_RETURN_IF_ERROR(evaluation.Validate());
  return HeldOutEvaluator(*localizer, EvenlySpread(held_out, kMaxFrames),
                          evaluation)
      .Run();
}

}  // namespace treeline::tools_app
