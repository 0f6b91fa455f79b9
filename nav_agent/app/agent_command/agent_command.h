// Commands of `treeline-agent` that ask something of a running agent: how they
// are added to their group, and how a call is followed.
#ifndef NAV_AGENT_APP_AGENT_COMMAND_AGENT_COMMAND_H_
#define NAV_AGENT_APP_AGENT_COMMAND_AGENT_COMMAND_H_

#include <memory>
#include <stop_token>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "common/base/live_display.h"
#include "common/cli/program.h"

namespace treeline::agent_command {

// A command of `group`. Flags are shared by the commands of a group and have a
// string `agent`. Work is an absl::Status of (const Flags&), or of
// (const Flags&, const std::stop_token&) if Ctrl-C ends it.
template <typename Flags, typename Work>
cli::Command AddTo(CLI::App& group, const std::string& name,
                   const std::string& what, const std::shared_ptr<Flags>& flags,
                   Work work) {
  CLI::App* command = group.add_subcommand(name, what);
  command->add_option("--agent", flags->agent, "Where it answers gRPC")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  return {command,
          [flags, work = std::move(work)](const std::stop_token& stop) {
            if constexpr (std::is_invocable_v<Work, const Flags&,
                                              const std::stop_token&>) {
              return work(*flags, stop);
            } else {
              return work(*flags);
            }
          }};
}

// The names of what is to be removed.
inline void AddNames(const cli::Command& command,
                     std::vector<std::string>& names) {
  command.app->add_option("names", names, "Their names")
      ->type_name("NAME")
      ->required();
}

// The YAML file of what is to be kept.
inline void AddFile(const cli::Command& command, std::string& file) {
  command.app->add_option("file", file, "YAML file")
      ->type_name("FILE")
      ->required();
}

// Reads a call's answers to their end and leaves the last in `last`; shows each
// as `line_of` says it, unless `quiet`.
template <typename Stream, typename Answer, typename LineOf>
void Follow(Stream& stream, bool quiet, const LineOf& line_of, Answer& last) {
  base::LiveDisplay display;
  while (stream.Read(&last)) {
    if (!quiet) display.Show(line_of(last));
  }
}

}  // namespace treeline::agent_command

#endif  // NAV_AGENT_APP_AGENT_COMMAND_AGENT_COMMAND_H_
