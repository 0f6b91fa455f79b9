// treeline-client scenes: what a server has.
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/answer_text.h"
#include "client/cli/commands.h"
#include "client/cli/connection_flags.h"
#include "client/relocalizer/relocalizer.h"

namespace treeline {
namespace {

constexpr const char* kFooter = R"(
Examples:
  treeline-client scenes --server 127.0.0.1:50051
  treeline-client scenes --server 127.0.0.1:50051 --scene office --json)";

struct ScenesFlags {
  ConnectionFlags connection;
  std::string scene;
  bool json = false;
};

absl::StatusOr<std::vector<SceneDescription>> Ask(Relocalizer& client,
                                                  const ScenesFlags& flags,
                                                  const CallOptions& options) {
  if (flags.scene.empty()) return client.ListScenes(options);
  absl::StatusOr<SceneDescription> scene =
      client.GetScene(flags.scene, options);
  if (!scene.ok()) return scene.status();
  return std::vector<SceneDescription>{*std::move(scene)};
}

int RunScenes(const ScenesFlags& flags, const std::stop_token& stop) {
  const auto client = ConnectRelocalizer(ConnectOptionsOf(flags.connection));
  if (!client.ok()) {
    return ReportFailure(client.status(), flags.connection, stop);
  }
  const auto scenes =
      Ask(**client, flags, CallOptionsOf(flags.connection, stop));
  if (!scenes.ok()) {
    return ReportFailure(scenes.status(), flags.connection, stop);
  }
  std::fputs(flags.json ? (ScenesJson(*scenes) + "\n").c_str()
                        : ScenesText(*scenes).c_str(),
             stdout);
  return FlushOutput() ? kExitLocalized : kExitFailed;
}

}  // namespace

ClientCommand AddScenesCommand(CLI::App& app) {
  auto flags = std::make_shared<ScenesFlags>();
  CLI::App* command =
      app.add_subcommand("scenes", "List the scenes of a server");
  command->footer(kFooter);
  AddConnectionFlags(*command, flags->connection);
  command->add_option("--scene", flags->scene, "Only this one")
      ->type_name("NAME");
  command->add_flag("--json", flags->json, "One JSON object");
  return {command, [flags](const std::stop_token& stop) {
            return RunScenes(*flags, stop);
          }};
}

}  // namespace treeline
