#include "server/service/localize_rpc.h"

#include <optional>
#include <string>

#include "common/wire/camera.h"
#include "common/wire/geometry.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/service_test_util.h"

namespace treeline::service {
namespace {

using ::testing::HasSubstr;

class LocalizeRpcTest : public testing::Test {
 protected:
  LocalizeRpcTest()
      : scenes_({{"kitchen",
                  [this](const image::Frame& frame,
                         const localizer::LocalizeOptions& options) {
                    frame_ = frame;
                    options_ = options;
                    if (during_localize_) during_localize_();
                    return answer_;
                  }}}),
        clock_(std::chrono::milliseconds(10)),
        rpc_(image::DecodeLimits{}, clock_) {
    call_.arrival = clock_.Now();
    call_.stop = stop_.get_token();
  }

  absl::StatusOr<v1::LocalizeResponse> Handle(
      const v1::LocalizeRequest& request) {
    const auto scene = scenes_.repository().Acquire("kitchen", "");
    if (!scene.ok()) return scene.status();
    return rpc_.Handle(request, **scene, call_, record_);
  }

  // What the fake localizer was given, and what it answers.
  std::optional<image::Frame> frame_;
  std::optional<localizer::LocalizeOptions> options_;
  std::function<void()> during_localize_;
  absl::StatusOr<localizer::PoseEstimate> answer_ = LocalizedEstimate();

  FakeScenes scenes_;
  SteppingClock clock_;
  std::stop_source stop_;
  LocalizeRpc rpc_;
  CallInfo call_;
  CallRecord record_;
};

TEST_F(LocalizeRpcTest, AnswersWithTheEstimateAndWhoMadeIt) {
  const auto response = Handle(TestRequest("kitchen"));
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->outcome(), v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(*wire::FromProto(response->world_from_camera(), ""),
            LocalizedEstimate().world_from_camera);
  EXPECT_EQ(response->pose_sensor(), v1::RGBD_SENSOR_DEPTH);
  EXPECT_EQ(response->scene(), "kitchen");
  EXPECT_EQ(response->model_version(), "1");
}

TEST_F(LocalizeRpcTest, PassesTheDecodedFrameOn) {
  ASSERT_TRUE(Handle(TestRequest("kitchen")).ok());
  ASSERT_TRUE(frame_.has_value());
  EXPECT_EQ(frame_->color.width, kTestWidth);
  EXPECT_EQ(frame_->color.height, kTestHeight);
  EXPECT_EQ(frame_->depth->values[0], 1500);
  EXPECT_FALSE(frame_->calibration.has_value());
}

TEST_F(LocalizeRpcTest, PassesSeedAndOptionsOn) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_EQ(options_->seed, 0u);
  EXPECT_FALSE(options_->keep_correspondences);
  EXPECT_FALSE(options_->min_confidence.has_value());
  request.mutable_options()->set_seed(18446744073709551615u);
  request.mutable_options()->set_include_correspondences(true);
  request.mutable_options()->set_min_confidence(0.4);
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_EQ(options_->seed, 18446744073709551615u);
  EXPECT_TRUE(options_->keep_correspondences);
  EXPECT_EQ(options_->min_confidence, 0.4);
}

TEST_F(LocalizeRpcTest, NotLocalizedIsAnAnswer) {
  localizer::PoseEstimate lost;
  lost.reason = localizer::NotLocalizedReason::kTooFewInliers;
  lost.samples = 500;
  lost.inliers = 7;
  answer_ = lost;
  const auto response = Handle(TestRequest("kitchen"));
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->outcome(), v1::OUTCOME_NOT_LOCALIZED);
  EXPECT_EQ(response->reason(), v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS);
  EXPECT_EQ(response->inliers(), 7);
  EXPECT_EQ(record_.outcome, localizer::Outcome::kNotLocalized);
  EXPECT_EQ(record_.reason, localizer::NotLocalizedReason::kTooFewInliers);
}

// The clock moves 10 ms at each look: at arrival, on leaving the queue, after
// decoding, after localizing, and at the end.
TEST_F(LocalizeRpcTest, SaysWhereTheTimeWent) {
  const auto response = Handle(TestRequest("kitchen"));
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_DOUBLE_EQ(response->timings().queue_ms(), 10);
  EXPECT_DOUBLE_EQ(response->timings().decode_ms(), 10);
  EXPECT_DOUBLE_EQ(response->timings().sample_ms(), 0.5);
  EXPECT_DOUBLE_EQ(response->timings().forest_ms(), 2);
  EXPECT_DOUBLE_EQ(response->timings().pose_ms(), 1);
  EXPECT_DOUBLE_EQ(response->timings().localize_ms(), 3.75);
  EXPECT_DOUBLE_EQ(response->timings().total_ms(), 40);
  EXPECT_DOUBLE_EQ(record_.timings.total_ms, 40);
}

TEST_F(LocalizeRpcTest, RecordsTheCallForTheLog) {
  ASSERT_TRUE(Handle(TestRequest("kitchen")).ok());
  EXPECT_EQ(record_.model_version, "1");
  EXPECT_EQ(record_.outcome, localizer::Outcome::kLocalized);
  EXPECT_EQ(record_.inliers, 432);
  EXPECT_EQ(record_.samples, 500);
}

// An undecodable image shows whether anything was decoded: it would answer
// INVALID_ARGUMENT.
v1::LocalizeRequest Undecodable() {
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.mutable_frame()->mutable_color()->set_encoded("no image");
  return request;
}

TEST_F(LocalizeRpcTest, ExpiredCallsAreTurnedAwayBeforeDecoding) {
  EXPECT_EQ(Handle(Undecodable()).status().code(),
            absl::StatusCode::kInvalidArgument);
  call_.deadline = call_.arrival + std::chrono::milliseconds(5);
  EXPECT_EQ(Handle(Undecodable()).status().code(),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_FALSE(frame_.has_value());
}

TEST_F(LocalizeRpcTest, CancelledCallsAreTurnedAwayBeforeDecoding) {
  stop_.request_stop();
  EXPECT_EQ(Handle(Undecodable()).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_FALSE(frame_.has_value());
}

TEST_F(LocalizeRpcTest, CallsThatExpireWhileDecodingAreNotLocalized) {
  // Leaves the queue at 10 ms, is decoded at 20 ms.
  call_.deadline = call_.arrival + std::chrono::milliseconds(15);
  EXPECT_EQ(Handle(TestRequest("kitchen")).status().code(),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_FALSE(frame_.has_value());
}

TEST_F(LocalizeRpcTest, TheLocalizerSeesTheCallsStopToken) {
  during_localize_ = [this] {
    EXPECT_FALSE(options_->stop.stop_requested());
    stop_.request_stop();
    EXPECT_TRUE(options_->stop.stop_requested());
    answer_ = absl::CancelledError("stopped");
  };
  EXPECT_EQ(Handle(TestRequest("kitchen")).status().code(),
            absl::StatusCode::kCancelled);
}

TEST_F(LocalizeRpcTest, WorkStoppedByTheDeadlineSaysSo) {
  // Decoded at 20 ms, stopped at 30 ms.
  call_.deadline = call_.arrival + std::chrono::milliseconds(25);
  answer_ = absl::CancelledError("stopped");
  EXPECT_EQ(Handle(TestRequest("kitchen")).status().code(),
            absl::StatusCode::kDeadlineExceeded);
}

// The fake pose stands at (1.5, -0.25, 3) m.
v1::LocalizeRequest WithPrior(double x, double radius_m, double radius_rad) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  v1::PosePrior& prior = *request.mutable_options()->mutable_prior();
  geometry::Rigid3 pose = LocalizedEstimate().world_from_camera;
  pose.translation.x = x;
  *prior.mutable_world_from_camera() = wire::ToProto(pose);
  prior.set_position_radius_m(radius_m);
  prior.set_rotation_radius_rad(radius_rad);
  return request;
}

TEST_F(LocalizeRpcTest, APosePastThePriorIsWithdrawn) {
  const auto near = Handle(WithPrior(1.6, 0.2, 0.1));
  ASSERT_TRUE(near.ok()) << near.status();
  EXPECT_EQ(near->outcome(), v1::OUTCOME_LOCALIZED);
  const auto far = Handle(WithPrior(2.5, 0.2, 0.1));
  ASSERT_TRUE(far.ok()) << far.status();
  EXPECT_EQ(far->outcome(), v1::OUTCOME_NOT_LOCALIZED);
  EXPECT_EQ(far->reason(), v1::NOT_LOCALIZED_REASON_CONTRADICTS_PRIOR);
  EXPECT_FALSE(far->has_world_from_camera());
  EXPECT_EQ(far->inliers(), 432);
}

TEST_F(LocalizeRpcTest, EveryPriorIsPassedOnAndHolds) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  v1::PositionPrior& place =
      *request.mutable_options()->mutable_position_prior();
  *place.mutable_position_in_world_m() = wire::ToProto(geometry::Vec3{1, 0, 3});
  place.set_radius_m(1);
  v1::HeightBand& band = *request.mutable_options()->mutable_height_band();
  band.set_min_m(2.5);
  band.set_max_m(3.5);
  EXPECT_EQ(Handle(request)->outcome(), v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(options_->priors.position->radius_m, 1);
  EXPECT_EQ(options_->priors.height->max_m, 3.5);
  band.set_min_m(3.1);
  EXPECT_EQ(Handle(request)->reason(),
            v1::NOT_LOCALIZED_REASON_CONTRADICTS_PRIOR);
  request.mutable_options()->clear_height_band();
  place.set_radius_m(0.5);
  EXPECT_EQ(Handle(request)->reason(),
            v1::NOT_LOCALIZED_REASON_CONTRADICTS_PRIOR);
}

TEST_F(LocalizeRpcTest, TheLocalizerLearnsWhichWayUpThePictureIs) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_EQ(frame_->orientation, image::Orientation{});
  request.mutable_frame()->set_orientation(v1::ORIENTATION_LEFT_UP);
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_EQ(frame_->orientation,
            (image::Orientation{image::QuarterTurn::kClockwise, true}));
  // To be turned by whoever needs it upright.
  EXPECT_EQ(frame_->color.width, kTestWidth);
  request.mutable_frame()->clear_orientation();
  request.mutable_frame()->mutable_gravity_in_camera_mps2()->set_y(-9.81);
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_EQ(frame_->orientation,
            (image::Orientation{image::QuarterTurn::kHalf, true}));
}

TEST_F(LocalizeRpcTest, AbsurdOptionsNameTheirField) {
  const auto message = [](const v1::LocalizeRequest& request) {
    return std::string(CheckOptions(request.options()).message());
  };
  EXPECT_TRUE(CheckOptions(WithPrior(1, 0.2, 3).options()).ok());
  EXPECT_THAT(message(WithPrior(1, -1, 0.1)),
              HasSubstr("options.prior.position_radius_m"));
  EXPECT_THAT(message(WithPrior(1, 1, 4)),
              HasSubstr("options.prior.rotation_radius_rad"));
  v1::LocalizeRequest request = WithPrior(1, 1, 1);
  request.mutable_options()->mutable_prior()->clear_world_from_camera();
  EXPECT_THAT(message(request), HasSubstr("options.prior.world_from_camera"));
  request = TestRequest("kitchen");
  request.mutable_options()->mutable_height_band();
  EXPECT_THAT(message(request), HasSubstr("options.height_band.max_m"));
  request = TestRequest("kitchen");
  request.mutable_options()->set_time_budget_ms(0);
  EXPECT_THAT(message(request), HasSubstr("options.time_budget_ms"));
  for (const double none : {-0.1, 1.1, std::nan("")}) {
    request = TestRequest("kitchen");
    request.mutable_options()->set_min_confidence(none);
    EXPECT_THAT(message(request), HasSubstr("options.min_confidence")) << none;
  }
}

TEST_F(LocalizeRpcTest, AsksWithAnAssumedCameraOnlyWhereNoneIsStated) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  v1::Frame& frame = *request.mutable_frame();
  frame.clear_depth();
  const int width = 2 * kTestWidth;
  const int height = 3 * kTestHeight;
  v1::Rgb8Image& picture = *frame.mutable_color()->mutable_rgb8();
  picture.set_width_px(width);
  picture.set_height_px(height);
  picture.set_data(std::string(static_cast<size_t>(3 * width * height), 'x'));
  const auto response = Handle(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_TRUE(frame_->is_camera_assumed);
  *frame.mutable_camera() = wire::ToProto(frame_->calibration->color);
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_FALSE(frame_->is_camera_assumed);
}

TEST_F(LocalizeRpcTest, BadFramesNameTheirField) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.mutable_frame()->mutable_depth()->set_unit_m(0);
  const auto response = Handle(request);
  EXPECT_EQ(response.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(response.status().message()),
              HasSubstr("frame.depth.unit_m"));
}

TEST_F(LocalizeRpcTest, WhatTheLocalizerRefusesIsPassedOn) {
  answer_ = absl::InvalidArgumentError("this scene needs depth");
  const auto response = Handle(TestRequest("kitchen"));
  EXPECT_EQ(response.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(response.status().message(), "this scene needs depth");
}

}  // namespace
}  // namespace treeline::service
