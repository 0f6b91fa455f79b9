#include "nav_agent/app/run/parameter_tables.h"

#include <string_view>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/calibration/parameters.h"
#include "nav_agent/control/parameters.h"
#include "nav_agent/docking/parameters.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/mapless/parameters.h"
#include "nav_agent/planning/parameters.h"

namespace treeline::run_app {
namespace {

constexpr char kIntroduction[] = R"(# Parameters of the robot's program

The constants of the code that were tuned, measured, or follow from something
outside of it: what they are, where they come from, and why. Some are defaults
of settings (`treeline-agent run --help`). Generated; after a change:

    treeline-agent run --print-parameters > docs/reference/parameters.md

| origin | the value comes from |
|---|---|
| geometry | the robot, its sensors, people, or a grid |
| physics | a law, or a limit of the hardware |
| measured | noise or time that was measured |
| tuned | trial, in simulated drives |

What follows from these constants or from the robot's measures is not here, but
beside them in the code (`parameters.h` of each folder, and the headers that it
names).
)";

const char* NameOf(base::ParameterOrigin origin) {
  switch (origin) {
    case base::ParameterOrigin::kGeometry:
      return "geometry";
    case base::ParameterOrigin::kPhysics:
      return "physics";
    case base::ParameterOrigin::kMeasured:
      return "measured";
    case base::ParameterOrigin::kTuned:
      return "tuned";
  }
  return "";
}

// Of Abseil's own type, whatever std's is.
absl::string_view View(std::string_view text) {
  return {text.data(), text.size()};
}

// A cell of a table.
std::string Cell(std::string_view text) {
  return absl::StrReplaceAll(View(text), {{"|", "\\|"}});
}

}  // namespace

std::vector<ParameterTable> AgentParameterTables() {
  return {
      {.folder = "nav_agent/behavior", .rows = behavior::BehaviorParameters()},
      {.folder = "nav_agent/calibration",
       .rows = calibration::CalibrationParameters()},
      {.folder = "nav_agent/control", .rows = control::ControlParameters()},
      {.folder = "nav_agent/docking", .rows = docking::DockingParameters()},
      {.folder = "nav_agent/localization",
       .rows = localization::LocalizationParameters()},
      {.folder = "nav_agent/mapless", .rows = mapless::MaplessParameters()},
      {.folder = "nav_agent/planning", .rows = planning::PlanningParameters()}};
}

std::string ParametersAsYamlComments(std::span<const ParameterTable> tables) {
  std::string text;
  for (const ParameterTable& table : tables) {
    absl::StrAppend(&text, "#\n# ---- constants of ", table.folder, " ----\n");
    for (const base::ParameterRow& row : table.rows) {
      absl::StrAppend(&text, "# ", View(row.name), ": ", row.value);
      if (!row.unit.empty()) absl::StrAppend(&text, " ", View(row.unit));
      absl::StrAppend(&text, "  # ", NameOf(row.origin), ": ", View(row.why),
                      "\n");
    }
  }
  return text;
}

std::string ParametersAsMarkdown(std::span<const ParameterTable> tables) {
  std::string text = kIntroduction;
  for (const ParameterTable& table : tables) {
    absl::StrAppend(&text, "\n## ", table.folder,
                    "\n\n| name | value | unit | origin | why |\n"
                    "|---|---|---|---|---|\n");
    for (const base::ParameterRow& row : table.rows) {
      absl::StrAppend(&text, "| `", View(row.name), "` | ", Cell(row.value),
                      " | ", Cell(row.unit), " | ", NameOf(row.origin), " | ",
                      Cell(row.why), " |\n");
    }
  }
  return text;
}

}  // namespace treeline::run_app
