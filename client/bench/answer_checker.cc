#include "client/bench/answer_checker.h"

#include "absl/strings/str_cat.h"
#include "common/wire/geometry.h"

namespace treeline::bench {

AnswerChecker::AnswerChecker(
    std::vector<std::optional<geometry::Rigid3>> truths,
    const Tolerance& tolerance)
    : truths_(std::move(truths)), tolerance_(tolerance) {}

void AnswerChecker::LoadBegins() {
  absl::MutexLock lock(&mutex_);
  load_ = true;
}

AnswerChecker::Verdict AnswerChecker::Check(
    size_t query, const v1::LocalizeResponse& response) {
  Verdict verdict;
  const bool localized = response.outcome() == v1::OUTCOME_LOCALIZED;
  if (const std::optional<geometry::Rigid3>& truth = truths_[query]) {
    const absl::StatusOr<geometry::Rigid3> pose =
        wire::FromProto(response.world_from_camera(), "world_from_camera");
    verdict.within_tolerance = false;
    if (localized && pose.ok()) {
      const geometry::PoseError error = geometry::ErrorBetween(*pose, *truth);
      verdict.within_tolerance = error.translation_m <= tolerance_.position_m &&
                                 error.rotation_rad <= tolerance_.rotation_rad;
    }
    verdict.wrong_pose = localized && !*verdict.within_tolerance;
  }

  v1::LocalizeResponse timeless = response;
  timeless.clear_timings();
  std::string bytes = timeless.SerializeAsString();
  const std::string model =
      absl::StrCat(response.scene(), "/", response.model_version());
  absl::MutexLock lock(&mutex_);
  const auto [at, is_new] = references_.try_emplace({query, model});
  Reference& reference = at->second;
  if (is_new) {
    reference = {.bytes = std::move(bytes), .before_load = !load_};
  } else if (reference.bytes != bytes) {
    verdict.bits = Bits::kDifferent;
  } else {
    verdict.bits =
        reference.before_load ? Bits::kAsBeforeLoad : Bits::kAsFirstUnderLoad;
  }
  return verdict;
}

}  // namespace treeline::bench
