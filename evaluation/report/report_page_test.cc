#include "evaluation/report/report_page.h"

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::report {
namespace {

using ::testing::HasSubstr;

constexpr const char* kTemplate =
    "<p>before</p><script type=\"application/json\">\"@REPORT_DATA@\"</script>";

TEST(WriteReport, WritesThePage) {
  const tools::TestFolder folder;
  ASSERT_TRUE(
      base::WriteFileAtomically(folder / "template.html", kTemplate).ok());
  ASSERT_TRUE(
      WriteReport(folder / "a.html", "[7]", folder / "template.html").ok());
  EXPECT_THAT(base::ReadFile(folder / "a.html").value(), HasSubstr(">[7]<"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.data.json"));
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
