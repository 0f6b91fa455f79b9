#include "server/repository/scene_json.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

using ::testing::HasSubstr;

const SceneJson::Text kKitchen{R"({"display_name": "Kitchen"})"};
const SceneJson::Text kInvalid{R"({"display_nam": "Kitchen"})"};

TEST(SceneJson, AValidFileIsMetadata) {
  SceneJson json;
  EXPECT_EQ(json.metadata(), nullptr);
  const SceneJson::Change change = json.Apply(kKitchen);
  EXPECT_TRUE(change.of_metadata);
  EXPECT_FALSE(change.is_problem);
  EXPECT_EQ(json.metadata()->display_name, "Kitchen");
}

TEST(SceneJson, TheSameFileAgainChangesNothing) {
  for (const SceneJson::File& file : std::initializer_list<SceneJson::File>{
           SceneJson::NoFile{}, kKitchen, kInvalid,
           SceneJson::Unreadable{absl::StatusCode::kPermissionDenied}}) {
    SceneJson json;
    json.Apply(file);
    const auto metadata = json.metadata();
    const SceneJson::Change change = json.Apply(file);
    EXPECT_FALSE(change.of_metadata) << file.index();
    EXPECT_FALSE(change.is_problem) << file.index();
    EXPECT_EQ(json.metadata(), metadata);
  }
}

TEST(SceneJson, TheLastValidOneGoesOnWhereTheFileIsNot) {
  SceneJson json;
  json.Apply(kKitchen);
  SceneJson::Change change = json.Apply(kInvalid);
  EXPECT_TRUE(change.is_problem);
  EXPECT_FALSE(change.of_metadata);
  EXPECT_THAT(std::string(json.problem().message()), HasSubstr("display_nam"));
  EXPECT_EQ(json.metadata()->display_name, "Kitchen");
  change =
      json.Apply(SceneJson::Unreadable{absl::StatusCode::kPermissionDenied});
  EXPECT_TRUE(change.is_problem);
  EXPECT_EQ(json.problem().message(),
            "scene.json: cannot be read: PERMISSION_DENIED");
  EXPECT_EQ(json.metadata()->display_name, "Kitchen");
}

TEST(SceneJson, WithoutAFileThereIsNeitherMetadataNorAProblem) {
  SceneJson json;
  json.Apply(kKitchen);
  json.Apply(kInvalid);
  EXPECT_TRUE(json.Apply(SceneJson::NoFile{}).of_metadata);
  EXPECT_EQ(json.metadata(), nullptr);
  EXPECT_TRUE(json.problem().ok());
  json.Apply(kInvalid);
  EXPECT_FALSE(json.Apply(SceneJson::NoFile{}).of_metadata);
}

TEST(SceneJson, AnErrorOfTheListingCountsBeforeItsText) {
  SourceListing listing;
  EXPECT_EQ(SceneJson::Of("a", listing), SceneJson::File(SceneJson::NoFile{}));
  listing.scene_json["a"] = "{}";
  EXPECT_EQ(SceneJson::Of("a", listing),
            SceneJson::File(SceneJson::Text{"{}"}));
  listing.scene_json_errors["a"] = absl::PermissionDeniedError("/secret/path");
  EXPECT_EQ(SceneJson::Of("a", listing),
            SceneJson::File(
                SceneJson::Unreadable{absl::StatusCode::kPermissionDenied}));
}

}  // namespace
}  // namespace treeline::repository
