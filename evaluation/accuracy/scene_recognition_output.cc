#include "evaluation/accuracy/scene_recognition_output.h"

#include <algorithm>
#include <map>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "evaluation/accuracy/evaluation.h"
#include "nlohmann/json.hpp"

namespace treeline::accuracy {
namespace {

using Json = nlohmann::ordered_json;

double Share(int part, size_t whole) {
  return whole == 0 ? 0
                    : static_cast<double>(part) / static_cast<double>(whole);
}

// All queries of the kind together.
RecognitionTally Sum(const std::vector<RecognitionTally>& tallies,
                     bool foreign) {
  // Scene by scene, so that its counts cannot be taken from the frames.
  RecognitionTally sum;
  for (const RecognitionTally& tally : tallies) {
    if (tally.scene.empty() != foreign) continue;
    sum.frames.insert(sum.frames.end(), tally.frames.begin(),
                      tally.frames.end());
  }
  return sum;
}

template <typename Count>
int Total(const std::vector<RecognitionTally>& tallies, const Count& count) {
  int total = 0;
  for (const RecognitionTally& tally : tallies) {
    if (!tally.scene.empty()) total += count(tally);
  }
  return total;
}

double PercentileOf(const std::vector<RecognizedFrame>& frames,
                    double RecognizedFrame::*member, double p) {
  std::vector<double> values;
  for (const RecognizedFrame& frame : frames) {
    if (frame.status.ok()) values.push_back(frame.*member);
  }
  return Percentile(std::move(values), p).value_or(0);
}

double MeanTried(const std::vector<RecognizedFrame>& frames) {
  int tried = 0;
  for (const RecognizedFrame& frame : frames) tried += frame.tried;
  return Share(tried, frames.size());
}

std::string TimesText(const std::vector<RecognizedFrame>& frames,
                      absl::string_view name, double RecognizedFrame::*member) {
  return absl::StrFormat("%-18s p50 %.2f  p95 %.2f ms\n", name,
                         PercentileOf(frames, member, 50),
                         PercentileOf(frames, member, 95));
}

Json TimesJson(const std::vector<RecognizedFrame>& frames,
               double RecognizedFrame::*member) {
  return {{"p50", PercentileOf(frames, member, 50)},
          {"p95", PercentileOf(frames, member, 95)}};
}

std::string Escaped(absl::string_view text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

// What a frame is counted as in the matrix.
std::string AnswerOf(const RecognizedFrame& frame, bool rank_only) {
  if (!frame.status.ok()) return "";
  if (rank_only) return frame.first;
  return frame.localized ? frame.answer : "";
}

std::string MatrixRow(const RecognitionTally& tally,
                      const RecognitionRun& run) {
  std::map<std::string, int> counts;
  for (const RecognizedFrame& frame : tally.frames) {
    ++counts[AnswerOf(frame, run.options.rank_only)];
  }
  std::string row = absl::StrCat(
      "<tr><th>", Escaped(tally.scene.empty() ? tally.source : tally.scene),
      "</th>");
  const auto add = [&](const std::string& scene, bool is_right) {
    const int count = counts[scene];
    const double share = Share(count, tally.frames.size());
    if (count == 0) {
      absl::StrAppend(&row, "<td></td>");
      return;
    }
    absl::StrAppendFormat(
        &row, "<td style=\"background:%s%.2f)\">%d</td>",
        is_right ? "rgba(40,140,70,"
                 : (scene.empty() ? "rgba(120,120,120," : "rgba(200,40,40,"),
        0.15 + 0.65 * share, count);
  };
  for (const std::string& scene : run.scenes) add(scene, scene == tally.scene);
  add("", false);
  absl::StrAppend(&row, "</tr>\n");
  return row;
}

}  // namespace

std::string RecognitionTable(const std::vector<RecognitionTally>& tallies,
                             const RecognitionRun& run) {
  std::string text = absl::StrFormat(
      "%d scenes\n\n%-18s %6s %8s %8s %8s %8s %6s %6s %6s\n",
      static_cast<int>(run.scenes.size()), "", "frames", "ranked 1", "ranked 3",
      "right", "located", "wrong", "tried", "errors");
  const auto row = [&](absl::string_view name, size_t frames, int first,
                       int three, int right, int located, int wrong,
                       double tried, int errors) {
    absl::StrAppendFormat(
        &text, "%-18s %6d %7.1f%% %7.1f%% %7.1f%% %7.1f%% %6d %6.2f %6d\n",
        name, static_cast<int>(frames), 100 * Share(first, frames),
        100 * Share(three, frames), 100 * Share(right, frames),
        100 * Share(located, frames), wrong, tried, errors);
  };
  for (const RecognitionTally& t : tallies) {
    row(t.scene.empty() ? t.source : t.scene, t.frames.size(),
        t.first_in_ranking(), t.among_first(3), t.right_scene(),
        t.right_localized(), t.wrong_localized(), MeanTried(t.frames),
        t.errors());
  }
  using Tally = const RecognitionTally&;
  const RecognitionTally known = Sum(tallies, false);
  row("all", known.frames.size(),
      Total(tallies, [](Tally t) { return t.first_in_ranking(); }),
      Total(tallies, [](Tally t) { return t.among_first(3); }),
      Total(tallies, [](Tally t) { return t.right_scene(); }),
      Total(tallies, [](Tally t) { return t.right_localized(); }),
      Total(tallies, [](Tally t) { return t.wrong_localized(); }),
      MeanTried(known.frames),
      Total(tallies, [](Tally t) { return t.errors(); }));
  absl::StrAppend(&text, "\n",
                  TimesText(known.frames, "words", &RecognizedFrame::words_ms),
                  TimesText(known.frames, "ranking", &RecognizedFrame::rank_ms),
                  TimesText(known.frames, "poses", &RecognizedFrame::pose_ms));
  absl::StrAppendFormat(&text, "%-18s %.1f ms\n", "read descriptors",
                        run.read_ms);
  return text;
}

std::string RecognitionJson(const std::vector<RecognitionTally>& tallies,
                            const RecognitionRun& run) {
  Json json = {{"command", run.command},
               {"cpu", run.cpu},
               {"software_version", run.software_version},
               {"started_utc", run.started_utc},
               {"scenes", run.scenes},
               {"read_descriptors_ms", run.read_ms},
               {"rank_only", run.options.rank_only},
               {"max_tried", run.options.among.max_tried},
               {"sure_confidence", run.options.among.sure_confidence},
               {"threads", run.options.threads}};
  const RecognitionTally known = Sum(tallies, false);
  json["words_ms"] = TimesJson(known.frames, &RecognizedFrame::words_ms);
  json["rank_ms"] = TimesJson(known.frames, &RecognizedFrame::rank_ms);
  json["pose_ms"] = TimesJson(known.frames, &RecognizedFrame::pose_ms);
  json["queries"] = Json::array();
  for (const RecognitionTally& t : tallies) {
    Json query = {{"scene", t.scene.empty() ? Json(nullptr) : Json(t.scene)},
                  {"source", t.source},
                  {"frames", t.frames.size()},
                  {"ranked_first", t.first_in_ranking()},
                  {"ranked_in_three", t.among_first(3)},
                  {"right_scene", t.right_scene()},
                  {"right_localized", t.right_localized()},
                  {"wrong_localized", t.wrong_localized()},
                  {"mean_tried", MeanTried(t.frames)},
                  {"errors", t.errors()}};
    query["results"] = Json::array();
    for (const RecognizedFrame& f : t.frames) {
      query["results"].push_back(
          {{"stem", f.stem},
           {"rank", f.rank},
           {"first", f.first},
           {"answer", f.answer},
           {"localized", f.localized},
           {"confidence", f.confidence},
           {"tried", f.tried},
           {"error", f.status.ok() ? Json(nullptr)
                                   : Json(std::string(f.status.message()))}});
    }
    json["queries"].push_back(std::move(query));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string RecognitionHtml(const std::vector<RecognitionTally>& tallies,
                            const RecognitionRun& run) {
  std::string html = absl::StrCat(
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">"
      "<title>Scene recognition</title><style>"
      "body{font:14px sans-serif;margin:2em}table{border-collapse:collapse}"
      "td{border:1px solid #ddd;text-align:right;padding:3px 6px;min-width:2em}"
      "th{text-align:left;padding:3px 6px;font-weight:normal}"
      "thead th{writing-mode:vertical-rl}"
      "pre{background:#f4f4f4;padding:1em;white-space:pre-wrap}"
      "</style><h1>Scene recognition</h1><p>Frames by true scene (down) and ",
      run.options.rank_only ? "first in the ranking"
                            : "the scene that answered with a pose",
      " (across).</p><table><thead><tr><th></th>");
  for (const std::string& scene : run.scenes) {
    absl::StrAppend(&html, "<th>", Escaped(scene), "</th>");
  }
  absl::StrAppend(&html, "<th>not localized</th></tr></thead>\n");
  for (const RecognitionTally& tally : tallies) html += MatrixRow(tally, run);
  absl::StrAppend(
      &html, "</table><pre>", Escaped(RecognitionTable(tallies, run)), "\n",
      Escaped(run.command), "\n", Escaped(run.cpu), ", version ",
      Escaped(run.software_version), ", ", run.started_utc, "</pre></html>\n");
  return html;
}

}  // namespace treeline::accuracy
