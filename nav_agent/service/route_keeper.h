// How far the robot is on its route, kept for a restart.
#ifndef NAV_AGENT_SERVICE_ROUTE_KEEPER_H_
#define NAV_AGENT_SERVICE_ROUTE_KEEPER_H_

#include <optional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/routes/route_progress.h"

namespace treeline::agent_service {

// Thread-safe. Writes in a thread of its own: no disk makes a control step
// wait.
class RouteKeeper {
 public:
  // `folder` is there; empty: nothing is kept. Its file is `route-progress`.
  explicit RouteKeeper(const std::string& folder);
  // What was told last is written before it ends.
  ~RouteKeeper();

  // What was kept; nullopt: nothing. An error names the file: it is not one, or
  // damaged, or cannot be read.
  absl::StatusOr<std::optional<routes::RouteProgress>> Load() const;

  // What a restart finds; nullopt: nothing. Returns at once; where several wait
  // the last one counts.
  void Keep(std::optional<routes::RouteProgress> progress);
  // Whether a restart finds what was told last, as far as that is written; and
  // if not, why.
  absl::Status keeping() const;

 private:
  void Write();

  const std::string path_;
  mutable absl::Mutex mutex_;
  bool is_waiting_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_ending_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<routes::RouteProgress> waiting_ ABSL_GUARDED_BY(mutex_);
  absl::Status written_ ABSL_GUARDED_BY(mutex_);
  std::jthread thread_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ROUTE_KEEPER_H_
