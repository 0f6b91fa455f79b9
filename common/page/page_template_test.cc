#include "common/page/page_template.h"

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::page {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kTemplate =
    "<p>before</p><script type=\"application/json\">\"@REPORT_DATA@\"</script>";

TEST(FillPageTemplate, PutsTheDataInItsPlace) {
  const auto page = FillPageTemplate(kTemplate, "{\"kind\":1}");
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_EQ(*page,
            "<p>before</p><script type=\"application/json\">{\"kind\":1}"
            "</script>");
}

TEST(FillPageTemplate, LetsNoTextEndTheElement) {
  const nlohmann::json data = {{"name", "</script><script>alert(1)</script>"},
                               {"</SCRIPT", "<!-- <script"}};
  const auto page = FillPageTemplate(kTemplate, data.dump());
  ASSERT_TRUE(page.ok()) << page.status();
  const std::string tail = page->substr(page->find("application/json") + 18);
  const std::string json = tail.substr(0, tail.size() - 9);
  EXPECT_THAT(json, Not(HasSubstr("<")));
  // And it still says the same.
  EXPECT_EQ(nlohmann::json::parse(json), data);
}

TEST(FillPageTemplate, WantsOnePlaceForTheData) {
  for (const std::string& page : {std::string(), std::string("<html>"),
                                  std::string(kTemplate) + kTemplate}) {
    EXPECT_EQ(FillPageTemplate(page, "{}").status().code(),
              absl::StatusCode::kInvalidArgument)
        << page;
  }
}

TEST(WritePage, WritesThePage) {
  const base::TestingFolder folder;
  ASSERT_TRUE(
      base::WriteFileAtomically(folder.Path("template.html"), kTemplate).ok());
  ASSERT_TRUE(
      WritePage(folder.Path("a.html"), "[7]", folder.Path("template.html"))
          .ok());
  EXPECT_THAT(base::ReadFile(folder.Path("a.html")).value(),
              HasSubstr(">[7]<"));
  EXPECT_FALSE(std::filesystem::exists(folder.Path("a.data.json")));
}

TEST(WritePage, WritesTheDataWhereThereIsNoTemplate) {
  const base::TestingFolder folder;
  ASSERT_TRUE(WritePage(folder.Path("a.html"), "[7]", "").ok());
  EXPECT_EQ(base::ReadFile(folder.Path("a.data.json")).value(), "[7]");
  EXPECT_FALSE(std::filesystem::exists(folder.Path("a.html")));
}

TEST(WritePage, NamesATemplateThatCannotBeRead) {
  const base::TestingFolder folder;
  const absl::Status status =
      WritePage(folder.Path("a.html"), "{}", folder.Path("gone.html"));
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("gone.html"));
}

TEST(PageDataPath, StandsBesideThePageAndNotBesideTheResults) {
  // --json kitchen.json --report kitchen.html
  EXPECT_EQ(PageDataPath("out/kitchen.html"), "out/kitchen.data.json");
  EXPECT_EQ(PageDataPath("kitchen"), "kitchen.data.json");
  const std::string notice = NoPageTemplateNotice("k.html", "scripts/make-it");
  EXPECT_THAT(notice, HasSubstr("k.data.json"));
  EXPECT_THAT(notice, HasSubstr("scripts/make-it"));
}

}  // namespace
}  // namespace treeline::page
