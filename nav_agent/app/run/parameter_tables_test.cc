#include "nav_agent/app/run/parameter_tables.h"

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include "gtest/gtest.h"

namespace treeline::run_app {
namespace {

TEST(ParameterTables, ThePageIsWhatTheProgramPrints) {
  std::ifstream file(TREELINE_PARAMETERS_PAGE);
  const std::string page((std::istreambuf_iterator<char>(file)),
                         std::istreambuf_iterator<char>());
  EXPECT_EQ(page, ParametersAsMarkdown(AgentParameterTables()))
      << "treeline-agent run --print-parameters > docs/reference/parameters.md";
}

TEST(ParameterTables, EachConstantHasAnOwnNameAndAReason) {
  for (const ParameterTable& table : AgentParameterTables()) {
    std::set<std::pair<std::string_view, std::string_view>> names;
    for (const base::ParameterRow& row : table.rows) {
      EXPECT_TRUE(names.emplace(row.name, row.unit).second)
          << table.folder << " " << row.name;
      EXPECT_FALSE(row.value.empty()) << row.name;
      EXPECT_FALSE(row.why.empty()) << row.name;
    }
  }
}

TEST(ParameterTables, BesideSettingsTheyAreComments) {
  const ParameterTable table = {
      .folder = "a/folder",
      .rows = {{.name = "reach",
                .value = "0.5",
                .unit = "m",
                .origin = base::ParameterOrigin::kGeometry,
                .why = "an arm | a leg"}}};
  EXPECT_EQ(ParametersAsYamlComments({{table}}),
            "#\n# ---- constants of a/folder ----\n"
            "# reach: 0.5 m  # geometry: an arm | a leg\n");
  EXPECT_NE(ParametersAsMarkdown({{table}}).find(
                "| `reach` | 0.5 | m | geometry | an arm \\| a leg |\n"),
            std::string::npos);
  std::istringstream lines(ParametersAsYamlComments(AgentParameterTables()));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_EQ(line.substr(0, 1), "#");
  }
}

}  // namespace
}  // namespace treeline::run_app
