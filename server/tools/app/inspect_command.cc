#include "server/tools/app/inspect_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "evaluation/accuracy/evaluation_json.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/coverage.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/localizer/localizer.h"
#include "server/tools/coverage_picture.h"
#include "server/tools/coverage_text.h"
#include "server/tools/model_description.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
The whole file is verified before anything is printed.

Coverage says where the scene will work before you go there. For camera places
on a plan of the scene and for 16 headings at each it is predicted whether a
query would be answered: whether the keyframes show enough of what the camera
would see, from directions and distances that are not too different. It takes
no recording, and knows nothing of people, darkness or what was moved since.
  Places       where the training cameras looked through; others stay white
  Camera       at the median height and tilt of the training cameras
  Colours      the share of headings answered there; ticks show which
  What to do   record more where the map is grey or dark, and towards where its
               ticks do not point; then `treeline train --extend MODEL`
Without --coverage, a summary is printed that was computed on a coarser grid,
which overstates the open area (by a third on a large floor).

Examples:
  treeline inspect kitchen.treeline
  treeline inspect --json kitchen.treeline
  treeline inspect kitchen.treeline --coverage kitchen.png \
      --coverage-json kitchen-coverage.json)";

// Few enough places for a fraction of a second.
constexpr keyframes::CoverageOptions kSummaryCoverage{.places = 400,
                                                      .max_cell_m = 10};

struct InspectFlags {
  std::string model_path;
  bool json = false;
  std::string coverage_picture;
  std::string coverage_json;

  bool wants_coverage() const {
    return !coverage_picture.empty() || !coverage_json.empty();
  }
};

// The model's file, or the folder of its version, by the name that says most:
// models/kitchen/1/model.treeline is kitchen.
std::string SceneName(const std::string& model_path) {
  const std::filesystem::path path =
      std::filesystem::absolute(model_path).lexically_normal();
  return path.filename() == "model.treeline"
             ? path.parent_path().parent_path().filename().string()
             : path.stem().string();
}

absl::Status WriteCoverage(const InspectFlags& flags,
                           const forest::ModelInfo& info,
                           const keyframes::KeyframeMap& map,
                           const keyframes::CoverageMap& coverage) {
  if (!flags.coverage_json.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        flags.coverage_json, tools::CoverageJson(coverage)));
  }
  if (flags.coverage_picture.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string png,
                      image::EncodePng(tools::DrawCoverage(
                          map, coverage,
                          absl::StrCat("Where ", SceneName(flags.model_path),
                                       " (", info.method, ") will work"))));
  return base::WriteFileAtomically(flags.coverage_picture, png);
}

absl::Status Inspect(const InspectFlags& flags) {
  for (const std::string& path :
       {flags.coverage_picture, flags.coverage_json}) {
    if (!path.empty()) TL_RETURN_IF_ERROR(base::CheckWritable(path));
  }
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                      forest::ModelFile::Open(flags.model_path));
  const forest::ModelInfo& info = model->info();
  TL_ASSIGN_OR_RETURN(const keyframes::KeyframeMap map,
                      keyframes::KeyframeMap::Read(*model));
  if (flags.json && !flags.wants_coverage()) {
    std::fputs(accuracy::ModelInfoJson(info).c_str(), stdout);
    return absl::OkStatus();
  }
  const absl::StatusOr<keyframes::CoverageMap> coverage =
      keyframes::PredictCoverage(map, info.calibration.color,
                                 flags.wants_coverage()
                                     ? keyframes::CoverageOptions{}
                                     : kSummaryCoverage);
  if (flags.wants_coverage()) {
    TL_RETURN_IF_ERROR(coverage.status());
    TL_RETURN_IF_ERROR(WriteCoverage(flags, info, map, *coverage));
  }
  if (flags.json) {
    std::fputs(accuracy::ModelInfoJson(info).c_str(), stdout);
    return absl::OkStatus();
  }
  std::vector<tools::DescriptionSection> sections = tools::DescribeModel(info);
  sections.insert(sections.begin() + 2,  // behind its size
                  tools::DescribeSizes(model->sections()));
  if (coverage.ok()) sections.push_back(tools::DescribeCoverage(*coverage));
  std::fputs(tools::DescriptionText(sections).c_str(), stdout);
  return absl::OkStatus();
}

}  // namespace

cli::Command AddInspectCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "inspect",
      "Show a model's provenance, options, calibration and size, and "
      "where it will work");
  command->footer(kFooter);
  auto flags = std::make_shared<InspectFlags>();
  command->add_option("model", flags->model_path, "Model file")
      ->type_name("MODEL")
      ->required();
  command->add_flag("--json", flags->json, "Print JSON");
  command
      ->add_option("--coverage", flags->coverage_picture,
                   "Draw where the scene will work (PNG)")
      ->type_name("FILE");
  command
      ->add_option("--coverage-json", flags->coverage_json,
                   "Write the same for programs")
      ->type_name("FILE");
  return {command, [flags](const std::stop_token&) { return Inspect(*flags); }};
}

}  // namespace treeline::tools_app
