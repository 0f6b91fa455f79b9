// The subcommands of `treeline-emulator`, one per device and file.
#ifndef NAV_AGENT_EMULATORS_COMMANDS_H_
#define NAV_AGENT_EMULATORS_COMMANDS_H_

#include <functional>
#include <stop_token>

namespace CLI {
class App;
}

namespace treeline {

enum EmulatorExitCode {
  kEmulatorDone = 0,  // stopped by Ctrl-C, as is meant to be
  kEmulatorFailed = 1,
  kEmulatorUsage = 2
};

// A subcommand adds its options to a CLI11 subcommand of `app` and returns
// what to run if the user chose it: until `stop`, then an exit code.
struct EmulatorCommand {
  CLI::App* app = nullptr;
  std::function<int(std::stop_token stop)> run;
};

EmulatorCommand AddBaseCommand(CLI::App& app);
EmulatorCommand AddLaserCommand(CLI::App& app);
EmulatorCommand AddRobotCommand(CLI::App& app);

}  // namespace treeline

#endif  // NAV_AGENT_EMULATORS_COMMANDS_H_
