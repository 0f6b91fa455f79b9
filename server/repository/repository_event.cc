#include "server/repository/repository_event.h"

namespace treeline::repository {

absl::string_view EventName(RepositoryEvent::Kind kind) {
  switch (kind) {
    case RepositoryEvent::Kind::kLoaded:
      return "LOADED";
    case RepositoryEvent::Kind::kLoadFailed:
      return "LOAD_FAILED";
    case RepositoryEvent::Kind::kTookOver:
      return "TOOK_OVER";
    case RepositoryEvent::Kind::kEvicted:
      return "EVICTED";
    case RepositoryEvent::Kind::kUnloaded:
      return "UNLOADED";
    case RepositoryEvent::Kind::kOverwritten:
      return "OVERWRITTEN";
    case RepositoryEvent::Kind::kBadMetadata:
      return "BAD_METADATA";
  }
  return "UNKNOWN";
}

}  // namespace treeline::repository
