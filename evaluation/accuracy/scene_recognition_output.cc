#include "evaluation/accuracy/scene_recognition_output.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
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

Json Document(const std::vector<RecognitionTally>& tallies,
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
  return json;
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
  return Document(tallies, run)
             .dump(1, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

std::string RecognitionReportJson(const std::vector<RecognitionTally>& tallies,
                                  const RecognitionRun& run) {
  Json json = {{"kind", "recognition"}};
  json.update(Document(tallies, run));
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace treeline::accuracy
