#include "server/service/convert.h"

#include <string>

#include "common/wire/camera.h"
#include "common/wire/geometry.h"

namespace treeline::service {
namespace {

v1::LoadFailure FailureToProto(const absl::Status& failure) {
  v1::LoadFailure proto;
  proto.set_code(absl::StatusCodeToString(failure.code()));
  proto.set_message(std::string(failure.message()));
  return proto;
}

v1::Correspondence CorrespondenceToProto(
    const localizer::Correspondence& sample) {
  v1::Correspondence proto;
  *proto.mutable_color_pixel() = ToProto(sample.color_pixel);
  *proto.mutable_point_in_camera_m() = ToProto(sample.point_in_camera);
  *proto.mutable_point_in_world_m() = ToProto(sample.point_in_world);
  proto.set_inlier(sample.inlier);
  return proto;
}

}  // namespace

v1::Outcome ToProto(localizer::Outcome outcome) {
  switch (outcome) {
    case localizer::Outcome::kLocalized:
      return v1::OUTCOME_LOCALIZED;
    case localizer::Outcome::kNotLocalized:
      return v1::OUTCOME_NOT_LOCALIZED;
  }
  return v1::OUTCOME_UNSPECIFIED;
}

v1::NotLocalizedReason ToProto(localizer::NotLocalizedReason reason) {
  switch (reason) {
    case localizer::NotLocalizedReason::kNone:
      return v1::NOT_LOCALIZED_REASON_UNSPECIFIED;
    case localizer::NotLocalizedReason::kTooFewSamples:
      return v1::NOT_LOCALIZED_REASON_TOO_FEW_SAMPLES;
    case localizer::NotLocalizedReason::kTooFewInliers:
      return v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS;
    case localizer::NotLocalizedReason::kPoorlyConstrained:
      return v1::NOT_LOCALIZED_REASON_POORLY_CONSTRAINED;
    case localizer::NotLocalizedReason::kLowConfidence:
      return v1::NOT_LOCALIZED_REASON_LOW_CONFIDENCE;
    case localizer::NotLocalizedReason::kContradictsDepth:
      return v1::NOT_LOCALIZED_REASON_CONTRADICTS_DEPTH;
    case localizer::NotLocalizedReason::kUnknownCamera:
      return v1::NOT_LOCALIZED_REASON_UNKNOWN_CAMERA;
    case localizer::NotLocalizedReason::kContradictsPrior:
      return v1::NOT_LOCALIZED_REASON_CONTRADICTS_PRIOR;
  }
  return v1::NOT_LOCALIZED_REASON_UNSPECIFIED;
}

v1::Timings ToProto(const CallTimings& timings) {
  v1::Timings proto;
  proto.set_queue_ms(timings.queue_ms);
  proto.set_decode_ms(timings.decode_ms);
  proto.set_sample_ms(timings.localize.sample_ms);
  proto.set_forest_ms(timings.localize.forest_ms);
  proto.set_pose_ms(timings.localize.pose_ms);
  proto.set_features_ms(timings.localize.features_ms);
  proto.set_verify_ms(timings.localize.verify_ms);
  proto.set_localize_ms(timings.localize.total_ms);
  proto.set_total_ms(timings.total_ms);
  return proto;
}

v1::LocalizeResponse ToProto(const localizer::PoseEstimate& estimate,
                             camera::RgbdSensor pose_sensor) {
  v1::LocalizeResponse proto;
  proto.set_outcome(ToProto(estimate.outcome));
  proto.set_reason(ToProto(estimate.reason));
  if (estimate.outcome == localizer::Outcome::kLocalized) {
    *proto.mutable_world_from_camera() = ToProto(estimate.world_from_camera);
    proto.mutable_covariance()->Add(estimate.covariance.begin(),
                                    estimate.covariance.end());
  }
  proto.set_pose_sensor(ToProto(pose_sensor));
  proto.set_inliers(estimate.inliers);
  proto.set_samples(estimate.samples);
  proto.set_inlier_ratio(estimate.inlier_ratio);
  if (!estimate.found_camera) {
    if (estimate.focal_scale != 1) proto.set_focal_scale(estimate.focal_scale);
  } else if (estimate.outcome == localizer::Outcome::kLocalized) {
    *proto.mutable_camera() = wire::ToProto(*estimate.found_camera);
  }
  if (estimate.depth_scale != 1) proto.set_depth_scale(estimate.depth_scale);
  proto.set_confidence(estimate.confidence);
  for (const localizer::Correspondence& sample : estimate.correspondences) {
    *proto.add_correspondences() = CorrespondenceToProto(sample);
  }
  return proto;
}

v1::SceneCandidate ToProto(const recognition::ConsideredScene& scene) {
  v1::SceneCandidate proto;
  proto.set_scene(scene.scene);
  proto.set_similarity(scene.similarity);
  proto.set_tried(scene.tried);
  if (!scene.tried) return proto;
  proto.set_outcome(ToProto(scene.outcome));
  proto.set_confidence(scene.confidence);
  proto.set_inliers(scene.inliers);
  return proto;
}

v1::SceneState ToProto(repository::SceneState state) {
  switch (state) {
    case repository::SceneState::kUnloaded:
      return v1::SCENE_STATE_UNLOADED;
    case repository::SceneState::kLoading:
      return v1::SCENE_STATE_LOADING;
    case repository::SceneState::kReady:
      return v1::SCENE_STATE_READY;
    case repository::SceneState::kFailed:
      return v1::SCENE_STATE_FAILED;
  }
  return v1::SCENE_STATE_UNSPECIFIED;
}

v1::ModelInfo ToProto(const forest::ModelInfo& info) {
  v1::ModelInfo proto;
  proto.set_format_version(info.format_version);
  proto.set_method(info.method);
  proto.set_software_version(info.software_version);
  proto.set_created_utc(info.created_utc);
  proto.set_dataset(info.dataset);
  proto.set_seed(info.seed);
  for (const auto& [name, value] : info.options) {
    v1::TrainingOption& option = *proto.add_options();
    option.set_name(name);
    option.set_value(value);
  }
  *proto.mutable_calibration() = ToProto(info.calibration);
  *proto.mutable_bounds_min_in_world_m() = ToProto(info.bounds_min_in_world);
  *proto.mutable_bounds_max_in_world_m() = ToProto(info.bounds_max_in_world);
  proto.set_training_frames(info.training_frames);
  proto.set_training_samples(info.training_samples);
  proto.set_training_s(info.training_s);
  proto.set_trees(info.trees);
  proto.set_nodes(info.nodes);
  proto.set_leaves(info.leaves);
  proto.set_file_bytes(info.file_bytes);
  proto.set_checksum(info.checksum);
  return proto;
}

v1::GeoAnchor ToProto(const repository::GeoAnchor& anchor) {
  v1::GeoAnchor proto;
  proto.set_latitude_deg(anchor.latitude_deg);
  proto.set_longitude_deg(anchor.longitude_deg);
  proto.set_height_m(anchor.height_m);
  *proto.mutable_enu_from_world() = ToProto(anchor.enu_from_world);
  return proto;
}

v1::SceneInfo ToProto(const repository::SceneStatus& status) {
  v1::SceneInfo proto;
  proto.set_scene(status.name);
  proto.set_state(ToProto(status.state));
  if (!status.failure.ok()) {
    *proto.mutable_failure() = FailureToProto(status.failure);
  }
  if (status.serving != nullptr) {
    proto.set_model_version(status.serving->version);
    *proto.mutable_model() = ToProto(status.serving->localizer->info());
  }
  proto.set_resident_bytes(status.resident_bytes);
  if (status.metadata != nullptr) {
    proto.set_display_name(status.metadata->display_name);
    if (status.metadata->geo_anchor) {
      *proto.mutable_geo_anchor() = ToProto(*status.metadata->geo_anchor);
    }
    if (status.metadata->camera) {
      *proto.mutable_default_camera() = ToProto(*status.metadata->camera);
    }
  }
  for (const repository::VersionStatus& version : status.versions) {
    v1::ModelVersion& entry = *proto.add_versions();
    entry.set_version(version.version);
    entry.set_state(ToProto(version.state));
    if (!version.failure.ok()) {
      *entry.mutable_failure() = FailureToProto(version.failure);
    }
  }
  return proto;
}

}  // namespace treeline::service
