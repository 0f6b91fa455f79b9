// Why a scene does not answer, as the one who asked should see it.
#ifndef SERVER_REPOSITORY_LOAD_FAILURE_H_
#define SERVER_REPOSITORY_LOAD_FAILURE_H_

#include <chrono>
#include <string>

#include "absl/status/status.h"

namespace treeline::repository {

// Reasons of the repository's errors; stable
// (docs/reference/scene-repository.md).
inline constexpr char kSceneNameInvalid[] = "SCENE_NAME_INVALID";
inline constexpr char kSceneNotFound[] = "SCENE_NOT_FOUND";
inline constexpr char kVersionNotFound[] = "VERSION_NOT_FOUND";
inline constexpr char kModelCorrupt[] = "MODEL_CORRUPT";
inline constexpr char kModelTooNew[] = "MODEL_TOO_NEW";
inline constexpr char kMemoryBudget[] = "MEMORY_BUDGET";
inline constexpr char kSceneLoadFailed[] = "SCENE_LOAD_FAILED";
inline constexpr char kSceneNotLoaded[] = "SCENE_NOT_LOADED";

// INVALID_ARGUMENT, SCENE_NAME_INVALID unless both are names (see names.h); an
// empty version is allowed.
absl::Status CheckSceneAndVersion(const std::string& scene,
                                  const std::string& version);
// NOT_FOUND.
absl::Status NoScene(const std::string& scene);
absl::Status NoVersion(const std::string& scene, const std::string& version);
// UNAVAILABLE, SCENE_NOT_LOADED: the repository stops.
absl::Status Stopping(const std::string& scene);
// RESOURCE_EXHAUSTED, MEMORY_BUDGET.
absl::Status LargerThanBudget(uint64_t bytes, uint64_t budget_bytes);

// Whether the same file may well be loaded later: it could not be had, or
// memory was short. Everything else needs another file.
bool IsTransient(const absl::Status& failure);

// The error of a query for a version that could not be loaded:
//   DATA_LOSS            MODEL_CORRUPT
//   FAILED_PRECONDITION  MODEL_TOO_NEW, SCENE_LOAD_FAILED
//   RESOURCE_EXHAUSTED   MEMORY_BUDGET
//   UNAVAILABLE          SCENE_LOAD_FAILED, with `retry_after`, if IsTransient
// A reason that `failure` has already stays.
absl::Status LoadError(const std::string& scene, const std::string& version,
                       const absl::Status& failure,
                       std::chrono::milliseconds retry_after);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_LOAD_FAILURE_H_
