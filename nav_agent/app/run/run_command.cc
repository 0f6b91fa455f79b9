#include "nav_agent/app/run/run_command.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/config/config_flags.h"
#include "common/tracing/tracing_options.h"
#include "nav_agent/app/run/agent_run.h"
#include "nav_agent/app/run/parameter_tables.h"

namespace treeline::run_app {
namespace {

constexpr const char* kFooter = R"(
Every flag but --config can stand in the file that --config names, as a line
`max_forward_mps: 0.4`, and in the environment, as
TREELINE_AGENT_MAX_FORWARD_MPS. Flags beat the environment, and that beats the
file. docs/reference/agent.md describes the settings, the API and the metrics.

When it drives, it prints on standard output, for scripts to wait for:
  grpc on 127.0.0.1:50061
  page on http://127.0.0.1:8081/
  driving
The log goes to standard error. Ctrl-C and SIGTERM: the robot stands, and the
program ends with 0. Without a server, a page or a goal it runs too.

Examples:
  treeline-agent run --simulate cafe
  treeline-agent run --simulate two-storey --goal 4,2,0,1 --speed 4
  treeline-agent run --map house --simulate cafe --server 127.0.0.1:50051
  treeline-agent run --map house --hardware robot.yaml --find-yourself \
      --server reloc.local:50051 --scene house
  treeline-agent run --map house --ros2 robot.yaml --find-yourself
  treeline-agent navigate --agent 127.0.0.1:50061 4,2,0)";

struct RunFlags {
  std::string config;
  bool print_config = false;
  bool print_parameters = false;
  std::unique_ptr<config::ConfigFlags> settings;
};

absl::Status Run(const RunFlags& flags, const std::stop_token& stop) {
  if (flags.print_parameters) {
    std::printf("%s", ParametersAsMarkdown(AgentParameterTables()).c_str());
    return absl::OkStatus();
  }
  const config::ConfigTable<AgentConfig>& table = AgentConfigTable();
  const config::ConfigSources sources = {
      .file = flags.config,
      .environment = config::EnvironmentWith(environ, kAgentPrefix),
      .environment_prefix = kAgentPrefix,
      .flags = flags.settings->Given()};
  TL_ASSIGN_OR_RETURN(const config::EffectiveConfig effective,
                      config::ResolveConfig(table.settings(), sources));
  if (flags.print_config) {
    std::printf("%s%s",
                config::PrintConfig(table.settings(), effective).c_str(),
                ParametersAsYamlComments(AgentParameterTables()).c_str());
    return absl::OkStatus();
  }
  AgentConfig config = table.Make(effective);
  config.otel =
      tracing::OptionsFromEnvironment(config::EnvironmentWith(environ, "OTEL_"),
                                      "treeline-agent", base::Version());
  const auto log = logging::LogToStandardError(
      "treeline-agent", logging::LogFormatOf(config.log_format));
  log->SetLevel(logging::LogLevelOf(config.log_level));
  log->TakeGrpcMessages();
  for (const std::string& variable :
       config::UnknownVariables(table.settings(), sources)) {
    log->Say(logging::LogLevel::kWarn,
             "environment: no setting belongs to " + variable);
  }
  for (const std::string& warning : config.otel.warnings) {
    log->Say(logging::LogLevel::kWarn, "environment: " + warning);
  }
  return RunAgent(
      config, *log,
      [](const std::string& line) {
        std::printf("%s\n", line.c_str());
        std::fflush(stdout);
      },
      stop);
}

}  // namespace

cli::Command AddRunCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "run", "Drive a robot, real or simulated: takes goals, relocalizes");
  command->footer(kFooter);
  auto flags = std::make_shared<RunFlags>();
  command
      ->add_option("--config", flags->config, "Settings below those of flags")
      ->type_name("FILE");
  command->add_flag("--print-config", flags->print_config,
                    "Show what is in force, and where it comes from; and, as "
                    "comments, the constants of the code");
  command->add_flag("--print-parameters", flags->print_parameters,
                    "Show these constants alone, as a page in Markdown "
                    "(docs/reference/parameters.md)");
  flags->settings = std::make_unique<config::ConfigFlags>(
      *command, AgentConfigTable().settings());
  return {command,
          [flags](const std::stop_token& stop) { return Run(*flags, stop); }};
}

}  // namespace treeline::run_app
