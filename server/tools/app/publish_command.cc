#include "server/tools/app/publish_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/repository/folder_source.h"
#include "server/repository/index_signature.h"
#include "server/tools/publish.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
DIR is a folder as treeline-server serves it: DIR/<scene>/<version>/
model.treeline, and DIR/<scene>/scene.json where a scene has one. The index
names each model with its size and SHA-256. Copy the index last: servers then
never look for what is not there yet.

With --sign-key the index is signed, and servers that are given the public key
(--models-keys) believe no other, whoever holds the web server:
  openssl genpkey -algorithm ed25519 -out publisher.key
  openssl pkey -in publisher.key -pubout -out publisher.pem

Examples:
  treeline publish --models models
  rsync -r --exclude index.json models/ web:/srv/models/
  rsync models/index.json web:/srv/models/
  treeline-server --models https://web/models/ --cache /var/cache/treeline

  aws s3 sync models s3://bucket/models --exclude index.json
  aws s3 cp models/index.json s3://bucket/models/index.json)";

// An Ed25519 key in PEM is much shorter.
constexpr size_t kMaxKeyBytes = 1 << 16;

struct PublishFlags {
  std::string models;
  std::string output;
  std::string sign_key;
  tools::PublishOptions options;
};

absl::StatusOr<std::optional<repository::IndexSigner>> SignerOf(
    const PublishFlags& flags) {
  if (flags.sign_key.empty()) return std::nullopt;
  TL_ASSIGN_OR_RETURN(const std::string pem,
                      base::ReadFile(flags.sign_key, kMaxKeyBytes));
  auto signer = repository::IndexSigner::FromPem(pem);
  if (!signer.ok()) return base::Annotate(signer.status(), flags.sign_key);
  return *std::move(signer);
}

absl::Status Publish(const PublishFlags& flags, const std::stop_token& stop) {
  const std::string output =
      flags.output.empty() ? flags.models + "/index.json" : flags.output;
  TL_RETURN_IF_ERROR(base::CheckWritable(output));
  TL_ASSIGN_OR_RETURN(const std::optional<repository::IndexSigner> signer,
                      SignerOf(flags));
  repository::FolderSource source(flags.models);
  TL_ASSIGN_OR_RETURN(const repository::ModelIndex index,
                      tools::IndexModels(source, flags.options, stop));
  TL_ASSIGN_OR_RETURN(std::string text, repository::ModelIndexJson(index));
  // Reads what it wrote: a server that refused it would notice much later.
  TL_ASSIGN_OR_RETURN(repository::ModelIndex read,
                      repository::ParseModelIndex(text));
  if (signer.has_value()) {
    // As servers read it.
    read.published_unix_s =
        static_cast<uint64_t>(absl::ToUnixSeconds(absl::Now()));
    TL_RETURN_IF_ERROR(signer->Sign(read));
    TL_ASSIGN_OR_RETURN(text, repository::ModelIndexJson(read));
  }
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(output, text));
  std::set<std::string> scenes;
  uint64_t bytes = 0;
  for (const repository::IndexedModel& model : index.models) {
    scenes.insert(model.scene);
    bytes += model.bytes;
  }
  std::printf("%s: %zu models of %zu scenes, %.1f MB%s\n", output.c_str(),
              index.models.size(), scenes.size(),
              static_cast<double>(bytes) / 1e6,
              signer.has_value() ? ", signed" : "");
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
  command
      ->add_option("--sign-key", flags->sign_key,
                   "Private Ed25519 key to sign the index with, PEM")
      ->type_name("FILE");
  command->add_flag("--quiet", flags->options.quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return Publish(*flags, stop);
          }};
}

}  // namespace treeline::tools_app
