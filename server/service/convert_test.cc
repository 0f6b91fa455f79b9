#include "server/service/convert.h"

#include <string>

#include "common/wire/camera.h"
#include "common/wire/geometry.h"
#include "gtest/gtest.h"
#include "server/service/service_test_util.h"

namespace treeline::service {
namespace {

TEST(Convert, ALocalizedEstimateArrivesBitForBit) {
  const localizer::PoseEstimate estimate = LocalizedEstimate();
  const v1::LocalizeResponse proto =
      ToProto(estimate, camera::RgbdSensor::kDepth);
  EXPECT_EQ(proto.outcome(), v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(proto.reason(), v1::NOT_LOCALIZED_REASON_UNSPECIFIED);
  const auto pose = wire::FromProto(proto.world_from_camera(), "pose");
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(*pose, estimate.world_from_camera);
  ASSERT_EQ(proto.covariance_size(), 36);
  for (int i = 0; i < 36; ++i) {
    EXPECT_EQ(proto.covariance(i), estimate.covariance[static_cast<size_t>(i)]);
  }
  EXPECT_EQ(proto.pose_sensor(), v1::RGBD_SENSOR_DEPTH);
  EXPECT_EQ(proto.inliers(), 432);
  EXPECT_EQ(proto.samples(), 500);
  EXPECT_EQ(proto.inlier_ratio(), 432.0 / 500);
  EXPECT_FALSE(proto.has_focal_scale());
  EXPECT_FALSE(proto.has_depth_scale());
}

TEST(Convert, WhatIsNotLocalizedHasNoPose) {
  localizer::PoseEstimate estimate = LocalizedEstimate();
  estimate.outcome = localizer::Outcome::kNotLocalized;
  estimate.reason = localizer::NotLocalizedReason::kPoorlyConstrained;
  const v1::LocalizeResponse proto =
      ToProto(estimate, camera::RgbdSensor::kColor);
  EXPECT_EQ(proto.outcome(), v1::OUTCOME_NOT_LOCALIZED);
  EXPECT_EQ(proto.reason(), v1::NOT_LOCALIZED_REASON_POORLY_CONSTRAINED);
  EXPECT_FALSE(proto.has_world_from_camera());
  EXPECT_EQ(proto.covariance_size(), 0);
  // The evidence stays.
  EXPECT_EQ(proto.inliers(), 432);
  EXPECT_EQ(proto.pose_sensor(), v1::RGBD_SENSOR_COLOR);
}

TEST(Convert, AFocalLengthThatDoesNotFitIsSaid) {
  localizer::PoseEstimate estimate = LocalizedEstimate();
  estimate.focal_scale = 0.95;
  EXPECT_EQ(ToProto(estimate, camera::RgbdSensor::kColor).focal_scale(), 0.95);
}

TEST(Convert, ACameraThatNobodyStatedIsTold) {
  localizer::PoseEstimate estimate = LocalizedEstimate();
  estimate.focal_scale = 0.95;
  estimate.found_camera = camera::Camera();
  v1::LocalizeResponse proto = ToProto(estimate, camera::RgbdSensor::kColor);
  EXPECT_EQ(wire::FromProto(proto.camera(), "camera").value(),
            *estimate.found_camera);
  EXPECT_FALSE(proto.has_focal_scale());
  estimate.outcome = localizer::Outcome::kNotLocalized;
  EXPECT_FALSE(ToProto(estimate, camera::RgbdSensor::kColor).has_camera());
}

TEST(Convert, DepthThatDoesNotFitIsSaid) {
  localizer::PoseEstimate estimate = LocalizedEstimate();
  estimate.depth_scale = 1.04;
  EXPECT_EQ(ToProto(estimate, camera::RgbdSensor::kColor).depth_scale(), 1.04);
}

TEST(Convert, EachReasonHasItsOwnNumber) {
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kNone), 0);
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kTooFewSamples), 1);
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kTooFewInliers), 2);
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kPoorlyConstrained), 3);
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kLowConfidence), 4);
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kContradictsPrior), 5);
  EXPECT_EQ(ToProto(localizer::NotLocalizedReason::kContradictsDepth), 6);
}

TEST(Convert, CorrespondencesKeepTheirPlaces) {
  localizer::PoseEstimate estimate = LocalizedEstimate();
  estimate.correspondences = {
      {.color_pixel = {1, 2},
       .point_in_camera = {0.1, 0.2, 0.3},
       .point_in_world = {4, 5, 6},
       .inlier = true},
      {.color_pixel = {3, 4}, .point_in_camera = {}, .point_in_world = {}}};
  const v1::LocalizeResponse proto =
      ToProto(estimate, camera::RgbdSensor::kColor);
  ASSERT_EQ(proto.correspondences_size(), 2);
  const v1::Correspondence& first = proto.correspondences(0);
  EXPECT_EQ(first.color_pixel().x_px(), 1);
  EXPECT_EQ(first.color_pixel().y_px(), 2);
  EXPECT_EQ(*wire::FromProto(first.point_in_camera_m(), ""),
            (geometry::Vec3{0.1, 0.2, 0.3}));
  EXPECT_EQ(*wire::FromProto(first.point_in_world_m(), ""),
            (geometry::Vec3{4, 5, 6}));
  EXPECT_TRUE(first.inlier());
  EXPECT_FALSE(proto.correspondences(1).inlier());
}

forest::ModelInfo SomeInfo() {
  forest::ModelInfo info;
  info.format_version = 3;
  info.method = "rgbd";
  info.software_version = "0.1.0";
  info.created_utc = "2026-11-21T09:30:00Z";
  info.dataset = "7scenes:/data/redkitchen";
  info.seed = 18446744073709551615u;
  info.options = {{"trees", "5"}, {"seed", "1"}};
  info.calibration = TestCalibration();
  info.bounds_min_in_world = {-1, -2, -3};
  info.bounds_max_in_world = {1, 2, 3.5};
  info.training_frames = 500;
  info.training_samples = 2'500'000'000;
  info.training_s = 41.5;
  info.trees = 5;
  info.nodes = 1'000'001;
  info.leaves = 500'001;
  info.file_bytes = 5'000'000'000;
  info.checksum = "0123456789abcdef";
  return info;
}

TEST(Convert, ModelInfoKeepsEveryField) {
  const v1::ModelInfo proto = ToProto(SomeInfo());
  EXPECT_EQ(proto.format_version(), 3u);
  EXPECT_EQ(proto.method(), "rgbd");
  EXPECT_EQ(proto.software_version(), "0.1.0");
  EXPECT_EQ(proto.created_utc(), "2026-11-21T09:30:00Z");
  EXPECT_EQ(proto.dataset(), "7scenes:/data/redkitchen");
  EXPECT_EQ(proto.seed(), 18446744073709551615u);
  ASSERT_EQ(proto.options_size(), 2);
  EXPECT_EQ(proto.options(0).name(), "trees");
  EXPECT_EQ(proto.options(0).value(), "5");
  EXPECT_EQ(*wire::FromProto(proto.calibration(), ""), TestCalibration());
  EXPECT_EQ(*wire::FromProto(proto.bounds_min_in_world_m(), ""),
            (geometry::Vec3{-1, -2, -3}));
  EXPECT_EQ(*wire::FromProto(proto.bounds_max_in_world_m(), ""),
            (geometry::Vec3{1, 2, 3.5}));
  EXPECT_EQ(proto.training_frames(), 500);
  EXPECT_EQ(proto.training_samples(), 2'500'000'000);
  EXPECT_EQ(proto.training_s(), 41.5);
  EXPECT_EQ(proto.trees(), 5);
  EXPECT_EQ(proto.nodes(), 1'000'001);
  EXPECT_EQ(proto.leaves(), 500'001);
  EXPECT_EQ(proto.file_bytes(), 5'000'000'000u);
  EXPECT_EQ(proto.checksum(), "0123456789abcdef");
}

TEST(Convert, ASceneThatFailedSaysWhy) {
  repository::SceneStatus status;
  status.name = "office";
  status.state = repository::SceneState::kFailed;
  status.failure = absl::DataLossError("checksum differs");
  status.versions = {
      {"2", repository::SceneState::kFailed, status.failure},
      {"1", repository::SceneState::kUnloaded, absl::OkStatus()}};
  const v1::SceneInfo proto = ToProto(status);
  EXPECT_EQ(proto.scene(), "office");
  EXPECT_EQ(proto.state(), v1::SCENE_STATE_FAILED);
  EXPECT_EQ(proto.failure().code(), "DATA_LOSS");
  EXPECT_EQ(proto.failure().message(), "checksum differs");
  EXPECT_EQ(proto.model_version(), "");
  EXPECT_FALSE(proto.has_model());
  ASSERT_EQ(proto.versions_size(), 2);
  EXPECT_EQ(proto.versions(0).version(), "2");
  EXPECT_EQ(proto.versions(0).failure().code(), "DATA_LOSS");
  EXPECT_EQ(proto.versions(1).state(), v1::SCENE_STATE_UNLOADED);
  EXPECT_FALSE(proto.versions(1).has_failure());
}

TEST(Convert, WhatSceneJsonSaysIsPassedOn) {
  repository::SceneStatus status;
  status.name = "kitchen";
  status.resident_bytes = 5'000'000'000;
  status.versions = {
      {"1", repository::SceneState::kUnloaded, absl::OkStatus()}};
  const v1::SceneInfo without = ToProto(status);
  EXPECT_EQ(without.display_name(), "");
  EXPECT_FALSE(without.has_geo_anchor());
  EXPECT_FALSE(without.has_default_camera());
  EXPECT_EQ(without.resident_bytes(), 5'000'000'000u);

  repository::SceneMetadata metadata;
  metadata.display_name = "Küche";
  metadata.geo_anchor = repository::GeoAnchor{
      .latitude_deg = 49.5,
      .longitude_deg = -8.25,
      .height_m = 191,
      .enu_from_world = repository::EnuFromWorldOfHeading(90)};
  metadata.camera = TestCalibration().color;
  status.metadata = std::make_shared<const repository::SceneMetadata>(metadata);
  const v1::SceneInfo proto = ToProto(status);
  EXPECT_EQ(proto.display_name(), "Küche");
  EXPECT_EQ(proto.geo_anchor().latitude_deg(), 49.5);
  EXPECT_EQ(proto.geo_anchor().longitude_deg(), -8.25);
  EXPECT_EQ(proto.geo_anchor().height_m(), 191);
  const geometry::Rotation3 rotation = repository::EnuFromWorldOfHeading(90);
  EXPECT_EQ(proto.geo_anchor().enu_from_world().w(), rotation.w);
  EXPECT_EQ(proto.geo_anchor().enu_from_world().x(), rotation.x);
  EXPECT_EQ(proto.geo_anchor().enu_from_world().y(), rotation.y);
  EXPECT_EQ(proto.geo_anchor().enu_from_world().z(), rotation.z);
  EXPECT_EQ(*wire::FromProto(proto.default_camera(), ""), *metadata.camera);
}

TEST(Convert, ASceneThatServesDescribesItsModel) {
  const FakeScenes scenes(
      {{"kitchen", [](auto&, auto&) { return LocalizedEstimate(); }}});
  const v1::SceneInfo proto = ToProto(*scenes.repository().Get("kitchen"));
  EXPECT_EQ(proto.state(), v1::SCENE_STATE_READY);
  EXPECT_FALSE(proto.has_failure());
  EXPECT_EQ(proto.model_version(), "1");
  EXPECT_EQ(proto.model().method(), "kitchen");
}

}  // namespace
}  // namespace treeline::service
