#include "evaluation/report/report_page.h"

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/tools/testing_fixtures.h"

namespace treeline::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kTemplate =
    "<p>before</p><script type=\"application/json\">\"@REPORT_DATA@\"</script>";

TEST(FillReportTemplate, PutsTheDataInItsPlace) {
  const auto page = FillReportTemplate(kTemplate, "{\"kind\":1}");
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_EQ(*page,
            "<p>before</p><script type=\"application/json\">{\"kind\":1}"
            "</script>");
}

TEST(FillReportTemplate, LetsNoTextEndTheElement) {
  const nlohmann::json data = {{"name", "</script><script>alert(1)</script>"},
                               {"</SCRIPT", "<!-- <script"}};
  const auto page = FillReportTemplate(kTemplate, data.dump());
  ASSERT_TRUE(page.ok()) << page.status();
  const std::string tail = page->substr(page->find("application/json") + 18);
  const std::string json = tail.substr(0, tail.size() - 9);
  EXPECT_THAT(json, Not(HasSubstr("<")));
  // And it still says the same.
  EXPECT_EQ(nlohmann::json::parse(json), data);
}

TEST(FillReportTemplate, WantsOnePlaceForTheData) {
  for (const std::string& page : {std::string(), std::string("<html>"),
                                  std::string(kTemplate) + kTemplate}) {
    EXPECT_EQ(FillReportTemplate(page, "{}").status().code(),
              absl::StatusCode::kInvalidArgument)
        << page;
  }
}

TEST(WriteReport, WritesThePage) {
  const tools::TestFolder folder;
  ASSERT_TRUE(
      base::WriteFileAtomically(folder / "template.html", kTemplate).ok());
  ASSERT_TRUE(
      WriteReport(folder / "a.html", "[7]", folder / "template.html").ok());
  EXPECT_THAT(base::ReadFile(folder / "a.html").value(), HasSubstr(">[7]<"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.data.json"));
}

TEST(WriteReport, WritesTheDataWhereThereIsNoTemplate) {
  const tools::TestFolder folder;
  ASSERT_TRUE(WriteReport(folder / "a.html", "[7]", "").ok());
  EXPECT_EQ(base::ReadFile(folder / "a.data.json").value(), "[7]");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

TEST(WriteReport, NamesATemplateThatCannotBeRead) {
  const tools::TestFolder folder;
  const absl::Status status =
      WriteReport(folder / "a.html", "{}", folder / "gone.html");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("gone.html"));
}

TEST(ReportDataPath, StandsBesideThePageAndNotBesideTheResults) {
  // --json kitchen.json --report kitchen.html
  EXPECT_EQ(ReportDataPath("out/kitchen.html"), "out/kitchen.data.json");
  EXPECT_EQ(ReportDataPath("kitchen"), "kitchen.data.json");
  EXPECT_THAT(NoTemplateNotice("k.html"), HasSubstr("k.data.json"));
  EXPECT_THAT(NoTemplateNotice("k.html"), HasSubstr("scripts/build-report"));
}

}  // namespace
}  // namespace treeline::report
