#include "server/tools/app/inspect_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "common/base/status_macros.h"
#include "evaluation/accuracy/evaluation_json.h"
#include "server/core/localizer/localizer.h"
#include "server/tools/model_description.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
The whole file is verified before anything is printed.

Examples:
  treeline inspect kitchen.treeline
  treeline inspect --json kitchen.treeline)";

struct InspectFlags {
  std::string model_path;
  bool json = false;
};

absl::Status Inspect(const InspectFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<localizer::Localizer> localizer,
                      localizer::OpenLocalizer(flags.model_path));
  const forest::ModelInfo& info = localizer->info();
  const std::string text =
      flags.json ? accuracy::ModelInfoJson(info)
                 : tools::DescriptionText(tools::DescribeModel(info));
  std::fputs(text.c_str(), stdout);
  return absl::OkStatus();
}

}  // namespace

cli::Command AddInspectCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "inspect", "Show a model's provenance, options, calibration and size");
  command->footer(kFooter);
  auto flags = std::make_shared<InspectFlags>();
  command->add_option("model", flags->model_path, "Model file")
      ->type_name("MODEL")
      ->required();
  command->add_flag("--json", flags->json, "Print JSON");
  return {command, [flags](const std::stop_token&) { return Inspect(*flags); }};
}

}  // namespace treeline::tools_app
