// What became of the latest queries, for whoever looks at a scene.
#ifndef SERVER_SERVICE_RECENT_QUERIES_H_
#define SERVER_SERVICE_RECENT_QUERIES_H_

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/service/call_observer.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::service {

// Keeps the results of the newest queries in memory: no pictures, nothing of
// who asked, and nothing of what came by the GeoPose Protocol, which promises
// that. Thread-safe.
class RecentQueries final : public CallObserver {
 public:
  using WallClock = std::function<std::chrono::system_clock::time_point()>;

  // The newest `capacity`, of all scenes together.
  RecentQueries(size_t capacity, WallClock wall_clock)
      : capacity_(capacity), wall_clock_(std::move(wall_clock)) {}

  // Queries that a version of a scene has looked at, or was to.
  void OnCall(const CallRecord& record) override;

  // Of one scene, the newest first.
  v1::ListRecentQueriesResponse Of(absl::string_view scene) const;

 private:
  struct Entry {
    std::string scene;
    v1::RecentQuery query;
  };

  const size_t capacity_;
  const WallClock wall_clock_;
  mutable absl::Mutex mutex_;
  // The newest in front.
  std::deque<Entry> entries_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_RECENT_QUERIES_H_
