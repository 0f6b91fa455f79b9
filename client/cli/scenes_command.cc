#include "client/cli/scenes_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/answer_text.h"
#include "client/cli/connection_flags.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "client/relocalizer/relocalizer.h"

namespace treeline::client_cli {
namespace {

constexpr const char* kFooter = R"(
Examples:
  treeline-client scenes --server 127.0.0.1:50051
  treeline-client scenes --server 127.0.0.1:50051 --scene office --json
  treeline-client scenes --server 127.0.0.1:50052 --scene office --load
  treeline-client scenes --server 127.0.0.1:50052 --scene office --unload

--load and --unload are for those who run the server: by its admin listener, or
with a token of scope admin. --load returns when the scene answers.)";

struct ScenesFlags {
  ConnectionFlags connection;
  std::string scene;
  std::string model_version;
  bool load = false;
  bool unload = false;
  bool json = false;
};

absl::StatusOr<relocalizer::SceneDescription> AskAboutOne(
    relocalizer::Relocalizer& client, const ScenesFlags& flags,
    const relocalizer::CallOptions& options) {
  if (flags.load) {
    return client.LoadScene(flags.scene, flags.model_version, options);
  }
  if (flags.unload) {
    return client.UnloadScene(flags.scene, flags.model_version, options);
  }
  return client.GetScene(flags.scene, options);
}

absl::StatusOr<std::vector<relocalizer::SceneDescription>> Ask(
    relocalizer::Relocalizer& client, const ScenesFlags& flags,
    const relocalizer::CallOptions& options) {
  if (flags.scene.empty()) return client.ListScenes(options);
  absl::StatusOr<relocalizer::SceneDescription> scene =
      AskAboutOne(client, flags, options);
  if (!scene.ok()) return scene.status();
  return std::vector<relocalizer::SceneDescription>{*std::move(scene)};
}

int RunScenes(const ScenesFlags& flags, const std::stop_token& stop) {
  const auto client =
      relocalizer::ConnectRelocalizer(ConnectOptionsOf(flags.connection));
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
  CLI::Option* scene =
      command->add_option("--scene", flags->scene, "Only this one")
          ->type_name("NAME");
  CLI::Option* load =
      command->add_flag("--load", flags->load, "Load it now")->needs(scene);
  command->add_flag("--unload", flags->unload, "Take it out of memory")
      ->needs(scene)
      ->excludes(load);
  command
      ->add_option("--model-version", flags->model_version,
                   "Version to load (without: the newest) or unload (without: "
                   "all)")
      ->type_name("VERSION")
      ->needs(scene);
  command->add_flag("--json", flags->json, "One JSON object");
  return {command, [flags](const std::stop_token& stop) {
            return RunScenes(*flags, stop);
          }};
}

}  // namespace treeline::client_cli
