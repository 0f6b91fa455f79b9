#include "server/app/failed_query_folder.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/app/failed_query_recorder.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::server_app {
namespace {

namespace fs = std::filesystem;

constexpr char kOld[] = "20261126T045537.608Z-000001-TOO_FEW_INLIERS";
constexpr char kNew[] = "20261126T045538.001Z-000002-INVALID_REQUEST";

class FailedQueryFolderTest : public testing::Test {
 protected:
  FailedQueryFolderTest() {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~FailedQueryFolderTest() override { fs::remove_all(path_); }

  void Put(const std::string& name, const std::string& bytes) const {
    std::ofstream(absl::StrCat(path_, "/", name), std::ios::binary) << bytes;
  }
  void PutQuery(const std::string& name, const std::string& json,
                const v1::LocalizeRequest& request = {}) const {
    Put(name + ".json", json);
    Put(name + ".binpb", request.SerializeAsString());
  }
  nlohmann::json Listed() const {
    const auto content = folder_.Get("");
    EXPECT_TRUE(content.ok()) << content.status();
    EXPECT_EQ(content->type, "application/json");
    return nlohmann::json::parse(content->bytes)["queries"];
  }

  const std::string path_ = absl::StrCat(
      testing::TempDir(), "/failed-",
      testing::UnitTest::GetInstance()->current_test_info()->name());
  const FailedQueryFolder folder_{path_};
};

TEST_F(FailedQueryFolderTest, ListsTheNewestFirst) {
  PutQuery(kOld, R"({"reason":"TOO_FEW_INLIERS","scene":"hall","status":"OK",
                     "trace_id":"0af7","response":{"inliers":3}})");
  PutQuery(kNew, "broken");
  // Not finished, and no query at all.
  Put("20261126T045539.001Z-000003-X.json", "{}");
  Put("notes.json", "{}");
  const nlohmann::json listed = Listed();
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0],
            (nlohmann::json{{"name", kNew},
                            {"time_utc", "2026-11-26T04:55:38.001Z"}}));
  EXPECT_EQ(listed[1], (nlohmann::json{{"name", kOld},
                                       {"time_utc", "2026-11-26T04:55:37.608Z"},
                                       {"reason", "TOO_FEW_INLIERS"},
                                       {"scene", "hall"},
                                       {"status", "OK"},
                                       {"trace_id", "0af7"}}));
}

TEST_F(FailedQueryFolderTest, ListsNoMoreThanItSays) {
  for (size_t i = 0; i < FailedQueryFolder::kMostListed + 5; ++i) {
    PutQuery(absl::StrCat("20261126T045537.608Z-", 100000 + i, "-X"), "{}");
  }
  const nlohmann::json listed = Listed();
  EXPECT_EQ(listed.size(), FailedQueryFolder::kMostListed);
  EXPECT_TRUE(absl::StrContains(std::string(listed[0]["name"]), "100204"));
}

TEST_F(FailedQueryFolderTest, ShowsAQueryAndItsPicture) {
  v1::LocalizeRequest request;
  request.mutable_frame()->mutable_color()->set_encoded("\xff\xd8\xff rest");
  PutQuery(kOld, R"({"reason":"X"})", request);
  EXPECT_EQ(folder_.Get(kOld)->bytes, R"({"reason":"X"})");
  const auto picture = folder_.Get(absl::StrCat(kOld, "/picture"));
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(picture->type, "image/jpeg");
  EXPECT_EQ(picture->bytes, "\xff\xd8\xff rest");
}

TEST_F(FailedQueryFolderTest, PixelsAreShownAsAJpeg) {
  v1::LocalizeRequest request;
  v1::Rgb8Image& raw =
      *request.mutable_frame()->mutable_color()->mutable_rgb8();
  raw.set_width_px(4);
  raw.set_height_px(2);
  raw.set_data(std::string(24, 'x'));
  PutQuery(kOld, "{}", request);
  const auto picture = folder_.Get(absl::StrCat(kOld, "/picture"));
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_TRUE(absl::StartsWith(picture->bytes, "\xff\xd8\xff"));
}

TEST_F(FailedQueryFolderTest, WhatIsNoPictureIsNotShown) {
  v1::LocalizeRequest script;
  script.mutable_frame()->mutable_color()->set_encoded("<script>evil()");
  v1::LocalizeRequest lying;
  v1::Rgb8Image& raw = *lying.mutable_frame()->mutable_color()->mutable_rgb8();
  raw.set_width_px(-4);
  raw.set_height_px(-2);
  raw.set_data(std::string(24, 'x'));
  for (const v1::LocalizeRequest& request :
       {script, lying, v1::LocalizeRequest()}) {
    PutQuery(kOld, "{}", request);
    EXPECT_TRUE(
        absl::IsNotFound(folder_.Get(absl::StrCat(kOld, "/picture")).status()));
  }
  Put(std::string(kOld) + ".binpb", "\xff\xff no message");
  EXPECT_TRUE(
      absl::IsNotFound(folder_.Get(absl::StrCat(kOld, "/picture")).status()));
}

TEST_F(FailedQueryFolderTest, NothingElseCanBeNamed) {
  Put("secret.json", "s3cret");
  PutQuery(kOld, "{}");
  for (const std::string& path :
       {std::string("secret"), std::string("../secret"),
        absl::StrCat("../", fs::path(path_).filename().string(), "/", kOld),
        absl::StrCat(kOld, "/"), absl::StrCat(kOld, ".json"),
        absl::StrCat(kOld, "/../secret"), absl::StrCat("/", kOld),
        std::string("/picture"), std::string(kNew), std::string(1, '\0'),
        absl::StrCat(kOld, std::string(1, '\0'))}) {
    EXPECT_TRUE(absl::IsNotFound(folder_.Get(path).status())) << path;
  }
}

TEST_F(FailedQueryFolderTest, AFolderThatIsGoneIsNoFault) {
  fs::remove_all(path_);
  EXPECT_TRUE(absl::IsUnavailable(folder_.Get("").status()));
}

}  // namespace
}  // namespace treeline::server_app
