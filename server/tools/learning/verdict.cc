#include "server/tools/learning/verdict.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::learning {
namespace {

// Shares of held-out pictures that are answered rightly. A camera that streams
// asks again: at 60 % it is found within three pictures nine times of ten, at
// 90 % in the first.
constexpr double kGoodShare = 0.9;
constexpr double kFairShare = 0.6;
// More wrong answers among those relied on, and the good ones are of little
// use.
constexpr double kMaxWrongShare = 0.05;
// Of fewer pictures, shares are known to 20 percentage points at best.
constexpr int kFewFrames = 25;

double Share(int part, int whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / whole;
}

const char* Headline(Grade grade) {
  switch (grade) {
    case Grade::kGood:
      return "It will work well where it was recorded.";
    case Grade::kFair:
      return "It will work, with gaps.";
    case Grade::kPoor:
      break;
  }
  return "Record more before you rely on it.";
}

std::string TrialText(const HeldOutTrial& trial, bool units_are_metres) {
  std::string text = absl::StrFormat(
      "Of %d held-out pictures, asked about with %s, %d were answered (%.0f "
      "%%), %d of them rightly (%.0f %% of all).",
      trial.frames, trial.queries, trial.answered,
      100 * Share(trial.answered, trial.frames), trial.right,
      100 * Share(trial.right, trial.frames));
  if (trial.median_translation_m && trial.median_rotation_deg) {
    absl::StrAppendFormat(
        &text, " Half of the answers are within %s and %.2f degrees.",
        LengthText(*trial.median_translation_m, units_are_metres),
        *trial.median_rotation_deg);
  }
  if (trial.wrong > 0) {
    absl::StrAppendFormat(&text,
                          " %d %s wrong, though the confidence said otherwise.",
                          trial.wrong, trial.wrong == 1 ? "was" : "were");
  }
  return text;
}

}  // namespace

Grade GradeOf(const HeldOutTrial& trial) {
  const double right = Share(trial.right, trial.frames);
  const bool is_trusty = Share(trial.wrong, trial.answered) <= kMaxWrongShare;
  if (right >= kGoodShare && is_trusty) return Grade::kGood;
  return right >= kFairShare ? Grade::kFair : Grade::kPoor;
}

Verdict Judge(const std::vector<HeldOutTrial>& trials, bool units_are_metres) {
  Verdict verdict{.grade = trials.empty() ? Grade::kPoor : Grade::kGood,
                  .headline = {},
                  .sentences = {}};
  int frames = 0;
  for (const HeldOutTrial& trial : trials) {
    verdict.grade = std::max(verdict.grade, GradeOf(trial));
    frames = std::max(frames, trial.frames);
    verdict.sentences.push_back(TrialText(trial, units_are_metres));
  }
  verdict.headline = Headline(verdict.grade);
  if (frames == 0) {
    verdict.sentences = {
        "No picture was held out, so nothing was measured: record more."};
  } else if (frames < kFewFrames) {
    verdict.sentences.push_back(absl::StrFormat(
        "%d pictures are few: take these figures as a hint.", frames));
  }
  return verdict;
}

std::string LengthText(double length_m, bool units_are_metres) {
  if (!units_are_metres) return absl::StrFormat("%.3g units", length_m);
  if (length_m >= 1) return absl::StrFormat("%.1f m", length_m);
  return absl::StrFormat("%.1f cm", 100 * length_m);
}

}  // namespace treeline::learning
