#include "evaluation/report/report.h"

#include "absl/strings/str_cat.h"
#include "evaluation/report/report_comparison.h"
#include "evaluation/report/report_distance.h"
#include "evaluation/report/report_method.h"
#include "evaluation/report/report_parts.h"
#include "evaluation/report/report_scene_coordinates.h"
#include "evaluation/report/report_style.h"
#include "evaluation/report/report_svg.h"
#include "evaluation/report/report_trust.h"
#include "server/tools/model_description.h"

namespace treeline::report {
namespace {

std::string Title(const ReportContents& contents) {
  return absl::StrCat("<p class=\"eyebrow\">Treeline evaluation</p>\n<h1>",
                      EscapeHtml(DatasetName(contents.run.dataset_uri)),
                      "</h1>\n<p class=\"lede\">");
}

std::string ModelCards(const accuracy::EvaluatedMethod& method) {
  std::string html;
  for (const tools::DescriptionSection& section :
       tools::DescribeModel(method.model)) {
    absl::StrAppend(&html, Card(absl::StrCat("Model: ", section.title),
                                RowsTable(section.rows)));
  }
  return html;
}

std::string RunCard(const accuracy::EvaluationRun& run,
                    const std::vector<accuracy::EvaluatedMethod>& methods) {
  std::vector<tools::DescriptionRow> rows{
      {"dataset", run.dataset_uri},
      {"frames", run.frame_list.empty() ? "all" : run.frame_list},
      {"ground truth",
       run.pose_file.empty() ? "the recording's own" : run.pose_file}};
  for (const accuracy::EvaluatedMethod& method : methods) {
    rows.emplace_back(
        methods.size() == 1 ? "model" : absl::StrCat("model of ", method.name),
        method.model_path.empty() ? "none: a baseline" : method.model_path);
  }
  rows.insert(rows.end(),
              {{"seed", absl::StrCat(run.seed)},
               {"threads", absl::StrCat(run.threads)},
               {"machine", run.cpu},
               {"peak memory", tools::FormatBytes(run.peak_memory_bytes)},
               {"software", absl::StrCat("treeline ", run.software_version)},
               {"started", run.started_utc}});
  return Card("Evaluation", RowsTable(rows));
}

std::string ProvenanceSection(const ReportContents& contents) {
  const bool single = contents.methods.size() == 1;
  return absl::StrCat(
      Heading("Where this comes from",
              "What was measured, with what, and how the model came about."),
      "<div class=\"cards\">", RunCard(contents.run, contents.methods),
      single ? ModelCards(contents.methods.front()) : "",
      "</div>\n<h3 style=\"margin-top:26px\">Command</h3><pre>",
      EscapeHtml(contents.run.command), "</pre>\n");
}

std::string OneMethod(const ReportContents& contents) {
  const accuracy::EvaluatedMethod& method = contents.methods.front();
  return absl::StrCat(
      Title(contents), MethodVerdict(method), "</p>\n", MethodTiles(method),
      MethodSections(method, contents.run, "m0"),
      SceneCoordinatesSection(contents.methods), SweepSection(contents.sweeps),
      TrustSection(contents.methods, contents.run),
      PublishedSection(contents.methods, contents.run));
}

std::string ManyMethods(const ReportContents& contents) {
  std::string html = absl::StrCat(
      Title(contents), ComparisonVerdict(contents.methods), "</p>\n",
      ComparisonSection(contents.methods, contents.run),
      DistanceSection(contents.methods),
      SceneCoordinatesSection(contents.methods), SweepSection(contents.sweeps),
      TrustSection(contents.methods, contents.run),
      PublishedSection(contents.methods, contents.run),
      Heading("Method by method",
              "Unfold a method to see its frames, pictures and trajectory."));
  for (size_t i = 0; i < contents.methods.size(); ++i) {
    const accuracy::EvaluatedMethod& method = contents.methods[i];
    if (!method.status.ok()) continue;
    absl::StrAppend(
        &html, "<details class=\"method\"><summary><b>",
        EscapeHtml(method.name), "</b> <span>", MethodVerdict(method),
        "</span></summary>\n", MethodTiles(method),
        MethodSections(method, contents.run, absl::StrCat("m", i)),
        Heading("The model", "What its file says about itself."),
        "<div class=\"cards\">", ModelCards(method), "</div></details>\n");
  }
  return html;
}

}  // namespace

std::string ReportHtml(const ReportContents& contents) {
  return absl::StrCat(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<title>",
      EscapeHtml(DatasetName(contents.run.dataset_uri)),
      " – Treeline evaluation</title>\n<style>", ReportStyle(),
      "</style>\n</head>\n<body>\n<main>\n",
      contents.methods.size() == 1 ? OneMethod(contents)
                                   : ManyMethods(contents),
      ProvenanceSection(contents), "<footer>treeline ",
      EscapeHtml(contents.run.software_version), ", ",
      EscapeHtml(contents.run.started_utc),
      "</footer>\n</main>\n</body>\n</html>\n");
}

}  // namespace treeline::report
