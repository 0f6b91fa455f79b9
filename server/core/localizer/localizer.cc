#include "server/core/localizer/localizer.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/forest/backtracking.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/methods.h"
#include "server/core/localizer/oriented_localizer.h"
#include "server/core/localizer/pipeline.h"

namespace treeline::localizer {

absl::Status QueryOptions::Validate() const {
  const auto check = [](absl::string_view name, int value, int low, int high) {
    if (value >= low && value <= high) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is ", value, "; it must be between ", low, " and ", high));
  };
  TL_RETURN_IF_ERROR(check("samples", samples, 30, 20000));
  TL_RETURN_IF_ERROR(check("backtracking leaves", backtracking_leaves, 1,
                           forest::kMaxBacktrackingLeaves));
  TL_RETURN_IF_ERROR(check("first samples", first_samples, 30, 20000));
  TL_RETURN_IF_ERROR(check("settled inliers", settled_inliers, 1, 20000));
  TL_RETURN_IF_ERROR(
      check("first leaves", first_leaves, 1, forest::kMaxBacktrackingLeaves));
  TL_RETURN_IF_ERROR(check("good distance", good_distance, 0, 2000));
  TL_RETURN_IF_ERROR(check("features", features, 100, 100000));
  return check("hypotheses", hypotheses, 1, 10000);
}

void SetTotal(double total_ms, LocalizeTimings& timings) {
  timings.total_ms = total_ms;
  timings.pose_ms = total_ms - timings.sample_ms - timings.forest_ms;
}

void Add(const LocalizeTimings& more, LocalizeTimings& sums) {
  sums.sample_ms += more.sample_ms;
  sums.forest_ms += more.forest_ms;
  sums.pose_ms += more.pose_ms;
  sums.total_ms += more.total_ms;
  sums.features_ms += more.features_ms;
  sums.verify_ms += more.verify_ms;
}

bool IsBetter(const PoseEstimate& a, const PoseEstimate& b) {
  if (a.outcome != b.outcome) return a.outcome == Outcome::kLocalized;
  return a.confidence > b.confidence;
}

absl::StatusOr<std::unique_ptr<Localizer>> OpenLocalizer(
    const std::string& model_path, const QueryOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(std::unique_ptr<const forest::ModelFile> model,
                      forest::ModelFile::Open(model_path));
  absl::StatusOr<Method> method = MakeMethod(*model, options);
  if (!method.ok()) return base::Annotate(method.status(), model_path);
  return std::make_unique<OrientedLocalizer>(
      std::make_unique<Pipeline>(std::move(model), *std::move(method)),
      options.other_turns);
}

absl::string_view OutcomeName(Outcome outcome) {
  return outcome == Outcome::kLocalized ? "LOCALIZED" : "NOT_LOCALIZED";
}

absl::string_view ReasonName(NotLocalizedReason reason) {
  switch (reason) {
    case NotLocalizedReason::kNone:
      return "NONE";
    case NotLocalizedReason::kTooFewSamples:
      return "TOO_FEW_SAMPLES";
    case NotLocalizedReason::kTooFewInliers:
      return "TOO_FEW_INLIERS";
    case NotLocalizedReason::kPoorlyConstrained:
      return "POORLY_CONSTRAINED";
    case NotLocalizedReason::kLowConfidence:
      return "LOW_CONFIDENCE";
    case NotLocalizedReason::kContradictsPrior:
      return "CONTRADICTS_PRIOR";
    case NotLocalizedReason::kContradictsDepth:
      return "CONTRADICTS_DEPTH";
    case NotLocalizedReason::kUnknownCamera:
      return "UNKNOWN_CAMERA";
  }
  return "UNKNOWN";
}

}  // namespace treeline::localizer
