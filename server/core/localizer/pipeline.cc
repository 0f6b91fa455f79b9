#include "server/core/localizer/pipeline.h"

#include <utility>

#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/report.h"

namespace treeline::localizer {
namespace {

// The candidates that were proposed, and the best of those verified.
class Search {
 public:
  Search(const PoseVerifier& verifier, Query& query)
      : verifier_(verifier), query_(query) {}

  absl::Status Ask(const CandidateGenerator& generator) {
    TL_RETURN_IF_ERROR(query_.CheckStop());
    TL_ASSIGN_OR_RETURN(Candidate candidate,
                        generator.Propose(query_, candidates_));
    candidates_.push_back(std::move(candidate));
    return absl::OkStatus();
  }

  // Candidates without a pose are passed over.
  void Verify(size_t i) {
    if (!candidates_[i].pose) return;
    const Verdict verdict = verifier_.Verify(query_, candidates_[i]);
    if (verdict_ && !IsBetter(verdict, *verdict_)) return;
    verdict_ = verdict;
    best_ = i;
  }

  size_t asked() const { return candidates_.size(); }
  bool has_verdict() const { return verdict_.has_value(); }
  bool IsSatisfied(double sufficient_confidence) const {
    return verdict_ && verdict_->confidence >= sufficient_confidence;
  }
  Selection Take() && {
    if (!verdict_) best_ = MostTelling();
    return {std::move(candidates_[best_]), verdict_};
  }

 private:
  // The first that had enough to look at; else the first.
  size_t MostTelling() const {
    for (size_t i = 0; i < candidates_.size(); ++i) {
      if (candidates_[i].reason != NotLocalizedReason::kTooFewSamples) return i;
    }
    return 0;
  }

  const PoseVerifier& verifier_;
  Query& query_;
  std::vector<Candidate> candidates_;
  size_t best_ = 0;
  std::optional<Verdict> verdict_;
};

}  // namespace

absl::StatusOr<Selection> SelectCandidate(const Method& method, Query& query) {
  Search search(*method.verifier, query);
  for (const Step& step : method.steps) {
    TL_RETURN_IF_ERROR(search.Ask(*step.generator));
    if (step.is_fallback) continue;
    search.Verify(search.asked() - 1);
    if (search.IsSatisfied(method.sufficient_confidence)) break;
  }
  if (!search.has_verdict()) {
    for (size_t i = 0; i < search.asked(); ++i) search.Verify(i);
  }
  return std::move(search).Take();
}

Pipeline::Pipeline(std::unique_ptr<const forest::ModelFile> model,
                   Method method)
    : model_(std::move(model)), method_(std::move(method)) {}

absl::StatusOr<PoseEstimate> Pipeline::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  const camera::RgbdCalibration calibration =
      QueryCalibration(frame, info(), method_.depth_use);
  TL_RETURN_IF_ERROR(
      CheckFrame(frame, calibration, method_.depth_use, info().method));
  Pool<QueryScratch>::Lease scratch(scratch_);
  Query query(frame, calibration, method_.depth_use, options, *scratch);
  TL_ASSIGN_OR_RETURN(Selection selection, SelectCandidate(method_, query));
  PoseEstimate estimate =
      Report(std::move(selection.candidate),
             selection.verdict ? &*selection.verdict : nullptr);
  estimate.timings = query.timings();
  SetTotal(base::MillisecondsBetween(start, clock.Now()), estimate.timings);
  return estimate;
}

}  // namespace treeline::localizer
