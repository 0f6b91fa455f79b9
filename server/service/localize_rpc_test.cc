#include "server/service/localize_rpc.h"

#include <optional>
#include <string>

#include "common/wire/geometry.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/service_test_util.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

class LocalizeRpcTest : public testing::Test {
 protected:
  LocalizeRpcTest()
      : scenes_({{"kitchen",
                  [this](const Frame& frame, const LocalizeOptions& options) {
                    frame_ = frame;
                    options_ = options;
                    if (during_localize_) during_localize_();
                    return answer_;
                  }}}),
        clock_(std::chrono::milliseconds(10)),
        rpc_(scenes_.repository(), DecodeLimits{}, clock_) {
    context_.arrival = clock_.Now();
    context_.stop = stop_.get_token();
  }

  absl::StatusOr<v1::LocalizeResponse> Handle(
      const v1::LocalizeRequest& request) {
    return rpc_.Handle(request, context_, record_);
  }

  // What the fake localizer was given, and what it answers.
  std::optional<Frame> frame_;
  std::optional<LocalizeOptions> options_;
  std::function<void()> during_localize_;
  absl::StatusOr<PoseEstimate> answer_ = LocalizedEstimate();

  FakeScenes scenes_;
  SteppingClock clock_;
  std::stop_source stop_;
  LocalizeRpc rpc_;
  CallContext context_;
  CallRecord record_;
};

TEST_F(LocalizeRpcTest, AnswersWithTheEstimateAndWhoMadeIt) {
  const auto response = Handle(TestRequest("kitchen"));
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->outcome(), v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(*FromProto(response->world_from_camera(), ""),
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
  request.mutable_options()->set_seed(18446744073709551615u);
  request.mutable_options()->set_include_correspondences(true);
  ASSERT_TRUE(Handle(request).ok());
  EXPECT_EQ(options_->seed, 18446744073709551615u);
  EXPECT_TRUE(options_->keep_correspondences);
}

TEST_F(LocalizeRpcTest, NotLocalizedIsAnAnswer) {
  PoseEstimate lost;
  lost.reason = NotLocalizedReason::kTooFewInliers;
  lost.samples = 500;
  lost.inliers = 7;
  answer_ = lost;
  const auto response = Handle(TestRequest("kitchen"));
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->outcome(), v1::OUTCOME_NOT_LOCALIZED);
  EXPECT_EQ(response->reason(), v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS);
  EXPECT_EQ(response->inliers(), 7);
  EXPECT_EQ(record_.outcome, Outcome::kNotLocalized);
  EXPECT_EQ(record_.reason, NotLocalizedReason::kTooFewInliers);
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
  EXPECT_EQ(record_.scene, "kitchen");
  EXPECT_EQ(record_.model_version, "1");
  EXPECT_EQ(record_.outcome, Outcome::kLocalized);
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
  context_.deadline = context_.arrival + std::chrono::milliseconds(5);
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
  context_.deadline = context_.arrival + std::chrono::milliseconds(15);
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
  context_.deadline = context_.arrival + std::chrono::milliseconds(25);
  answer_ = absl::CancelledError("stopped");
  EXPECT_EQ(Handle(TestRequest("kitchen")).status().code(),
            absl::StatusCode::kDeadlineExceeded);
}

TEST_F(LocalizeRpcTest, UnknownScenesAreNotFound) {
  const auto response = Handle(TestRequest("attic"));
  EXPECT_EQ(response.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(response.status().message()), HasSubstr("attic"));
  EXPECT_EQ(record_.scene, "attic");
  EXPECT_EQ(record_.model_version, "");
}

TEST_F(LocalizeRpcTest, UnknownVersionsAreNotFound) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.set_model_version("7");
  EXPECT_EQ(Handle(request).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(LocalizeRpcTest, CorruptScenesAreDataLoss) {
  const auto response = Handle(TestRequest("broken"));
  EXPECT_EQ(response.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(response.status().message()),
              HasSubstr("checksum differs"));
}

TEST_F(LocalizeRpcTest, RequestsWithoutASceneAreInvalid) {
  EXPECT_EQ(Handle(v1::LocalizeRequest()).status().code(),
            absl::StatusCode::kInvalidArgument);
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

TEST_F(LocalizeRpcTest, OverlongSceneNamesAreNotRecordedWhole) {
  Handle(TestRequest(std::string(1 << 20, 'x'))).IgnoreError();
  EXPECT_EQ(record_.scene.size(), kLongestName);
}

}  // namespace
}  // namespace treeline
