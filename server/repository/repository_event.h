// What happens to scenes, for the log.
#ifndef SERVER_REPOSITORY_REPOSITORY_EVENT_H_
#define SERVER_REPOSITORY_REPOSITORY_EVENT_H_

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::repository {

struct RepositoryEvent {
  enum class Kind {
    kLoaded,      // with bytes and seconds
    kLoadFailed,  // with status
    kTookOver,    // the version that queries without one get from now on
    kEvicted,     // let go for another; with bytes
    kUnloaded,    // let go because somebody asked for it; with bytes
    // The file of a version in memory was written over rather than replaced by
    // another. What is in memory serves on until the file is found to be good;
    // but who reads it halfway gets DATA_LOSS, so say it to who publishes.
    kOverwritten,
    kBadMetadata,  // scene.json, with status; no version
  };

  Kind kind = Kind::kLoaded;
  std::string scene = {};
  std::string version = {};
  absl::Status status = {};
  uint64_t bytes = 0;
  double seconds = 0;
};

// "LOADED" and so on.
absl::string_view EventName(RepositoryEvent::Kind kind);

using RepositoryEventHandler = std::function<void(const RepositoryEvent&)>;

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_REPOSITORY_EVENT_H_
