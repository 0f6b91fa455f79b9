#include "server/gateway/gpp_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "common/base/error_info.h"

namespace treeline::gateway {
namespace {

using ::nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// First bytes are all that is looked at here.
const std::string kJpeg = "\xff\xd8\xff\xe0 and more";
const std::string kPng = "\x89PNG\r\n\x1a\n and more";

json Camera(const std::string& format, const std::string& bytes, int width,
            int height, double timestamp = 1000) {
  return {{"timestamp", timestamp},  {"sensorId", "0"},
          {"sequenceNumber", 0},     {"imageFormat", format},
          {"size", {width, height}}, {"imageBytes", absl::Base64Escape(bytes)}};
}

json Request(std::vector<json> cameras) {
  return {{"id", "an-id"},
          {"timestamp", 2000},
          {"type", "geopose"},
          {"sensors", json::array({{{"id", "0"}, {"type", "camera"}}})},
          {"sensorReadings", {{"cameraReadings", std::move(cameras)}}}};
}

absl::StatusOr<GppRequest> Parse(const json& request) {
  return ParseGppRequest(request.dump());
}

std::string Complaint(const json& request) {
  const auto parsed = Parse(request);
  EXPECT_EQ(parsed.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(base::ErrorInfoOf(parsed.status()).reason, "INVALID_REQUEST");
  return std::string(parsed.status().message());
}

TEST(GppMessage, ReadsAPictureWithItsCamera) {
  json camera = Camera("JPG", kJpeg, 640, 480, 1234567890123);
  camera["params"] = {{"model", "PINHOLE"},
                      {"modelParams", {585, 586, 320, 240}}};
  const auto request = Parse(Request({camera}));
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->id, "an-id");
  EXPECT_EQ(request->timestamp_ms, 1234567890123);
  EXPECT_EQ(request->frame.color().encoded(), kJpeg);
  EXPECT_EQ(request->frame.camera().model(), "PINHOLE");
  EXPECT_EQ(request->frame.camera().width_px(), 640);
  EXPECT_EQ(request->frame.camera().height_px(), 480);
  // COLMAP's pixel centres lie at (0.5, 0.5), ours at (0, 0).
  EXPECT_THAT(request->frame.camera().parameters(),
              ElementsAre(585, 586, 319.5, 239.5));
  EXPECT_FALSE(request->frame.has_depth());
  EXPECT_THAT(request->hints, IsEmpty());
}

TEST(GppMessage, MovesThePrincipalPointOfModelsWithOneFocalLength) {
  json camera = Camera("JPG", kJpeg, 640, 480);
  camera["params"] = {{"model", "SIMPLE_RADIAL"},
                      {"modelParams", {585, 320, 240, 0.1}}};
  const auto request = Parse(Request({camera}));
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_THAT(request->frame.camera().parameters(),
              ElementsAre(585, 319.5, 239.5, 0.1));
}

TEST(GppMessage, LeavesAnUnknownCameraToTheScene) {
  json camera = Camera("JPG", kJpeg, 640, 480);
  camera["params"] = {{"model", "UNKNOWN"}, {"modelParams", json::array()}};
  EXPECT_FALSE(Parse(Request({camera}))->frame.has_camera());
  camera.erase("params");
  EXPECT_FALSE(Parse(Request({camera}))->frame.has_camera());
}

TEST(GppMessage, BelievesFirstBytesMoreThanNames) {
  EXPECT_EQ(
      Parse(Request({Camera("RGBA32", kJpeg, 4, 4)}))->frame.color().encoded(),
      kJpeg);
  EXPECT_EQ(
      Parse(Request({Camera("JPG", kPng, 4, 4)}))->frame.color().encoded(),
      kPng);
  EXPECT_THAT(Complaint(Request({Camera("JPG", "neither", 4, 4)})),
              HasSubstr("cameraReadings[0].imageFormat"));
}

TEST(GppMessage, ReadsRawPixels) {
  const auto rgba = Parse(Request({Camera("RGBA32", "RGBArgba", 2, 1)}))->frame;
  EXPECT_EQ(rgba.color().rgb8().data(), "RGBrgb");
  EXPECT_EQ(rgba.color().rgb8().width_px(), 2);
  const auto gray = Parse(Request({Camera("GRAY8", "ab", 1, 2)}))->frame;
  EXPECT_EQ(gray.color().rgb8().data(), "aaabbb");
  EXPECT_THAT(Complaint(Request({Camera("GRAY8", "abc", 1, 2)})),
              HasSubstr("3 bytes"));
}

TEST(GppMessage, StripsADataPrefix) {
  json camera = Camera("JPG", kJpeg, 4, 4);
  camera["imageBytes"] = "data:image/jpeg;base64," + absl::Base64Escape(kJpeg);
  EXPECT_EQ(Parse(Request({camera}))->frame.color().encoded(), kJpeg);
  camera["imageBytes"] = "data:image/jpeg";
  EXPECT_FALSE(Parse(Request({camera})).ok());
}

TEST(GppMessage, TakesTheNewestPicture) {
  const auto request = Parse(
      Request({Camera("JPG", kJpeg, 4, 4, 10), Camera("GRAY8", "n", 1, 1, 30),
               Camera("JPG", kPng, 4, 4, 20)}));
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(request->timestamp_ms, 30);
  EXPECT_EQ(request->frame.color().rgb8().data(), "nnn");
}

TEST(GppMessage, JoinsDepthToItsPicture) {
  json color = Camera("JPG", kJpeg, 2, 1, 100);
  color["params"] = {{"model", "SIMPLE_PINHOLE"}, {"modelParams", {2, 1, 1}}};
  const auto request = Parse(Request({Camera("DEPTH", "far", 9, 9, 0), color,
                                      Camera("DEPTH", "abcd", 2, 1, 110)}));
  ASSERT_TRUE(request.ok()) << request.status();
  const v1::DepthImage& depth = request->frame.depth();
  EXPECT_EQ(depth.registration(), v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR);
  EXPECT_EQ(depth.unit_m(), 0.001);
  EXPECT_EQ(depth.raw().data(), "abcd");
  EXPECT_EQ(depth.raw().width_px(), 2);
}

TEST(GppMessage, DepthWithoutAnyCameraIsTheScenes) {
  const auto request = Parse(Request(
      {Camera("JPG", kJpeg, 2, 1, 100), Camera("DEPTH", kPng, 4, 4, 100)}));
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->frame.depth().registration(),
            v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
  EXPECT_EQ(request->frame.depth().png(), kPng);
}

TEST(GppMessage, RefusesDepthThatFitsNoPicture) {
  json color = Camera("JPG", kJpeg, 2, 1, 100);
  EXPECT_THAT(Complaint(Request({color, Camera("DEPTH", "abcd", 2, 1, 200)})),
              HasSubstr("within 50 ms"));
  color["params"] = {{"model", "SIMPLE_PINHOLE"}, {"modelParams", {2, 1, 1}}};
  EXPECT_THAT(Complaint(Request({color, Camera("DEPTH", "abcd", 1, 2, 100)})),
              HasSubstr("another size"));
  json scaled = Camera("DEPTH", "abcd", 2, 1, 100);
  scaled["params"] = {{"minMaxDepth", {0, 5}}};
  EXPECT_THAT(Complaint(Request({color, scaled})), HasSubstr("minMaxDepth"));
  EXPECT_THAT(Complaint(Request({Camera("DEPTH", "abcd", 2, 1)})),
              HasSubstr("picture is needed"));
}

TEST(GppMessage, TurnedPicturesAreSentOnAsTheyAre) {
  const std::vector<std::pair<double, v1::Orientation>> sides = {
      {90, v1::ORIENTATION_LEFT_UP},    {180, v1::ORIENTATION_BOTTOM_UP},
      {270, v1::ORIENTATION_RIGHT_UP},  {-90, v1::ORIENTATION_RIGHT_UP},
      {-450, v1::ORIENTATION_RIGHT_UP}, {450, v1::ORIENTATION_LEFT_UP},
      {359, v1::ORIENTATION_TOP_UP},    {88, v1::ORIENTATION_LEFT_UP}};
  for (const auto& [rotation_deg, side] : sides) {
    json camera = Camera("JPG", kJpeg, 480, 640);
    camera["imageOrientation"] = {{"mirrored", false},
                                  {"rotation", rotation_deg}};
    camera["params"] = {{"model", "PINHOLE"},
                        {"modelParams", {585, 586, 240, 320}}};
    const auto request = Parse(Request({camera}));
    ASSERT_TRUE(request.ok()) << request.status();
    EXPECT_EQ(request->frame.orientation(), side) << rotation_deg;
    EXPECT_TRUE(request->frame.orientation_is_guess());
    EXPECT_EQ(request->frame.color().encoded(), kJpeg);
    EXPECT_EQ(request->frame.camera().width_px(), 480);
    EXPECT_THAT(request->frame.camera().parameters(),
                ElementsAre(585, 586, 239.5, 319.5));
  }
}

TEST(GppMessage, NoRotationSaysNothing) {
  json camera = Camera("JPG", kJpeg, 4, 4);
  for (const double rotation_deg : {0.0, 360.0, -720.0}) {
    camera["imageOrientation"] = {{"mirrored", false},
                                  {"rotation", rotation_deg}};
    EXPECT_EQ(Parse(Request({camera}))->frame.orientation(),
              v1::ORIENTATION_UNSPECIFIED);
  }
}

TEST(GppMessage, RefusesMirroredPictures) {
  json camera = Camera("JPG", kJpeg, 4, 4);
  camera["imageOrientation"] = {{"mirrored", true}, {"rotation", 0}};
  EXPECT_THAT(Complaint(Request({camera})), HasSubstr("mirrored"));
  camera["imageOrientation"] = {{"rotation", "left"}};
  EXPECT_THAT(Complaint(Request({camera})), HasSubstr("rotation"));
}

TEST(GppMessage, DepthIsTurnedLikeItsPicture) {
  json color = Camera("JPG", kJpeg, 2, 1, 100);
  color["imageOrientation"] = {{"rotation", 90}};
  json depth = Camera("DEPTH", "abcd", 2, 1, 100);
  EXPECT_TRUE(Parse(Request({color, depth})).ok());
  depth["imageOrientation"] = {{"rotation", 450}};
  EXPECT_TRUE(Parse(Request({color, depth})).ok());
  depth["imageOrientation"] = {{"rotation", 0}};
  EXPECT_THAT(Complaint(Request({color, depth})),
              HasSubstr("not that of its picture"));
  color.erase("imageOrientation");
  EXPECT_TRUE(Parse(Request({color, depth})).ok());
}

TEST(GppMessage, ReadsWhereTheClientBelievesToBe) {
  json request = Request({Camera("JPG", kJpeg, 4, 4)});
  const json place = {
      {"latitude", 48.5}, {"longitude", 11.5}, {"accuracy", 100}};
  request["sensorReadings"]["geolocationReadings"] = {place};
  // As @oarc/gpp-access 0.2.1 writes it.
  request["sensorReadings"]["geoLocationReadings"] = {
      {{"latitude", 1}, {"longitude", 2}, {"accuracy", 0}}};
  request["priorPoses"] = {
      {{"accuracy", {{"position", 0.1}}},
       {"geopose", {{"position", {{"lat", 3}, {"lon", 4}, {"h", 5}}}}}}};
  const auto parsed = Parse(request);
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  ASSERT_THAT(parsed->hints, SizeIs(3));
  EXPECT_EQ(parsed->hints[0].position.latitude_deg, 48.5);
  EXPECT_EQ(parsed->hints[0].radius_m, 300);
  EXPECT_EQ(parsed->hints[1].radius_m, 1000);
  EXPECT_EQ(parsed->hints[2].position.longitude_deg, 4);
  EXPECT_EQ(parsed->hints[2].radius_m, 50);
}

TEST(GppMessage, NamesWhatIsWrong) {
  const json good = Request({Camera("JPG", kJpeg, 4, 4)});
  const auto with = [&](const char* pointer, const json& value) {
    json request = good;
    request[json::json_pointer(pointer)] = value;
    return Complaint(request);
  };
  EXPECT_THAT(with("/id", 3), HasSubstr("id: must be a string"));
  EXPECT_THAT(with("/type", "other"), HasSubstr("type"));
  EXPECT_THAT(with("/sensorReadings", json::array()),
              HasSubstr("sensorReadings"));
  EXPECT_THAT(with("/sensorReadings/cameraReadings", json::array()),
              HasSubstr("cameraReadings"));
  EXPECT_THAT(with("/sensorReadings/cameraReadings/0/size", {4}),
              HasSubstr("cameraReadings[0].size"));
  EXPECT_THAT(with("/sensorReadings/cameraReadings/0/size", {4, 1e9}),
              HasSubstr("cameraReadings[0].size"));
  EXPECT_THAT(with("/sensorReadings/cameraReadings/0/imageBytes", "?"),
              HasSubstr("cameraReadings[0].imageBytes"));
  EXPECT_THAT(with("/sensorReadings/cameraReadings/0/params",
                   {{"model", "PINHOLE"}, {"modelParams", {1, 2}}}),
              HasSubstr("has 4 parameters, not 2"));
  EXPECT_THAT(with("/sensorReadings/cameraReadings/0/params",
                   {{"model", "LENS"}, {"modelParams", {1, 2}}}),
              HasSubstr("params.model"));
  EXPECT_THAT(with("/sensorReadings/geolocationReadings",
                   {{{"latitude", 91}, {"longitude", 0}}}),
              HasSubstr("latitude"));
  EXPECT_FALSE(ParseGppRequest("").ok());
  EXPECT_FALSE(ParseGppRequest("[1, 2]").ok());
  EXPECT_FALSE(ParseGppRequest(std::string(1000, '[')).ok());
}

TEST(GppMessage, WritesBasicQuaternionGeoPoses) {
  GppRequest request;
  request.id = "an-id";
  request.timestamp_ms = 1234567890123;
  const auto answer = json::parse(GppAnswerJson(
      request, {{48.5, 11.5, 500.25}, geometry::Rotation3{0.5, 0.5, -0.5, 0.5}},
      {0.03, 0.4}));
  EXPECT_EQ(answer, json::parse(R"({
    "id": "an-id", "timestamp": 1234567890123, "type": "geopose",
    "accuracy": {"position": 0.03, "orientation": 0.4},
    "geopose": {"position": {"lat": 48.5, "lon": 11.5, "h": 500.25},
                "quaternion": {"x": 0.5, "y": -0.5, "z": 0.5, "w": 0.5}}})"));
}

}  // namespace
}  // namespace treeline::gateway
