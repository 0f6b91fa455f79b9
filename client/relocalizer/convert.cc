#include "client/relocalizer/convert.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/wire/camera.h"
#include "common/wire/frame.h"
#include "common/wire/geometry.h"
#include "common/wire/pose_prior.h"

namespace treeline::relocalizer {
namespace {

absl::Status BrokenContract(const absl::Status& problem) {
  return absl::InternalError(
      absl::StrCat("the server's answer is not valid: ", problem.message()));
}

// An enumerator's name without the prefix that all of its enum have. One that a
// newer server knows and this client does not has no name: its number.
std::string ShortName(const std::string& name, absl::string_view prefix,
                      int number) {
  if (name.empty()) return absl::StrCat(number);
  const absl::string_view rest = absl::StripPrefix(name, prefix);
  return std::string(rest.data(), rest.size());
}

absl::Status FillPose(const v1::LocalizeResponse& response,
                      LocalizeAnswer& answer) {
  TL_ASSIGN_OR_RETURN(
      answer.world_from_camera,
      FromProto(response.world_from_camera(), "world_from_camera"));
  if (response.covariance_size() !=
      static_cast<int>(answer.covariance.size())) {
    return wire::FieldError(
        "covariance", absl::StrCat(response.covariance_size(), " entries"));
  }
  std::copy(response.covariance().begin(), response.covariance().end(),
            answer.covariance.begin());
  for (const double entry : answer.covariance) {
    if (!std::isfinite(entry)) {
      return wire::FieldError("covariance", "has a NaN or an infinity");
    }
  }
  TL_ASSIGN_OR_RETURN(answer.pose_sensor,
                      FromProto(response.pose_sensor(), "pose_sensor"));
  return absl::OkStatus();
}

ServerTimings TimingsFromProto(const v1::Timings& timings) {
  return {.queue_ms = timings.queue_ms(),
          .decode_ms = timings.decode_ms(),
          .sample_ms = timings.sample_ms(),
          .forest_ms = timings.forest_ms(),
          .pose_ms = timings.pose_ms(),
          .localize_ms = timings.localize_ms(),
          .total_ms = timings.total_ms(),
          .features_ms = timings.features_ms(),
          .verify_ms = timings.verify_ms()};
}

absl::StatusOr<ModelDescription> ModelFromProto(const v1::ModelInfo& info) {
  ModelDescription model;
  model.method = info.method();
  model.dataset = info.dataset();
  model.created_utc = info.created_utc();
  model.software_version = info.software_version();
  model.checksum = info.checksum();
  TL_ASSIGN_OR_RETURN(model.calibration,
                      FromProto(info.calibration(), "calibration"));
  TL_ASSIGN_OR_RETURN(
      model.bounds_min_in_world,
      FromProto(info.bounds_min_in_world_m(), "bounds_min_in_world_m"));
  TL_ASSIGN_OR_RETURN(
      model.bounds_max_in_world,
      FromProto(info.bounds_max_in_world_m(), "bounds_max_in_world_m"));
  model.training_frames = info.training_frames();
  model.training_s = info.training_s();
  model.trees = info.trees();
  model.leaves = info.leaves();
  model.file_bytes = info.file_bytes();
  return model;
}

}  // namespace

v1::LocalizeRequest ToProto(const LocalizeQuery& query) {
  v1::LocalizeRequest request;
  request.set_scene(query.scene);
  request.set_model_version(query.model_version);
  for (const std::string& scene : query.candidate_scenes) {
    request.add_candidate_scenes(scene);
  }
  *request.mutable_frame() = ToProto(query.frame);
  v1::LocalizeOptions& options = *request.mutable_options();
  options.set_seed(query.seed);
  if (query.time_budget_ms) options.set_time_budget_ms(*query.time_budget_ms);
  if (query.min_confidence) options.set_min_confidence(*query.min_confidence);
  if (query.wants_inlier_pixels) options.set_include_correspondences(true);
  wire::FillPriors(query.priors, options);
  return request;
}

absl::StatusOr<LocalizeAnswer> FromProto(const v1::LocalizeResponse& response) {
  LocalizeAnswer answer;
  switch (response.outcome()) {
    case v1::OUTCOME_LOCALIZED:
      answer.localized = true;
      if (absl::Status filled = FillPose(response, answer); !filled.ok()) {
        return BrokenContract(filled);
      }
      break;
    case v1::OUTCOME_NOT_LOCALIZED:
      break;
    default:
      return BrokenContract(wire::FieldError("outcome", "is neither"));
  }
  answer.reason =
      response.reason() == v1::NOT_LOCALIZED_REASON_UNSPECIFIED
          ? "NONE"
          : ShortName(v1::NotLocalizedReason_Name(response.reason()),
                      "NOT_LOCALIZED_REASON_", response.reason());
  answer.inliers = response.inliers();
  answer.samples = response.samples();
  answer.inlier_ratio = response.inlier_ratio();
  if (response.has_focal_scale()) answer.focal_scale = response.focal_scale();
  if (response.has_camera()) {
    const absl::StatusOr<camera::Camera> camera =
        wire::FromProto(response.camera(), "camera");
    if (!camera.ok()) return BrokenContract(camera.status());
    answer.camera = *camera;
  }
  if (response.has_depth_scale()) answer.depth_scale = response.depth_scale();
  for (const v1::Correspondence& sample : response.correspondences()) {
    if (!sample.inlier()) continue;
    answer.inlier_pixels.push_back(
        {sample.color_pixel().x_px(), sample.color_pixel().y_px()});
  }
  answer.confidence = response.confidence();
  answer.confidence_threshold = response.confidence_threshold();
  answer.scene = response.scene();
  answer.model_version = response.model_version();
  for (const v1::SceneCandidate& candidate : response.candidates()) {
    answer.candidates.push_back(
        {.scene = candidate.scene(),
         .similarity = candidate.similarity(),
         .tried = candidate.tried(),
         .localized = candidate.outcome() == v1::OUTCOME_LOCALIZED,
         .confidence = candidate.confidence(),
         .inliers = candidate.inliers()});
  }
  answer.server = TimingsFromProto(response.timings());
  return answer;
}

absl::StatusOr<SceneDescription> FromProto(const v1::SceneInfo& info) {
  SceneDescription scene;
  scene.name = info.scene();
  scene.state = ShortName(v1::SceneState_Name(info.state()), "SCENE_STATE_",
                          info.state());
  if (info.has_failure()) {
    scene.failure =
        absl::StrCat(info.failure().code(), ": ", info.failure().message());
  }
  scene.model_version = info.model_version();
  for (const v1::ModelVersion& version : info.versions()) {
    scene.versions.push_back(version.version());
  }
  scene.display_name = info.display_name();
  scene.resident_bytes = info.resident_bytes();
  if (info.has_model()) {
    absl::StatusOr<ModelDescription> model = ModelFromProto(info.model());
    if (!model.ok()) return BrokenContract(model.status());
    scene.model = *std::move(model);
  }
  return scene;
}

}  // namespace treeline::relocalizer
