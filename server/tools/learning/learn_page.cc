#include "server/tools/learning/learn_page.h"

#include <cmath>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"

namespace treeline::learning {
namespace {

// No script runs and nothing is asked of anybody.
constexpr const char* kHead = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'">
<style>
:root { color-scheme: light dark; --back: #fff; --card: #f5f6f8;
  --text: #1d2129; --quiet: #5b6472; --line: #d9dde3; --good: #14733f;
  --fair: #8a5a00; --poor: #b3261e; }
@media (prefers-color-scheme: dark) { :root { --back: #14171c; --card: #1e232b;
  --text: #e8eaee; --quiet: #a3acba; --line: #363d49; --good: #5ccf8d;
  --fair: #f0b849; --poor: #ff8a80; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--back); color: var(--text);
  font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 58rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.1rem; font-weight: 600; margin: 0; color: var(--quiet); }
h2 { font-size: 1.25rem; margin: 2.5rem 0 .75rem; }
.headline { font-size: 1.9rem; line-height: 1.2; font-weight: 700;
  margin: .25rem 0 1rem; }
.good { color: var(--good); } .fair { color: var(--fair); }
.poor { color: var(--poor); }
.tiles { display: grid; gap: .75rem; margin: 1.25rem 0;
  grid-template-columns: repeat(auto-fit, minmax(11rem, 1fr)); }
.tile { background: var(--card); border-radius: .6rem; padding: .8rem 1rem; }
.tile b { display: block; font-size: 1.7rem; line-height: 1.3; }
.tile span, .quiet { color: var(--quiet); font-size: .9rem; }
.quiet { overflow-wrap: anywhere; }
.plan { display: block; max-width: 100%; height: auto; background: #fff;
  border: 1px solid var(--line); border-radius: .6rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .45rem .75rem .45rem 0;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; } td.number, th.number { text-align: right; }
td.number { white-space: nowrap; }
.scroll { overflow-x: auto; }
.scroll:focus-visible { outline: 2px solid var(--text); outline-offset: 2px; }
ol.advice { list-style: none; padding: 0; }
ol.advice li { padding: .6rem 0; border-bottom: 1px solid var(--line); }
.missed { display: grid; gap: .75rem;
  grid-template-columns: repeat(auto-fill, minmax(13rem, 1fr)); }
figure { margin: 0; } figure img { width: 100%; border-radius: .4rem; }
figcaption { font-size: .85rem; color: var(--quiet); overflow-wrap: anywhere; }
pre { background: var(--card); padding: .8rem 1rem; border-radius: .6rem;
  white-space: pre-wrap; overflow-wrap: anywhere; margin: .25rem 0 1rem; }
</style>
)";

std::string Escaped(absl::string_view text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

std::string DataUri(absl::string_view type, absl::string_view bytes) {
  return absl::StrCat("data:image/", type, ";base64,",
                      absl::Base64Escape(bytes));
}

// The beginning of what scrolls to the side where it is wider than a phone:
// then the arrow keys must come to it.
std::string Scroll(absl::string_view name) {
  return absl::StrCat(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" "
      "aria-label=\"",
      Escaped(name), "\">");
}

std::string Percent(double part, double whole) {
  if (whole == 0) return "-";
  return absl::StrFormat("%.0f %%", 100 * part / whole);
}

const char* ClassOf(Grade grade) {
  switch (grade) {
    case Grade::kGood:
      return "good";
    case Grade::kFair:
      return "fair";
    case Grade::kPoor:
      break;
  }
  return "poor";
}

std::string Tile(const std::string& value, const std::string& meaning) {
  return absl::StrCat("<div class=\"tile\"><b>", Escaped(value), "</b><span>",
                      Escaped(meaning), "</span></div>\n");
}

// Of the weakest kind of query, which the headline is of.
std::string Tiles(const LearnPage& page) {
  if (page.trials.empty()) return "";
  const HeldOutTrial* shown = &page.trials.front();
  for (const HeldOutTrial& trial : page.trials) {
    if (trial.right * shown->frames < shown->right * trial.frames) {
      shown = &trial;
    }
  }
  std::string tiles =
      Tile(Percent(shown->right, shown->frames),
           absl::StrCat("of new pictures placed within ", page.right_within,
                        ", with ", shown->queries));
  if (shown->median_translation_m && shown->median_rotation_deg) {
    absl::StrAppend(
        &tiles,
        Tile(LengthText(*shown->median_translation_m, page.units_are_metres),
             absl::StrFormat("and %.2f degrees: half of the answers are better",
                             *shown->median_rotation_deg)));
  }
  absl::StrAppend(&tiles,
                  Tile(absl::StrCat(shown->wrong),
                       absl::StrCat("wrong among ", shown->answered,
                                    " answers that said they were sure")));
  if (page.coverage) {
    absl::StrAppend(
        &tiles, Tile(absl::StrFormat("%.0f %%",
                                     100 * page.coverage->summary.good_share),
                     absl::StrFormat("of the views from %.0f square metres "
                                     "will be answered (predicted)",
                                     page.coverage->summary.open_m2)));
  }
  return absl::StrCat("<div class=\"tiles\">\n", tiles, "</div>\n");
}

std::string HowGood(const LearnPage& page, const Verdict& verdict) {
  std::string html = "<h2>How good it will be</h2>\n";
  for (const std::string& sentence : verdict.sentences) {
    absl::StrAppend(&html, "<p>", Escaped(sentence), "</p>\n");
  }
  if (page.foreign_pictures > 0) {
    absl::StrAppendFormat(
        &html,
        "<p>%d queries were of nothing at all (blank walls, noise, darkness): "
        "%d of them %s answered%s.</p>\n",
        page.foreign_pictures, page.foreign_answered,
        page.foreign_answered == 1 ? "was" : "were",
        page.foreign_answered == 0 ? ", as it should be" : "");
  }
  absl::StrAppend(
      &html, Scroll("How good it will be"),
      "<table><thead><tr><th>Queries</th>"
      "<th class=\"number\">Pictures</th><th class=\"number\">Answered</th>"
      "<th class=\"number\">Right</th><th class=\"number\">Wrong</th>"
      "<th class=\"number\">Half within</th>"
      "<th class=\"number\">Nine of ten within</th>"
      "<th class=\"number\">Processor time</th></tr></thead><tbody>\n");
  for (const HeldOutTrial& t : page.trials) {
    const auto length = [&](const std::optional<double>& value) {
      return value ? LengthText(*value, page.units_are_metres) : "-";
    };
    absl::StrAppend(
        &html, "<tr><td>", Escaped(t.queries), "</td><td class=\"number\">",
        t.frames, "</td><td class=\"number\">", Percent(t.answered, t.frames),
        "</td><td class=\"number\">", Percent(t.right, t.frames),
        "</td><td class=\"number\">", t.wrong, "</td><td class=\"number\">",
        length(t.median_translation_m), "</td><td class=\"number\">",
        length(t.p90_translation_m), "</td><td class=\"number\">",
        t.cpu_ms ? absl::StrFormat("%.0f ms", *t.cpu_ms) : "-", "</td></tr>\n");
  }
  absl::StrAppend(
      &html, "</tbody></table></div>\n<p class=\"quiet\">Right: within ",
      Escaped(page.right_within),
      " of where the recording says the camera was. Wrong: not right, though "
      "its confidence was 0.5 or more. The pictures are of the same recording, "
      "from stretches that were not learnt for this test: another day, another "
      "light or moved things can be harder.</p>\n");
  return html;
}

std::string WhereItWorks(const LearnPage& page) {
  std::string html = "<h2>Where it will work</h2>\n";
  if (!page.coverage) {
    absl::StrAppend(&html, "<p>", Escaped(page.no_coverage_because), "</p>\n");
    return html;
  }
  const keyframes::CoverageSummary& s = page.coverage->summary;
  absl::StrAppendFormat(
      &html,
      "<p>The plan is seen from above. Of %.1f square metres that are open, "
      "%.0f %% answer for some direction, %.0f %% for all. Bright places "
      "answer in most directions, dark ones in few (the ticks show which), "
      "grey ones in none.</p>\n",
      s.open_m2, 100 * s.any_heading_share, 100 * s.all_headings_share);
  absl::StrAppend(&html, "<img class=\"plan\" src=\"",
                  DataUri("png", page.coverage->png),
                  "\" alt=\"Plan of the place with the share of directions "
                  "that will be answered\">\n");
  if (page.missed > 0) {
    absl::StrAppend(&html,
                    "<p class=\"quiet\">Crosses: where held-out pictures were "
                    "not answered rightly.</p>\n");
  }
  return html;
}

std::string WhereToRecord(const LearnPage& page) {
  const std::vector<std::string> advice = AdviceOf(page);
  std::string html = "<h2>Where to record more</h2>\n";
  if (advice.empty()) {
    absl::StrAppend(&html, "<p>",
                    page.coverage
                        ? "Nowhere in particular: no place of any size lacks "
                          "more than four directions in ten."
                        : "See the pictures below, if there are any.",
                    "</p>\n");
    return html;
  }
  absl::StrAppend(&html, "<ol class=\"advice\">\n");
  for (const std::string& line : advice) {
    absl::StrAppend(&html, "<li>", Escaped(line), "</li>\n");
  }
  absl::StrAppend(&html, "</ol>\n");
  return html;
}

std::string Missed(const LearnPage& page) {
  if (page.missed_pictures.empty()) return "";
  std::string html = absl::StrFormat(
      "<h2>What it did not recognise</h2>\n<p>%d of %d held-out pictures; "
      "these "
      "are some. Bare walls, blur and views that nothing else in the recording "
      "shows are hard.</p>\n<div class=\"missed\">\n",
      page.missed, page.trials.empty() ? 0 : page.trials.front().frames);
  for (const MissedPicture& picture : page.missed_pictures) {
    absl::StrAppend(&html, "<figure><img src=\"", DataUri("jpeg", picture.jpeg),
                    "\" alt=\"Held-out picture ", Escaped(picture.stem),
                    "\"><figcaption>", Escaped(picture.stem), ": ",
                    Escaped(picture.why), "</figcaption></figure>\n");
  }
  return html + "</div>\n";
}

std::string HowItWasMade(const LearnPage& page) {
  double total_s = 0;
  std::string html = absl::StrCat(
      "<h2>How it was made</h2>\n", Scroll("How it was made"),
      "<table><thead><tr><th>Step</th><th>Result</th><th class=\"number\">Time"
      "</th></tr></thead><tbody>\n");
  for (const LearnStep& step : page.steps) {
    total_s += step.seconds;
    absl::StrAppend(&html, "<tr><td>", Escaped(step.name), "</td><td>",
                    Escaped(step.result), "</td><td class=\"number\">",
                    absl::StrFormat("%.1f s", step.seconds), "</td></tr>\n");
  }
  absl::StrAppend(&html, "<tr><td>In all</td><td></td><td class=\"number\">",
                  absl::StrFormat("%.1f s", total_s),
                  "</td></tr>\n</tbody></table></div>\n");
  if (!page.notes.empty()) {
    absl::StrAppend(&html, "<ul>\n");
    for (const std::string& note : page.notes) {
      absl::StrAppend(&html, "<li>", Escaped(note), "</li>\n");
    }
    absl::StrAppend(&html, "</ul>\n");
  }
  return html;
}

std::string Next(const LearnPage& page) {
  std::string html = "<h2>What to do next</h2>\n";
  for (const auto& [heading, command] : page.commands) {
    absl::StrAppend(&html, "<p>", Escaped(heading), "</p>\n<pre>",
                    Escaped(command), "</pre>\n");
  }
  return html;
}

}  // namespace

std::vector<std::string> AdviceOf(const LearnPage& page) {
  std::vector<std::string> advice;
  if (!page.coverage) return advice;
  for (const WeakSpot& spot : page.coverage->weak_spots) {
    const char letter = static_cast<char>('A' + advice.size());
    const std::string where =
        spot.towards_rad ? absl::StrCat("stand there and look towards ",
                                        DirectionOnPlan(*spot.towards_rad))
                         : "stand there and turn round once, slowly";
    advice.push_back(absl::StrFormat(
        "%c: %s. Of the views from within %.1f m, %.0f %% are missing.", letter,
        where, spot.radius_m, 100 * spot.missing_share));
  }
  return advice;
}

std::string LearnPageHtml(const LearnPage& page) {
  const Verdict verdict = Judge(page.trials, page.units_are_metres);
  std::string html = absl::StrCat(
      kHead, "<title>", Escaped(page.scene),
      ": how good it will be</title>\n</head>\n<body>\n<main>\n<h1>",
      Escaped(page.scene), "</h1>\n<p class=\"headline ",
      ClassOf(verdict.grade), "\">", Escaped(verdict.headline), "</p>\n",
      Tiles(page), HowGood(page, verdict), WhereItWorks(page),
      WhereToRecord(page), Missed(page), Next(page), HowItWasMade(page));
  absl::StrAppend(&html, "<p class=\"quiet\">Learnt from ",
                  Escaped(page.source), ", ", Escaped(page.made_utc), ", ",
                  Escaped(page.software), "</p>\n</main>\n</body>\n</html>\n");
  return html;
}

}  // namespace treeline::learning
