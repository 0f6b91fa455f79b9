#include "server/gateway/picture_query.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/image/decode.h"

namespace treeline::gateway {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Jpeg() {
  return image::EncodeJpeg({.width = 40,
                            .height = 30,
                            .rgb = std::vector<uint8_t>(size_t{3} * 40 * 30)},
                           90)
      .value();
}

http::HttpRequest Picture() {
  http::HttpRequest http;
  http.method = "POST";
  http.path = "/localize";
  http.headers["content-type"] = "image/jpeg";
  http.body = Jpeg();
  return http;
}

http::HttpRequest Form(
    const std::vector<std::pair<std::string, std::string>>& parts) {
  http::HttpRequest http = Picture();
  http.headers["content-type"] = "multipart/form-data; boundary=b";
  http.body.clear();
  for (const auto& [name, bytes] : parts) {
    absl::StrAppend(&http.body,
                    "--b\r\nContent-Disposition: form-data; name=\"", name,
                    "\"\r\n\r\n", bytes, "\r\n");
  }
  http.body += "--b--\r\n";
  return http;
}

std::string Refusal(const http::HttpRequest& http) {
  const auto request = ParsePictureQuery(http);
  EXPECT_TRUE(absl::IsInvalidArgument(request.status()));
  return std::string(request.status().message());
}

TEST(PictureQuery, APictureIsEnough) {
  const auto request = ParsePictureQuery(Picture());
  ASSERT_TRUE(request.ok()) << request.status();
  v1::LocalizeRequest expected;
  expected.mutable_frame()->mutable_color()->set_encoded(Jpeg());
  EXPECT_EQ(request->SerializeAsString(), expected.SerializeAsString());
}

TEST(PictureQuery, TakesWordsFromTheAddress) {
  http::HttpRequest http = Picture();
  http.query = {{"scene", "kitchen"},
                {"camera", "SIMPLE_PINHOLE,31,19.5,14.5"},
                {"orientation", "left"},
                {"min_confidence", "0.5"},
                {"seed", "18446744073709551615"},
                {"model_version", "7"}};
  const auto request = ParsePictureQuery(http);
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->scene(), "kitchen");
  EXPECT_EQ(request->model_version(), "7");
  EXPECT_EQ(request->frame().camera().model(), "SIMPLE_PINHOLE");
  EXPECT_EQ(request->frame().camera().width_px(), 40);
  EXPECT_EQ(request->frame().camera().height_px(), 30);
  EXPECT_EQ(request->frame().orientation(), v1::ORIENTATION_LEFT_UP);
  EXPECT_EQ(request->options().min_confidence(), 0.5);
  EXPECT_EQ(request->options().seed(), 18446744073709551615u);
}

TEST(PictureQuery, TakesAFormWithDepth) {
  const auto request = ParsePictureQuery(Form({{"image", Jpeg()},
                                               {"depth", "a PNG"},
                                               {"registered", "true"},
                                               {"depth_unit", "0.0002"},
                                               {"candidate_scene", "hall"},
                                               {"candidate_scene", "attic"}}));
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->frame().color().encoded(), Jpeg());
  const v1::DepthImage& depth = request->frame().depth();
  EXPECT_EQ(depth.png(), "a PNG");
  EXPECT_EQ(depth.unit_m(), 0.0002);
  EXPECT_EQ(depth.registration(), v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR);
  EXPECT_THAT(request->candidate_scenes(), ElementsAre("hall", "attic"));
  const auto plain =
      ParsePictureQuery(Form({{"color", Jpeg()}, {"depth", "a PNG"}}));
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_EQ(plain->frame().depth().unit_m(), 0.001);
  EXPECT_EQ(plain->frame().depth().registration(),
            v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
}

TEST(PictureQuery, NamesTheWordThatIsWrong) {
  const auto with = [](const std::string& name, const std::string& value) {
    return Refusal(Form({{"image", Jpeg()}, {name, value}}));
  };
  EXPECT_THAT(with("scenes", "kitchen"),
              AllOf(HasSubstr("'scenes' is unknown"), HasSubstr("scene")));
  EXPECT_THAT(with("color", Jpeg()), HasSubstr("'color' comes twice"));
  EXPECT_THAT(with("camera", "PINHOLE,1"), HasSubstr("'camera'"));
  EXPECT_THAT(with("orientation", "up"), HasSubstr("'orientation'"));
  EXPECT_THAT(with("min_confidence", "high"), HasSubstr("'min_confidence'"));
  EXPECT_THAT(with("seed", "-1"), HasSubstr("'seed'"));
  EXPECT_THAT(with("registered", "true"), HasSubstr("'registered'"));
  EXPECT_THAT(with("depth_unit", "1"), HasSubstr("'depth_unit'"));
  EXPECT_THAT(Refusal(Form({{"scene", "kitchen"}})),
              HasSubstr("there is no picture"));
  http::HttpRequest empty = Picture();
  empty.body.clear();
  EXPECT_THAT(Refusal(empty), HasSubstr("there is no picture"));
  http::HttpRequest text = Picture();
  text.body = "not a picture";
  text.query = {{"camera", "SIMPLE_PINHOLE,31,19.5,14.5"}};
  EXPECT_FALSE(ParsePictureQuery(text).ok());
}

TEST(PictureQuery, TypesOfPicturesAndFormsAreTaken) {
  for (const char* type :
       {"", "image/jpeg", "image/png", "application/octet-stream",
        "application/x-www-form-urlencoded",
        "multipart/form-data; boundary=b"}) {
    EXPECT_TRUE(MayBePicture(type)) << type;
  }
  for (const char* type : {"application/json", "text/plain"}) {
    EXPECT_FALSE(MayBePicture(type)) << type;
  }
}

}  // namespace
}  // namespace treeline::gateway
