#include "server/gateway/gpp_routes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/wire/geometry.h"
#include "server/gateway/testing_dispatcher.h"

namespace treeline::gateway {
namespace {

using ::nlohmann::json;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

v1::SceneInfo Scene(const std::string& name, double latitude_deg,
                    double longitude_deg) {
  v1::SceneInfo scene;
  scene.set_scene(name);
  scene.mutable_geo_anchor()->set_latitude_deg(latitude_deg);
  scene.mutable_geo_anchor()->set_longitude_deg(longitude_deg);
  scene.mutable_geo_anchor()->set_height_m(500);
  scene.mutable_model()->mutable_bounds_max_in_world_m()->set_x(10);
  return scene;
}

std::string Body() {
  return R"({"id": "an-id", "timestamp": 1, "type": "geopose", "sensors": [],
    "sensorReadings": {"cameraReadings": [{"timestamp": 7, "sensorId": "0",
      "imageFormat": "GRAY8", "size": [1, 1], "imageBytes": "eA=="}]}})";
}

v1::LocalizeResponse Localized(const std::string& scene) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  response.set_scene(scene);
  response.set_pose_sensor(v1::RGBD_SENSOR_COLOR);
  *response.mutable_world_from_camera() =
      wire::ToProto(geometry::Rigid3{{}, {1, 2, 3}});
  for (int i = 0; i < 36; ++i) {
    response.add_covariance(i % 7 == 0 ? 1e-4 : 0);
  }
  return response;
}

class GppRoutesTest : public ::testing::Test {
 protected:
  http::HttpResponse Post(const std::string& body = Body()) {
    http::HttpRequest request;
    request.method = "POST";
    request.path = "/geopose";
    request.body = body;
    request.headers["content-type"] = "application/json";
    return routes_.Handle(request);
  }

  const base::SteadyClock clock_{};
  TestingDispatcher dispatcher_;
  v1::SceneInfo unanchored_;
  std::vector<v1::SceneInfo> scenes_{Scene("hall", 48, 11)};
  const GppRoutes routes_{dispatcher_, [this] { return scenes_; }, false,
                          clock_};
};

TEST_F(GppRoutesTest, AnswersWithAGeoPose) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest& request) {
    return Localized(request.scene());
  };
  const http::HttpResponse response = Post();
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.content_type, "application/vnd.oscp+json;version=2.0");
  const json answer = json::parse(response.body);
  EXPECT_EQ(answer["id"], "an-id");
  EXPECT_EQ(answer["timestamp"], 7);
  EXPECT_NEAR(answer["accuracy"]["position"], 0.0279548, 1e-6);
  EXPECT_NEAR(answer["accuracy"]["orientation"], 1.60169, 1e-4);
  const GeoFrame frame = GeoFrame::Create(scenes_[0].geo_anchor(), "a").value();
  const GeoPose expected = frame.ToGeoPose({{}, {1, 2, 3}});
  EXPECT_EQ(answer["geopose"]["position"]["lat"],
            expected.position.latitude_deg);
  EXPECT_EQ(answer["geopose"]["quaternion"]["w"], expected.enu_from_device.w);
}

// The answer is the pose of the picture as it is, which the service gives.
TEST_F(GppRoutesTest, ATurnedPictureIsAskedAboutAsItIs) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest& request) {
    return Localized(request.scene());
  };
  json upright = json::parse(Body());
  json turned = upright;
  turned["sensorReadings"]["cameraReadings"][0]["imageOrientation"] = {
      {"mirrored", false}, {"rotation", 270}};
  const http::HttpResponse response = Post(turned.dump());
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.body, Post(upright.dump()).body);
  const v1::Frame frame = dispatcher_.requests()[0].frame();
  EXPECT_EQ(frame.orientation(), v1::ORIENTATION_RIGHT_UP);
  EXPECT_TRUE(frame.orientation_is_guess());
  EXPECT_EQ(dispatcher_.requests()[1].frame().orientation(),
            v1::ORIENTATION_UNSPECIFIED);
}

TEST_F(GppRoutesTest, AsksForTheOneSceneOrForAll) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest&) {
    return Localized("hall");
  };
  Post();
  EXPECT_EQ(dispatcher_.requests()[0].scene(), "hall");
  EXPECT_THAT(dispatcher_.requests()[0].candidate_scenes(), IsEmpty());
  scenes_.push_back(Scene("shed", 48.001, 11));
  scenes_.push_back({});
  Post();
  EXPECT_EQ(dispatcher_.requests()[1].scene(), "");
  EXPECT_THAT(dispatcher_.requests()[1].candidate_scenes(),
              ElementsAre("hall", "shed"));
}

TEST_F(GppRoutesTest, SaysWhenThereIsNoPose) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest&) {
    v1::LocalizeResponse response;
    response.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
    response.set_reason(v1::NOT_LOCALIZED_REASON_TOO_FEW_INLIERS);
    response.set_inliers(3);
    return response;
  };
  const http::HttpResponse response = Post();
  // Clients take every 200 for a pose.
  EXPECT_EQ(response.status, 422);
  const json answer = json::parse(response.body);
  EXPECT_EQ(answer["details"][0]["debug"]["reason"], "TOO_FEW_INLIERS");
  EXPECT_EQ(answer["details"][0]["debug"]["metadata"]["inliers"], "3");
}

TEST_F(GppRoutesTest, SaysWhenNoSceneHasAPlace) {
  scenes_[0].clear_geo_anchor();
  const http::HttpResponse response = Post();
  EXPECT_EQ(response.status, 422);
  EXPECT_EQ(json::parse(response.body)["details"][0]["debug"]["reason"],
            "NO_SCENE_NEAR");
  EXPECT_THAT(dispatcher_.calls(), IsEmpty());
}

TEST_F(GppRoutesTest, PassesErrorsOn) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest&) {
    return absl::UnauthenticatedError("no token");
  };
  EXPECT_EQ(Post().status, 401);
  EXPECT_EQ(Post("{}").status, 400);
  dispatcher_.on_localize = [](const v1::LocalizeRequest&) {
    v1::LocalizeResponse response = Localized("hall");
    response.clear_covariance();
    return response;
  };
  EXPECT_EQ(Post().status, 500);
}

TEST_F(GppRoutesTest, SpeaksVersion2Only) {
  http::HttpRequest request;
  request.method = "POST";
  request.headers["content-type"] = "application/json";
  for (const char* accept :
       {"", "*/*", "application/json", "application/vnd.oscp+json",
        "application/vnd.oscp+json;version=2.0;",
        "application/vnd.oscp+json; version=1.0, application/json"}) {
    request.headers["accept"] = accept;
    EXPECT_FALSE(routes_.CheckHead(request).has_value()) << accept;
  }
  request.headers["accept"] = "application/vnd.oscp+json;version=1.0";
  EXPECT_EQ(routes_.CheckHead(request)->status, 406);
  request.headers["content-type"] = "text/plain";
  EXPECT_EQ(routes_.CheckHead(request)->status, 415);
  request.method = "GET";
  EXPECT_FALSE(routes_.CheckHead(request).has_value());
  EXPECT_EQ(routes_.Handle(request).body, R"({"status":"running"})");
}

TEST(ScenesNear, KeepsThoseWithinReachOfAnyHint) {
  // A degree of latitude is 111 km.
  const std::vector<v1::SceneInfo> scenes{
      Scene("here", 48, 11), Scene("near", 48.001, 11), Scene("far", 49, 11)};
  EXPECT_THAT(ScenesNear(scenes, {}), ElementsAre("here", "near", "far"));
  EXPECT_THAT(ScenesNear(scenes, {{{48, 11, 0}, 50}}), ElementsAre("here"));
  EXPECT_THAT(ScenesNear(scenes, {{{48, 11, 9000}, 150}}),
              ElementsAre("here", "near"));
  EXPECT_THAT(ScenesNear(scenes, {{{49, 11, 0}, 50}, {{48, 11, 0}, 50}}),
              ElementsAre("here", "far"));
  EXPECT_THAT(ScenesNear(scenes, {{{-48, 11, 0}, 50}}), IsEmpty());
}

TEST(ScenesNear, KnowsHowFarASceneReaches) {
  v1::SceneInfo scene = Scene("street", 48, 11);
  const std::vector<GppHint> hints{{{48.004, 11, 0}, 50}};
  EXPECT_THAT(ScenesNear({scene}, hints), IsEmpty());
  scene.mutable_model()->mutable_bounds_min_in_world_m()->set_y(-600);
  EXPECT_THAT(ScenesNear({scene}, hints), ElementsAre("street"));
  scene.clear_model();
  EXPECT_THAT(ScenesNear({scene}, hints), ElementsAre("street"));
}

TEST(WorldFromPicture, IsThePoseOfTheColourCamera) {
  v1::SceneInfo scene = Scene("hall", 48, 11);
  *scene.mutable_model()->mutable_calibration()->mutable_color_from_depth() =
      wire::ToProto(geometry::Rigid3{{}, {0.025, 0, 0}});
  v1::LocalizeResponse response = Localized("hall");
  EXPECT_EQ(WorldFromPicture(response, scene, {})->translation.x, 1);
  response.set_pose_sensor(v1::RGBD_SENSOR_DEPTH);
  // The colour camera's centre lies 25 mm to the left of the depth camera's.
  EXPECT_NEAR(WorldFromPicture(response, scene, {})->translation.x, 0.975,
              1e-12);
  v1::Frame frame;
  frame.mutable_depth()->set_registration(
      v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR);
  EXPECT_EQ(WorldFromPicture(response, scene, frame)->translation.x, 1);
}

}  // namespace
}  // namespace treeline::gateway
