#include "common/connect_rpc/json_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::connect_rpc {
namespace {

using ::testing::HasSubstr;

TEST(CheckJsonShape, BoundsDepthAndValues) {
  const JsonLimits limits{.max_depth = 3, .max_values = 5};
  EXPECT_TRUE(CheckJsonShape("[[[]]]", limits).ok());
  EXPECT_FALSE(CheckJsonShape("[[[[]]]]", limits).ok());
  EXPECT_TRUE(CheckJsonShape("[1,2,3]", limits).ok());
  EXPECT_FALSE(CheckJsonShape("[1,2,3,4,5,6]", limits).ok());
}

TEST(CheckJsonShape, LooksNotIntoStrings) {
  const JsonLimits limits{.max_depth = 1, .max_values = 3};
  EXPECT_TRUE(CheckJsonShape(R"(["[[[[,,,,,"])", limits).ok());
  EXPECT_TRUE(CheckJsonShape(R"(["\"[[[[\\"])", limits).ok());
  EXPECT_FALSE(CheckJsonShape(R"(["\\",[[]]])", limits).ok());
  EXPECT_TRUE(CheckJsonShape(R"("\)", limits).ok());
  EXPECT_TRUE(CheckJsonShape(R"(")", limits).ok());
}

// protobuf's parser takes strings in single quotes.
TEST(CheckJsonShape, KnowsBothKindsOfQuotes) {
  const JsonLimits limits{.max_depth = 1, .max_values = 3};
  EXPECT_FALSE(CheckJsonShape(R"(['"',[[]],'"'])", limits).ok());
  EXPECT_FALSE(CheckJsonShape(R"(["'",[[]],"'"])", limits).ok());
  EXPECT_TRUE(CheckJsonShape(R"(['[[[[,,,,,'])", limits).ok());
  EXPECT_TRUE(CheckJsonShape(R"(['\'[[[[",,,,,'])", limits).ok());
}

// A quote of the one kind in a string of the other must hide nothing.
TEST(JsonMessage, BoundsArraysBehindQuotesOfBothKinds) {
  std::string empty_texts = "''";
  for (int i = 0; i < 30000; ++i) empty_texts += ",''";
  v1::LocalizeRequest request;
  for (const char* scene : {"'a'", "'\"'", "\"'\"", "'\\''"}) {
    const std::string json = "{'scene':" + std::string(scene) +
                             ",'candidateScenes':[" + empty_texts + "]}";
    const absl::Status refused = MessageFromJson(json, request);
    EXPECT_THAT(std::string(refused.message()), HasSubstr("values")) << scene;
    EXPECT_EQ(request.candidate_scenes_size(), 0);
  }
  EXPECT_TRUE(
      MessageFromJson("{'scene':'a','candidateScenes':['b']}", request).ok());
  EXPECT_EQ(request.scene(), "a");
}

TEST(JsonMessage, ReadsWhatItWrites) {
  v1::LocalizeRequest request;
  request.set_scene("kitchen");
  request.mutable_frame()->mutable_color()->set_encoded("\xff\xd8\x00\x01", 4);
  request.mutable_options()->set_seed(18446744073709551615u);
  const auto json = JsonFromMessage(request);
  ASSERT_TRUE(json.ok());
  EXPECT_THAT(*json, HasSubstr("\"18446744073709551615\""));
  v1::LocalizeRequest back;
  ASSERT_TRUE(MessageFromJson(*json, back).ok());
  EXPECT_EQ(back.SerializeAsString(), request.SerializeAsString());
}

TEST(JsonMessage, ReadsOrientationAndPriors) {
  v1::LocalizeRequest request;
  ASSERT_TRUE(MessageFromJson(R"({
    "frame": {"orientation": "ORIENTATION_LEFT_UP", "orientationIsGuess": true,
              "gravityInCameraMps2": {"x": 9.81}},
    "options": {"positionPrior": {"positionInWorldM": {"z": 2}, "radiusM": 3},
                "heightBand": {"upInWorld": {"y": -1}, "minM": -1, "maxM": 4}}
  })",
                              request)
                  .ok());
  EXPECT_EQ(request.frame().orientation(), v1::ORIENTATION_LEFT_UP);
  EXPECT_TRUE(request.frame().orientation_is_guess());
  EXPECT_EQ(request.frame().gravity_in_camera_mps2().x(), 9.81);
  EXPECT_EQ(request.options().position_prior().radius_m(), 3);
  EXPECT_EQ(request.options().height_band().up_in_world().y(), -1);
}

TEST(JsonMessage, SaysWhatBase64MustBe) {
  v1::LocalizeRequest request;
  for (const char* encoded :
       {"data:image/jpeg;base64,/9j/", R"(/9j/4AA\n/9j/)"}) {
    const absl::Status refused = MessageFromJson(
        absl::StrCat(R"({"frame":{"color":{"encoded":")", encoded, "\"}}}"),
        request);
    EXPECT_THAT(std::string(refused.message()),
                HasSubstr("without line breaks"));
  }
}

TEST(JsonMessage, NamesTheFieldThatIsWrong) {
  v1::LocalizeRequest request;
  const auto complaint = [&](const char* json) {
    const absl::Status status = MessageFromJson(json, request);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(complaint(R"({"frame": {"colour": {}}})"), HasSubstr("colour"));
  EXPECT_THAT(complaint(R"({"options": {"seed": "x"}})"), HasSubstr("seed"));
  EXPECT_THAT(complaint(R"({"frame": 3})"), HasSubstr("frame"));
  EXPECT_THAT(complaint(R"({"frame": {"orientation": "SIDEWAYS"}})"),
              HasSubstr("orientation"));
  EXPECT_LT(
      complaint(("{\"" + std::string(100000, 'x') + "\":1}").c_str()).size(),
      2000u);
}

}  // namespace
}  // namespace treeline::connect_rpc
