#include "server/tools/app/shrink_command.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/tools/model_description.h"
#include "server/tools/shrink.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
Leaves out as little as the size takes: first nothing (an older model is only
packed), then leaves of few samples, then also the last bits of keyframes'
features. docs/research/model-size.md has what each size costs. The recording is
not needed; the confidence stays as it was learnt, so ask a few frames of your
own with `treeline evaluate` before you rely on a model of a tenth of its size.
`treeline train --min-kept-samples 10` learns a small model, confidence
included. Of methods sift and points-lines nothing is left out.

Examples:
  treeline shrink kitchen.treeline --max-size 4 --output kitchen-4mb.treeline
  treeline shrink old.treeline --max-size 1000 --output packed.treeline)";

struct ShrinkFlags {
  std::string model_path;
  std::string output;
  double max_size_mb = 4;
};

absl::Status Shrink(const ShrinkFlags& flags) {
  TL_RETURN_IF_ERROR(base::CheckWritable(flags.output));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                      forest::ModelFile::Open(flags.model_path));
  const absl::StatusOr<tools::ShrunkModel> shrunk = tools::ShrinkModel(
      *model, static_cast<uint64_t>(std::floor(1e6 * flags.max_size_mb)));
  if (!shrunk.ok()) return base::Annotate(shrunk.status(), flags.model_path);
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(flags.output, shrunk->file));
  // Reads what it wrote, as a server will.
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> small,
                      forest::ModelFile::Open(flags.output));
  std::string left_out;
  if (small->info().leaves < model->info().leaves) {
    absl::StrAppend(&left_out, ", without leaves of fewer than ",
                    shrunk->min_kept_samples, " samples");
  }
  if (shrunk->feature_step > 1) {
    absl::StrAppend(&left_out, ", features in steps of ", shrunk->feature_step);
  }
  std::printf("%s: %s in place of %s, %s leaves of %s%s\n",
              flags.output.c_str(),
              tools::FormatBytes(small->info().file_bytes).c_str(),
              tools::FormatBytes(model->info().file_bytes).c_str(),
              tools::FormatCount(small->info().leaves).c_str(),
              tools::FormatCount(model->info().leaves).c_str(),
              left_out.empty() ? ", nothing left out" : left_out.c_str());
  return absl::OkStatus();
}

}  // namespace

cli::Command AddShrinkCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("shrink", "Make a model smaller, to a size");
  command->footer(kFooter);
  auto flags = std::make_shared<ShrinkFlags>();
  command->add_option("model", flags->model_path, "Model file")
      ->type_name("MODEL")
      ->required();
  command
      ->add_option("--max-size", flags->max_size_mb,
                   "The new file has at most so many megabytes (10^6 bytes)")
      ->type_name("MB")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str();
  command->add_option("--output", flags->output, "Model file to write")
      ->type_name("FILE")
      ->required();
  return {command, [flags](const std::stop_token&) { return Shrink(*flags); }};
}

}  // namespace treeline::tools_app
