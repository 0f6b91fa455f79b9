#include "client/relocalizer/convert.h"

#include <limits>
#include <string>

#include "common/wire/camera.h"
#include "common/wire/geometry.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::relocalizer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

geometry::Rigid3 SomePose() {
  return {geometry::Normalized(
              geometry::Rotation3::FromAxisAngle({0.3, -1.1, 0.7})),
          {1.25, 0.1, -3}};
}

v1::LocalizeResponse Localized() {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  *response.mutable_world_from_camera() = ToProto(SomePose());
  for (int i = 0; i < 36; ++i) response.add_covariance(1e-7 * i);
  response.set_pose_sensor(v1::RGBD_SENSOR_DEPTH);
  response.set_inliers(321);
  response.set_samples(500);
  response.set_inlier_ratio(0.642);
  response.set_focal_scale(0.955);
  *response.mutable_camera() = wire::ToProto(
      *camera::Camera::Parse("SIMPLE_PINHOLE,31,19.5,14.5", 40, 30));
  response.set_depth_scale(1.035);
  v1::Correspondence& inlier = *response.add_correspondences();
  inlier.mutable_color_pixel()->set_x_px(12.5);
  inlier.mutable_color_pixel()->set_y_px(3);
  inlier.set_inlier(true);
  response.add_correspondences()->mutable_color_pixel()->set_x_px(99);
  response.set_scene("kitchen");
  response.set_model_version("7");
  response.set_confidence_threshold(0.9);
  response.mutable_timings()->set_queue_ms(1);
  response.mutable_timings()->set_decode_ms(2);
  response.mutable_timings()->set_sample_ms(3);
  response.mutable_timings()->set_forest_ms(4);
  response.mutable_timings()->set_pose_ms(5);
  response.mutable_timings()->set_localize_ms(6);
  response.mutable_timings()->set_total_ms(7);
  v1::SceneCandidate& candidate = *response.add_candidates();
  candidate.set_scene("kitchen");
  candidate.set_similarity(0.75);
  candidate.set_tried(true);
  candidate.set_outcome(v1::OUTCOME_LOCALIZED);
  candidate.set_confidence(0.5);
  candidate.set_inliers(321);
  response.add_candidates()->set_scene("office");
  return response;
}

TEST(ClientConvert, AnswersKeepEveryFieldBitForBit) {
  const auto answer = FromProto(Localized());
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_TRUE(answer->localized);
  EXPECT_EQ(answer->reason, "NONE");
  EXPECT_EQ(answer->world_from_camera, SomePose());
  for (size_t i = 0; i < 36; ++i) {
    EXPECT_EQ(answer->covariance[i], 1e-7 * static_cast<double>(i));
  }
  EXPECT_EQ(answer->pose_sensor, camera::RgbdSensor::kDepth);
  EXPECT_EQ(answer->inliers, 321);
  EXPECT_EQ(answer->samples, 500);
  EXPECT_EQ(answer->inlier_ratio, 0.642);
  EXPECT_EQ(answer->focal_scale, 0.955);
  EXPECT_EQ(answer->depth_scale, 1.035);
  EXPECT_EQ(answer->camera,
            *camera::Camera::Parse("SIMPLE_PINHOLE,31,19.5,14.5", 40, 30));
  ASSERT_EQ(answer->inlier_pixels.size(), 1U);
  EXPECT_EQ(answer->inlier_pixels[0].x, 12.5);
  EXPECT_EQ(answer->inlier_pixels[0].y, 3);
  EXPECT_EQ(answer->scene, "kitchen");
  EXPECT_EQ(answer->model_version, "7");
  EXPECT_EQ(answer->confidence_threshold, 0.9);
  EXPECT_EQ(answer->server.queue_ms, 1);
  EXPECT_EQ(answer->server.decode_ms, 2);
  EXPECT_EQ(answer->server.sample_ms, 3);
  EXPECT_EQ(answer->server.forest_ms, 4);
  EXPECT_EQ(answer->server.pose_ms, 5);
  EXPECT_EQ(answer->server.localize_ms, 6);
  EXPECT_EQ(answer->server.total_ms, 7);
  ASSERT_EQ(answer->candidates.size(), 2u);
  EXPECT_EQ(answer->candidates[0].scene, "kitchen");
  EXPECT_EQ(answer->candidates[0].similarity, 0.75);
  EXPECT_TRUE(answer->candidates[0].tried);
  EXPECT_TRUE(answer->candidates[0].localized);
  EXPECT_EQ(answer->candidates[0].confidence, 0.5);
  EXPECT_EQ(answer->candidates[0].inliers, 321);
  EXPECT_EQ(answer->candidates[1].scene, "office");
  EXPECT_FALSE(answer->candidates[1].tried);
}

TEST(ClientConvert, NotLocalizedNeedsNoPose) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
  response.set_reason(v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS);
  const auto answer = FromProto(response);
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_FALSE(answer->localized);
  EXPECT_EQ(answer->reason, "TOO_FEW_INLIERS");
}

TEST(ClientConvert, AReasonOfANewerServerIsItsNumber) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
  response.set_reason(static_cast<v1::NotLocalizedReason>(42));
  EXPECT_EQ(FromProto(response)->reason, "42");
}

// A pose that is none must never reach a robot as if it were one.
TEST(ClientConvert, AServerThatBreaksTheContractIsAnError) {
  const auto refused = [](auto change) {
    v1::LocalizeResponse response = Localized();
    change(response);
    const absl::Status status = FromProto(response).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
    return std::string(status.message());
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refused([](auto& r) { r.clear_world_from_camera(); }),
              HasSubstr("world_from_camera"));
  EXPECT_THAT(
      refused([&](auto& r) {
        r.mutable_world_from_camera()->mutable_translation_m()->set_x(nan);
      }),
      HasSubstr("world_from_camera"));
  EXPECT_THAT(refused([](auto& r) { r.mutable_covariance()->RemoveLast(); }),
              HasSubstr("covariance"));
  EXPECT_THAT(refused([&](auto& r) { r.set_covariance(0, nan); }),
              HasSubstr("covariance"));
  EXPECT_THAT(refused([](auto& r) { r.clear_pose_sensor(); }),
              HasSubstr("pose_sensor"));
  EXPECT_THAT(refused([](auto& r) { r.clear_outcome(); }),
              HasSubstr("outcome"));
}

TEST(ClientConvert, QueriesKeepEveryField) {
  LocalizeQuery query;
  query.scene = "kitchen";
  query.model_version = "7";
  query.candidate_scenes = {"kitchen", "office"};
  query.seed = 18446744073709551615u;
  query.time_budget_ms = 250;
  query.min_confidence = 0.4;
  query.wants_inlier_pixels = true;
  query.priors.pose = geometry::PosePrior{.world_from_camera = SomePose(),
                                          .position_radius_m = 4,
                                          .rotation_radius_rad = 0.5};
  query.priors.position = geometry::PositionPrior{{1, 2, 3}, 5};
  query.priors.height = geometry::HeightBand{.min_m = -1, .max_m = 2};
  query.frame.orientation = {image::QuarterTurn::kHalf, true};
  query.frame.gravity_in_camera_mps2 = geometry::Vec3{0, -9.81, 0.5};
  query.frame.color = wire::EncodedImage{"jpeg"};
  query.frame.camera = camera::Camera();
  query.frame.depth =
      wire::QueryDepth{.image = wire::EncodedImage{"png"}, .unit_m = 0.0002};
  const v1::LocalizeRequest request = ToProto(query);
  EXPECT_EQ(request.scene(), "kitchen");
  EXPECT_EQ(request.model_version(), "7");
  EXPECT_EQ(request.options().seed(), 18446744073709551615u);
  EXPECT_THAT(request.candidate_scenes(), ElementsAre("kitchen", "office"));
  EXPECT_EQ(request.options().time_budget_ms(), 250);
  EXPECT_EQ(request.options().min_confidence(), 0.4);
  EXPECT_TRUE(request.options().include_correspondences());
  EXPECT_EQ(*FromProto(request.options().prior().world_from_camera(), ""),
            SomePose());
  EXPECT_EQ(request.options().prior().position_radius_m(), 4);
  EXPECT_EQ(request.options().prior().rotation_radius_rad(), 0.5);
  EXPECT_EQ(request.options().position_prior().radius_m(), 5);
  EXPECT_EQ(request.options().height_band().min_m(), -1);
  EXPECT_EQ(request.frame().orientation(), v1::ORIENTATION_BOTTOM_UP);
  EXPECT_EQ(request.frame().gravity_in_camera_mps2().y(), -9.81);
  EXPECT_EQ(request.frame().color().encoded(), "jpeg");
  EXPECT_EQ(*FromProto(request.frame().camera(), ""), camera::Camera());
  EXPECT_EQ(request.frame().depth().png(), "png");
  EXPECT_EQ(request.frame().depth().unit_m(), 0.0002);
  EXPECT_EQ(request.frame().depth().registration(),
            v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
  const v1::LocalizeRequest plain = ToProto(LocalizeQuery{});
  EXPECT_FALSE(plain.options().has_time_budget_ms());
  EXPECT_FALSE(plain.options().has_min_confidence());
  EXPECT_FALSE(plain.options().include_correspondences());
  EXPECT_FALSE(plain.options().has_prior());
}

v1::SceneInfo SomeScene() {
  v1::SceneInfo info;
  info.set_scene("kitchen");
  info.set_state(v1::SCENE_STATE_READY);
  info.set_model_version("2");
  info.add_versions()->set_version("2");
  info.add_versions()->set_version("1");
  v1::ModelInfo& model = *info.mutable_model();
  info.set_display_name("The kitchen");
  info.set_resident_bytes(6'000'000'000);
  model.set_method("rgbd");
  model.set_dataset("7scenes:kitchen");
  model.set_created_utc("2026-11-21T09:30:00Z");
  model.set_software_version("0.1.0");
  model.set_checksum("0123456789abcdef");
  *model.mutable_calibration() = ToProto(camera::RgbdCalibration{});
  *model.mutable_bounds_min_in_world_m() = ToProto(geometry::Vec3{-1, -2, -3});
  *model.mutable_bounds_max_in_world_m() = ToProto(geometry::Vec3{1, 2, 3});
  model.set_training_frames(500);
  model.set_training_s(41);
  model.set_trees(5);
  model.set_leaves(500'001);
  model.set_file_bytes(5'000'000'000);
  return info;
}

TEST(ClientConvert, ScenesKeepEveryField) {
  const auto scene = FromProto(SomeScene());
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->name, "kitchen");
  EXPECT_EQ(scene->state, "READY");
  EXPECT_EQ(scene->failure, "");
  EXPECT_EQ(scene->model_version, "2");
  EXPECT_THAT(scene->versions, ElementsAre("2", "1"));
  EXPECT_EQ(scene->display_name, "The kitchen");
  EXPECT_EQ(scene->resident_bytes, 6'000'000'000u);
  ASSERT_TRUE(scene->model.has_value());
  EXPECT_EQ(scene->model->method, "rgbd");
  EXPECT_EQ(scene->model->dataset, "7scenes:kitchen");
  EXPECT_EQ(scene->model->created_utc, "2026-11-21T09:30:00Z");
  EXPECT_EQ(scene->model->software_version, "0.1.0");
  EXPECT_EQ(scene->model->checksum, "0123456789abcdef");
  EXPECT_EQ(scene->model->calibration, camera::RgbdCalibration{});
  EXPECT_EQ(scene->model->bounds_min_in_world, (geometry::Vec3{-1, -2, -3}));
  EXPECT_EQ(scene->model->bounds_max_in_world, (geometry::Vec3{1, 2, 3}));
  EXPECT_EQ(scene->model->training_frames, 500);
  EXPECT_EQ(scene->model->training_s, 41);
  EXPECT_EQ(scene->model->trees, 5);
  EXPECT_EQ(scene->model->leaves, 500'001);
  EXPECT_EQ(scene->model->file_bytes, 5'000'000'000u);
}

TEST(ClientConvert, ScenesThatFailedSayWhy) {
  v1::SceneInfo info = SomeScene();
  info.set_state(v1::SCENE_STATE_FAILED);
  info.mutable_failure()->set_code("DATA_LOSS");
  info.mutable_failure()->set_message("checksum differs");
  info.clear_model();
  const auto scene = FromProto(info);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->state, "FAILED");
  EXPECT_EQ(scene->failure, "DATA_LOSS: checksum differs");
  EXPECT_FALSE(scene->model.has_value());
}

}  // namespace
}  // namespace treeline::relocalizer
