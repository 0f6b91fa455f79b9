#include "server/repository/load_failure.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/repository/names.h"

namespace treeline::repository {
namespace {

// The code and the reason of a query that failed for `failure`.
struct Verdict {
  absl::StatusCode code;
  const char* reason;
};

Verdict Judge(const absl::Status& failure) {
  if (base::ErrorInfoOf(failure).reason == kMemoryBudget) {
    return {absl::StatusCode::kResourceExhausted, kMemoryBudget};
  }
  if (absl::IsDataLoss(failure)) {
    return {absl::StatusCode::kDataLoss, kModelCorrupt};
  }
  if (absl::IsUnimplemented(failure)) {
    // UNIMPLEMENTED would tell a client that the server lacks the method.
    return {absl::StatusCode::kFailedPrecondition, kModelTooNew};
  }
  if (IsTransient(failure)) {
    return {absl::StatusCode::kUnavailable, kSceneLoadFailed};
  }
  return {absl::StatusCode::kFailedPrecondition, kSceneLoadFailed};
}

}  // namespace

absl::Status CheckSceneAndVersion(const std::string& scene,
                                  const std::string& version) {
  absl::Status status = CheckName("scene", scene);
  if (status.ok() && !version.empty()) {
    status = CheckName("model_version", version);
  }
  return base::WithReason(status, kSceneNameInvalid);
}

absl::Status NoScene(const std::string& scene) {
  return base::WithReason(
      absl::NotFoundError(absl::StrCat("no scene '", scene, "'")),
      kSceneNotFound, {{"scene", scene}});
}

absl::Status NoVersion(const std::string& scene, const std::string& version) {
  return base::WithReason(
      absl::NotFoundError(
          absl::StrCat("scene '", scene, "' has no version '", version, "'")),
      kVersionNotFound, {{"scene", scene}, {"version", version}});
}

absl::Status Stopping(const std::string& scene) {
  return base::WithReason(
      absl::UnavailableError(absl::StrCat(
          "scene '", scene, "' is not loaded, and the server is stopping")),
      kSceneNotLoaded, {{"scene", scene}});
}

absl::Status LargerThanBudget(uint64_t bytes, uint64_t budget_bytes) {
  return base::WithReason(absl::ResourceExhaustedError(absl::StrCat(
                              "the model has ", bytes,
                              " bytes; the memory budget is ", budget_bytes)),
                          kMemoryBudget);
}

bool IsTransient(const absl::Status& failure) {
  switch (failure.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kNotFound:
      return true;
    case absl::StatusCode::kResourceExhausted:
      return base::ErrorInfoOf(failure).reason != kMemoryBudget;
    default:
      return false;
  }
}

absl::Status LoadError(const std::string& scene, const std::string& version,
                       const absl::Status& failure,
                       std::chrono::milliseconds retry_after) {
  const Verdict verdict = Judge(failure);
  const std::string reason = base::ErrorInfoOf(failure).reason;
  const absl::Status status = base::WithReason(
      absl::Status(verdict.code,
                   absl::StrCat("scene '", scene, "' version '", version,
                                "' could not be loaded: ", failure.message())),
      reason.empty() ? verdict.reason : reason,
      {{"scene", scene}, {"version", version}});
  return IsTransient(failure) ? base::WithRetryAfter(status, retry_after)
                              : status;
}

}  // namespace treeline::repository
