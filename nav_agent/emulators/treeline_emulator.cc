// treeline-emulator: devices that a robot is made of, byte for byte, for
// drivers that want to be tested.
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/interrupt.h"
#include "common/base/version.h"
#include "nav_agent/emulators/commands.h"

namespace treeline {
namespace {

constexpr const char* kFooter = R"(
treeline-emulator COMMAND --help explains a device and gives examples.

Ctrl-C stops it. Exit codes: 0 stopped, 1 failed, 2 wrong usage.)";

int Run(int argc, char** argv) {
  const std::stop_token stop = StopOnInterrupt();
  CLI::App app(
      "Devices that a robot is made of, played by a program: what they send "
      "and understand, byte for byte, over a pseudo terminal or TCP. Drivers "
      "cannot tell the difference.",
      "treeline-emulator");
  app.footer(kFooter);
  app.set_version_flag("--version",
                       std::string("treeline-emulator ") + Version());
  app.require_subcommand(1);
  const std::vector<EmulatorCommand> commands = {
      AddLaserCommand(app), AddBaseCommand(app), AddRobotCommand(app)};
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // 0 for --help and --version.
    return app.exit(error) == 0 ? 0 : kEmulatorUsage;
  }
  for (const EmulatorCommand& command : commands) {
    if (command.app->parsed()) return command.run(stop);
  }
  return kEmulatorUsage;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) { return treeline::Run(argc, argv); }
