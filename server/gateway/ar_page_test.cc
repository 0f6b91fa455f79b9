#include "server/gateway/ar_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/base/file.h"

namespace treeline::gateway {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;

class ArPageTest : public ::testing::Test {
 protected:
  ArPageTest() : root_(fs::path(testing::TempDir()) / "ar_page_test") {
    fs::remove_all(root_);
    fs::create_directories(root_ / "page/assets");
    Put("page/index.html", "<html>");
    Put("page/assets/main-1a2b.js", "1");
    Put("secret.txt", "secret");
  }
  ~ArPageTest() override { fs::remove_all(root_); }

  void Put(const std::string& name, const std::string& bytes) const {
    ASSERT_TRUE(base::WriteNewFile((root_ / name).string(), bytes).ok());
  }
  http::HttpResponse Get(const std::string& path) const {
    return ArPage((root_ / "page").string())
        .Handle({.method = "GET", .path = path});
  }

  const fs::path root_;
};

TEST_F(ArPageTest, OwnsWhatIsBelowIt) {
  for (const char* path : {"/ar", "/ar/", "/ar/assets/a.js", "/ar/.."}) {
    EXPECT_TRUE(ArPage::Owns(path)) << path;
  }
  for (const char* path : {"/", "/art", "/AR/", "/geopose", ""}) {
    EXPECT_FALSE(ArPage::Owns(path)) << path;
  }
}

TEST_F(ArPageTest, ThePageIsAskedForAgainAndItsAssetsAreNot) {
  const http::HttpResponse page = Get("/ar/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<html>");
  EXPECT_EQ(page.content_type, "text/html; charset=utf-8");
  EXPECT_THAT(page.headers, Contains(Pair("Cache-Control", "no-cache")));
  const http::HttpResponse asset = Get("/ar/assets/main-1a2b.js");
  EXPECT_EQ(asset.body, "1");
  EXPECT_EQ(asset.content_type, "text/javascript; charset=utf-8");
  EXPECT_THAT(asset.headers,
              Contains(Pair("Cache-Control", HasSubstr("immutable"))));
}

TEST_F(ArPageTest, WithoutItsSlashItLeadsThere) {
  const http::HttpResponse answer = Get("/ar");
  EXPECT_EQ(answer.status, 308);
  EXPECT_THAT(answer.headers, Contains(Pair("Location", "ar/")));
}

TEST_F(ArPageTest, NothingLeadsOutAndNoRefusalIsKept) {
  for (const char* path : {"/ar/../secret.txt", "/ar/assets/../../secret.txt",
                           "/ar//secret.txt", "/ar/assets/gone.js"}) {
    const http::HttpResponse answer = Get(path);
    EXPECT_EQ(answer.status, 404) << path;
    EXPECT_THAT(answer.headers, Contains(Pair("Cache-Control", "no-store")));
  }
}

}  // namespace
}  // namespace treeline::gateway
