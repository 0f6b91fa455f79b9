#include "server/app/command_line.h"

#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/version.h"
#include "common/cli/arguments.h"
#include "common/config/config_flags.h"
#include "server/app/server_config.h"

namespace treeline::server_app {
namespace {

constexpr const char* kDescription =
    "Answers where a camera is: loads the scenes of a folder and serves them "
    "over gRPC.";

constexpr const char* kFooter = R"(
Every flag but --config can stand in the file that --config names, as a line
`max_message_mib: 64`, and in the environment, as TREELINE_SERVER_MAX_MESSAGE_MIB.
Flags beat the environment, and that beats the file. SIGHUP reads them again;
what is marked so above changes then, the rest needs a restart.

Scenes lie in DIR/<scene>/<version>/model.treeline, as `treeline train` writes
them; names are of A-Z a-z 0-9 . _ - and of two versions the greater number is
the newer. A model that cannot be loaded is reported, and the others serve.

Examples:
  treeline train --dataset 7scenes:office --frames train.txt --method rgbd \
      --output models/office/1/model.treeline
  treeline-server --models models
  treeline-server --config site.yaml --print-config
  treeline-server healthcheck
  treeline-client localize --server 127.0.0.1:50051 --scene office \
      --color query.color.jpg --depth query.depth.png

When it serves, it prints on standard output, for scripts to wait for:
  listening on 127.0.0.1:50051
With port 0 that is a port that was free. The log goes to standard error and
never holds images.

SIGTERM and Ctrl-C stop it in order: health turns to NOT_SERVING, calls are
answered for --drain-s more, then the port is closed and calls in flight get
--grace-s to finish. A second signal ends it at once.

Exit codes: 0 stopped as asked, 1 failed, 2 wrong usage.)";

constexpr const char* kHealthcheckFooter = R"(
Prints one line. Of a server with port 0 or another address than the default,
say where it is.

Examples:
  treeline-server healthcheck
  treeline-server healthcheck --server 127.0.0.1:50051 --scene office
  treeline-server healthcheck --tls-ca ca.pem --tls-name reloc.example.com

Exit codes: 0 healthy, 1 not, 2 wrong usage.)";

CLI::App* AddHealthcheck(CLI::App& app, HealthcheckOptions& options) {
  CLI::App* command = app.add_subcommand(
      "healthcheck", "Ask a running server whether it serves");
  command->footer(kHealthcheckFooter);
  command->add_option("--server", options.server, "Where it listens")
      ->capture_default_str()
      ->type_name("HOST:PORT");
  command
      ->add_option("--scene", options.scene,
                   "Ask about this scene; without: about the server")
      ->type_name("NAME");
  command
      ->add_option("--timeout-s", options.timeout_s,
                   "How long to wait for the answer")
      ->capture_default_str()
      ->type_name("SECONDS")
      ->check(CLI::Range(0.001, 3600.0));
  CLI::Option* ca =
      command
          ->add_option("--tls-ca", options.tls_ca,
                       "Ask over TLS; authorities that may vouch for the "
                       "server, PEM")
          ->type_name("FILE");
  command
      ->add_option("--tls-name", options.tls_name,
                   "Name in the server's certificate, if it is not HOST")
      ->type_name("NAME")
      ->needs(ca);
  CLI::Option* cert = command
                          ->add_option("--tls-cert", options.tls_cert,
                                       "Certificate to show to the server, PEM")
                          ->type_name("FILE")
                          ->needs(ca);
  CLI::Option* key =
      command->add_option("--tls-key", options.tls_key, "Its private key, PEM")
          ->type_name("FILE")
          ->needs(cert);
  cert->needs(key);
  return command;
}

}  // namespace

CommandLine ReadCommandLine(int argc, const char* const* argv,
                            const char* const* environment) {
  CommandLine line;
  line.sources.environment =
      config::EnvironmentWith(environment, kServerEnvironmentPrefix);
  line.sources.environment_prefix = kServerEnvironmentPrefix;
  const std::string file_variable =
      absl::StrCat(kServerEnvironmentPrefix, "CONFIG");
  if (const auto file = line.sources.environment.find(file_variable);
      file != line.sources.environment.end()) {
    line.sources.file = file->second;
  }

  CLI::App app(kDescription, "treeline-server");
  app.formatter(cli::HelpFormatter());
  app.footer(kFooter);
  app.set_version_flag("--version",
                       std::string("treeline-server ") + base::Version());
  app.add_option("--config", line.sources.file, "YAML file with settings")
      ->type_name("FILE");
  bool print_config = false;
  app.add_flag("--print-config", print_config,
               "Print what is in force, and where each value comes from");
  const config::ConfigFlags flags(app, ServerConfigTable().settings());
  const CLI::App* healthcheck = AddHealthcheck(app, line.healthcheck);
  line.exit_code = cli::ParseArguments(app, argc, argv);
  if (line.exit_code) return line;
  line.sources.flags = flags.Given();
  if (healthcheck->parsed()) {
    line.task = CommandLine::Task::kHealthcheck;
  } else if (print_config) {
    line.task = CommandLine::Task::kPrintConfig;
  }
  return line;
}

}  // namespace treeline::server_app
