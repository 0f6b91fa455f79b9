#include "server/tools/app/publish_command.h"

#include <cstdio>
#include <memory>
#include <set>
#include <string>

#include "CLI/CLI.hpp"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/repository/folder_source.h"
#include "server/tools/publish.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
DIR is a folder as treeline-server serves it: DIR/<scene>/<version>/
model.treeline, and DIR/<scene>/scene.json where a scene has one. The index
names each model with its size and SHA-256. Copy the index last: servers then
never look for what is not there yet.

Examples:
  treeline publish --models models
  rsync -r --exclude index.json models/ web:/srv/models/
  rsync models/index.json web:/srv/models/
  treeline-server --models https://web/models/ --cache /var/cache/treeline

  aws s3 sync models s3://bucket/models --exclude index.json
  aws s3 cp models/index.json s3://bucket/models/index.json)";

struct PublishFlags {
  std::string models;
  std::string output;
  tools::PublishOptions options;
};

absl::Status Publish(const PublishFlags& flags, const std::stop_token& stop) {
  const std::string output =
      flags.output.empty() ? flags.models + "/index.json" : flags.output;
  TL_RETURN_IF_ERROR(base::CheckWritable(output));
  repository::FolderSource source(flags.models);
  TL_ASSIGN_OR_RETURN(const repository::ModelIndex index,
                      tools::IndexModels(source, flags.options, stop));
  TL_ASSIGN_OR_RETURN(const std::string text,
                      repository::ModelIndexJson(index));
  // Reads what it wrote: a server that refused it would notice much later.
  TL_RETURN_IF_ERROR(repository::ParseModelIndex(text).status());
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(output, text));
  std::set<std::string> scenes;
  uint64_t bytes = 0;
  for (const repository::IndexedModel& model : index.models) {
    scenes.insert(model.scene);
    bytes += model.bytes;
  }
  std::printf("%s: %zu models of %zu scenes, %.1f MB\n", output.c_str(),
              index.models.size(), scenes.size(),
              static_cast<double>(bytes) / 1e6);
  return absl::OkStatus();
}

}  // namespace

cli::Command AddPublishCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "publish", "Write the index of a folder of models for a web server");
  command->footer(kFooter);
  auto flags = std::make_shared<PublishFlags>();
  command->add_option("--models", flags->models, "Folder with the scenes")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--output", flags->output,
                   "The index; without: index.json in DIR")
      ->type_name("FILE");
  command
      ->add_option("--base-url", flags->options.base_url,
                   "Where the scenes will lie, ending with /; without: "
                   "beside the index")
      ->type_name("URL");
  command->add_flag("--quiet", flags->options.quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return Publish(*flags, stop);
          }};
}

}  // namespace treeline::tools_app
