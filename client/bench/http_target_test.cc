#include "client/bench/http_target.h"

#include <string>

#include "absl/strings/escaping.h"
#include "common/base/error_info.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "google/rpc/status.pb.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::bench {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Json = nlohmann::json;

std::string Jpeg() {
  image::ColorImage picture{.width = 32, .height = 24, .rgb = {}};
  picture.rgb.resize(32 * 24 * 3, 90);
  return image::EncodeJpeg(picture, 90).value();
}

WorkItem ItemOf(const v1::LocalizeRequest& request) {
  const grpc::Slice bytes(request.SerializeAsString());
  return {.scene = request.scene(),
          .stem = "frame-7",
          .encoding = "",
          .request = grpc::ByteBuffer(&bytes, 1),
          .world_from_camera = {}};
}

v1::LocalizeRequest RequestWithDepth() {
  v1::LocalizeRequest request;
  request.set_scene("room");
  request.mutable_frame()->mutable_color()->set_encoded(Jpeg());
  image::DepthImage depth{
      .width = 32, .height = 24, .values = {}, .unit_m = 0.001};
  depth.values.resize(32 * 24, 1000);
  v1::DepthImage& sent = *request.mutable_frame()->mutable_depth();
  sent.set_png(image::EncodeDepthPng(depth).value());
  sent.set_unit_m(0.001);
  sent.set_registration(v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
  return request;
}

TEST(ParseTarget, KnowsItsNames) {
  for (const Target target : {Target::kGrpc, Target::kConnect,
                              Target::kConnectJson, Target::kGeoPose}) {
    EXPECT_EQ(ParseTarget(Name(target)).value(), target);
  }
  EXPECT_THAT(std::string(ParseTarget("rest").status().message()),
              HasSubstr("connect-json"));
}

TEST(HttpBody, OfConnectIsTheMessage) {
  const v1::LocalizeRequest request = RequestWithDepth();
  EXPECT_EQ(HttpBody(Target::kConnect, ItemOf(request)).value(),
            request.SerializeAsString());
  const Json json =
      Json::parse(HttpBody(Target::kConnectJson, ItemOf(request)).value());
  EXPECT_EQ(json["scene"], "room");
  EXPECT_EQ(json["frame"]["color"]["encoded"], absl::Base64Escape(Jpeg()));
}

TEST(HttpBody, OfGeoPoseHasBothReadings) {
  const Json json = Json::parse(
      HttpBody(Target::kGeoPose, ItemOf(RequestWithDepth())).value());
  const Json& readings = json["sensorReadings"]["cameraReadings"];
  ASSERT_EQ(readings.size(), 2);
  EXPECT_EQ(readings[0]["size"], (Json{32, 24}));
  EXPECT_EQ(readings[0]["imageBytes"], absl::Base64Escape(Jpeg()));
  EXPECT_EQ(readings[1]["imageFormat"], "DEPTH");
  EXPECT_FALSE(readings[0].contains("params"));
}

TEST(HttpBody, OfGeoPoseCountsPixelsFromTheCorner) {
  v1::LocalizeRequest request;
  request.mutable_frame()->mutable_color()->set_encoded(Jpeg());
  v1::Camera& camera = *request.mutable_frame()->mutable_camera();
  camera.set_model("PINHOLE");
  for (const double value : {30.0, 31.0, 15.5, 11.5}) {
    camera.add_parameters(value);
  }
  const Json json =
      Json::parse(HttpBody(Target::kGeoPose, ItemOf(request)).value());
  const Json& params = json["sensorReadings"]["cameraReadings"][0]["params"];
  EXPECT_EQ(params["model"], "PINHOLE");
  EXPECT_THAT(params["modelParams"].get<std::vector<double>>(),
              ElementsAre(30, 31, 16, 12));
}

TEST(HttpBody, SaysWhatGeoPoseCannot) {
  const auto error = [](const v1::LocalizeRequest& request) {
    const absl::Status status =
        HttpBody(Target::kGeoPose, ItemOf(request)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  v1::LocalizeRequest request = RequestWithDepth();
  request.mutable_frame()->mutable_depth()->set_unit_m(0.0002);
  EXPECT_THAT(error(request), HasSubstr("millimetres"));
  request = RequestWithDepth();
  request.mutable_frame()->mutable_depth()->set_registration(
      v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR);
  EXPECT_THAT(error(request), HasSubstr("registered"));
  request = RequestWithDepth();
  request.mutable_frame()->mutable_color()->mutable_rgb8();
  EXPECT_THAT(error(request), HasSubstr("raw colour"));
  EXPECT_THAT(error(request), HasSubstr("frame-7"));
}

// As the server writes it: base64 without padding.
std::string ErrorBody(const std::string& code, const std::string& reason) {
  google::rpc::ErrorInfo info;
  info.set_domain("treeline");
  info.set_reason(reason);
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_nanos(50'000'000);
  const auto value = [](const google::protobuf::Message& message) {
    std::string text = absl::Base64Escape(message.SerializeAsString());
    while (text.back() == '=') text.pop_back();
    return text;
  };
  return Json{{"code", code},
              {"message", "why"},
              {"details",
               {{{"type", "google.rpc.ErrorInfo"}, {"value", value(info)}},
                {{"type", "google.rpc.RetryInfo"}, {"value", value(retry)}}}}}
      .dump();
}

TEST(ParseHttpAnswer, ReadsErrorsWithTheirReason) {
  const absl::Status error =
      ParseHttpAnswer(Target::kConnect, 503,
                      ErrorBody("unavailable", "QUEUE_FULL"))
          .status();
  EXPECT_EQ(error.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(std::string(error.message()), "why");
  EXPECT_EQ(base::ErrorInfoOf(error).reason, "QUEUE_FULL");
  EXPECT_EQ(base::RetryAfterOf(error), std::chrono::milliseconds(50));
  EXPECT_EQ(ParseHttpAnswer(Target::kConnectJson, 401,
                            ErrorBody("unauthenticated", "TOKEN_MISSING"))
                .status()
                .code(),
            absl::StatusCode::kUnauthenticated);
}

TEST(ParseHttpAnswer, WhatIsNoAnswerIsUnknown) {
  for (const char* body :
       {"", "<html>Bad gateway", "[]", "{}", "{\"code\":7}",
        "{\"code\":\"odd\",\"details\":[7,{\"value\":8},{\"value\":\"*\"}]}"}) {
    for (const Target target :
         {Target::kConnect, Target::kConnectJson, Target::kGeoPose}) {
      EXPECT_EQ(ParseHttpAnswer(target, 502, body).status().code(),
                absl::StatusCode::kUnknown)
          << body;
    }
    if (*body != '\0' && std::string(body) != "{}") {
      EXPECT_FALSE(ParseHttpAnswer(Target::kConnectJson, 200, body).ok())
          << body;
    }
    EXPECT_FALSE(ParseHttpAnswer(Target::kGeoPose, 200, body).ok()) << body;
  }
  EXPECT_FALSE(ParseHttpAnswer(Target::kConnect, 200, "\xff\xff").ok());
}

TEST(ParseHttpAnswer, ReadsMessages) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  response.set_scene("room");
  EXPECT_EQ(ParseHttpAnswer(Target::kConnect, 200, response.SerializeAsString())
                ->scene(),
            "room");
  EXPECT_EQ(ParseHttpAnswer(Target::kConnectJson, 200,
                            R"({"outcome":"OUTCOME_LOCALIZED","scene":"a"})")
                ->scene(),
            "a");
}

TEST(ParseHttpAnswer, AGeoPoseIsComparable) {
  const auto answer = ParseHttpAnswer(
      Target::kGeoPose, 200,
      R"({"id":"bench","timestamp":0,"type":"geopose","geopose":{"position":
          {"lat":48.5,"lon":11.25,"h":520},"quaternion":
          {"x":0.1,"y":0.2,"z":0.3,"w":0.9}}})");
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->outcome(), v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(answer->world_from_camera().translation_m().x(), 48.5);
  EXPECT_EQ(answer->world_from_camera().rotation().w(), 0.9);
}

TEST(ParseHttpAnswer, NoPoseOfGeoPoseIsAnAnswer) {
  const auto lost = ParseHttpAnswer(Target::kGeoPose, 422,
                                    ErrorBody("not_found", "TOO_FEW_INLIERS"));
  ASSERT_TRUE(lost.ok()) << lost.status();
  EXPECT_EQ(lost->outcome(), v1::OUTCOME_NOT_LOCALIZED);
  EXPECT_EQ(lost->reason(), v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS);
  const absl::Status nowhere =
      ParseHttpAnswer(Target::kGeoPose, 422,
                      ErrorBody("not_found", "NO_SCENE_NEAR"))
          .status();
  EXPECT_EQ(nowhere.code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::bench
