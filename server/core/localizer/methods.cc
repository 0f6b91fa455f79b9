#include "server/core/localizer/methods.h"

#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/color_ray_source.h"
#include "server/core/localizer/depth_point_source.h"
#include "server/core/localizer/keyframe_source.h"
#include "server/core/localizer/keyframe_verifier.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/point_line_source.h"
#include "server/core/localizer/sift_generator.h"
#include "server/core/localizer/support_verifier.h"

namespace treeline::localizer {
namespace {

template <PoseSource Source>
std::unique_ptr<const CandidateGenerator> From(Source source,
                                               const QueryOptions& options) {
  return std::make_unique<SourceGenerator<Source>>(std::move(source), options);
}

absl::Status CheckPointLineModel(const forest::ModelFile& model) {
  if (model.forests() == 2 &&
      model.forest(0).trees() == model.forest(1).trees()) {
    return absl::OkStatus();
  }
  return absl::DataLossError(
      absl::StrCat("corrupt model: method points-lines needs two forests of "
                   "as many trees each, the model has ",
                   model.forests(), " forests"));
}

absl::Status CheckSiftModel(const forest::ModelFile& model) {
  if (!model.forest().sift_descriptors.empty() &&
      model.info().viewing_distance > 0) {
    return absl::OkStatus();
  }
  return absl::DataLossError(
      "corrupt model: method sift without SIFT descriptors or without a "
      "viewing distance");
}

// Corrected, unless the options take it as stated.
void AddFocal(const forest::ModelFile& model, const QueryOptions& options,
              Method& method) {
  method.focal_use =
      options.corrects_focal ? FocalUse::kCorrected : FocalUse::kAsStated;
  if (const auto& confidence = model.info().confidence) {
    method.focal_sigma_scale = confidence->focal_sigma_scale;
  }
}

absl::StatusOr<Method> MakeSift(const forest::ModelFile& model,
                                const QueryOptions& options) {
  TL_RETURN_IF_ERROR(CheckSiftModel(model));
  Method method;
  method.verifier = std::make_unique<SupportVerifier>(model.info());
  // Cameras of a structure from motion are exact, each for itself.
  AddFocal(model, options, method);
  method.steps.push_back({std::make_unique<SiftGenerator>(
      model.forest(), model.info().viewing_distance, options)});
  return method;
}

// Keyframes where the pose is expected, `matched` of them.
void AddShortcut(const keyframes::KeyframeMap& keyframes, int matched,
                 const QueryOptions& options, Method& method) {
  method.steps.push_back(
      {.generator =
           From(KeyframeSource(keyframes, KeyframeChoice::kNearPriors, matched),
                options),
       .is_shortcut = true});
}

void AddHybridSteps(const forest::ModelFile& model,
                    const keyframes::KeyframeMap& keyframes,
                    const QueryOptions& options, Method& method) {
  AddShortcut(keyframes, kMatchedKeyframes, options, method);
  method.steps.push_back(
      {From(ColorRaySource(model.forest(), options), options),
       /*is_fallback=*/true});
  for (const KeyframeChoice choice :
       {KeyframeChoice::kNearPose, KeyframeChoice::kMostSimilar}) {
    method.steps.push_back(
        {From(KeyframeSource(keyframes, choice, kMatchedKeyframes), options)});
  }
}

// The cheap one first: a forest, where there is depth.
void AddUniversalSteps(const forest::ModelFile& model,
                       const keyframes::KeyframeMap& keyframes,
                       const QueryOptions& options, Method& method) {
  method.depth_use = DepthUse::kWhereGiven;
  method.sufficient_confidence = kSufficientConfidence;
  method.steps.push_back(
      {From(DepthPointSource(model.forest(), options), options)});
  AddShortcut(keyframes, kMatchedLikeKeyframes, options, method);
  for (const KeyframeChoice choice :
       {KeyframeChoice::kMostSimilar, KeyframeChoice::kNearPose}) {
    method.steps.push_back({From(
        KeyframeSource(keyframes, choice, kMatchedLikeKeyframes), options)});
  }
}

}  // namespace

absl::StatusOr<Method> MakeMethod(const forest::ModelFile& model,
                                  const QueryOptions& options) {
  const std::string& name = model.info().method;
  if (const auto& part = model.info().part) {
    return absl::FailedPreconditionError(absl::StrCat(
        "a part of a scene, tree ", part->tree, " of ", part->trees,
        ", answers no queries; make the scene with `treeline merge`"));
  }
  if (name == "sift") return MakeSift(model, options);
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<const KeyframeVerifier> verifier,
      KeyframeVerifier::Create(model, name == "universal"
                                          ? AlignmentUse::kFuses
                                          : AlignmentUse::kReplaces));
  const keyframes::KeyframeMap& keyframes = verifier->keyframes();
  Method method;
  method.verifier = std::move(verifier);
  method.keyframes = &keyframes;
  AddFocal(model, options, method);
  if (name == "rgbd") {
    method.depth_use = DepthUse::kRequired;
    method.steps.push_back(
        {From(DepthPointSource(model.forest(), options), options)});
  } else if (name == "points-lines") {
    TL_RETURN_IF_ERROR(CheckPointLineModel(model));
    method.depth_use = DepthUse::kRequired;
    method.steps.push_back({From(
        PointLineSource(model.forest(0), model.forest(1), options), options)});
  } else if (name == "rgb") {
    method.steps.push_back(
        {From(ColorRaySource(model.forest(), options), options)});
  } else if (name == "universal") {
    AddUniversalSteps(model, keyframes, options, method);
  } else if (name == "hybrid") {
    AddHybridSteps(model, keyframes, options, method);
  } else {
    return absl::UnimplementedError(
        absl::StrCat("method \"", name, "\" is not known to this version"));
  }
  return method;
}

}  // namespace treeline::localizer
