#include "nav_agent/service/route_keeper.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "nav_agent/routes/route_file.h"

namespace treeline::agent_service {
namespace {

// A route of 100 waypoints, and 100 that were missed.
constexpr uint64_t kMaxBytes = 1u << 20;

}  // namespace

RouteKeeper::RouteKeeper(const std::string& folder)
    : path_(folder.empty() ? "" : folder + "/route-progress") {
  if (!path_.empty()) thread_ = std::jthread([this] { Write(); });
}

RouteKeeper::~RouteKeeper() {
  const absl::MutexLock lock(&mutex_);
  is_ending_ = true;
}

absl::StatusOr<std::optional<routes::RouteProgress>> RouteKeeper::Load() const {
  if (path_.empty()) return std::nullopt;
  const absl::StatusOr<std::string> text = base::ReadFile(path_, kMaxBytes);
  if (absl::IsNotFound(text.status())) return std::nullopt;
  if (!text.ok()) return text.status();
  auto read = routes::ParseProgressFile(*text);
  if (read.ok()) return read;
  return absl::DataLossError(
      absl::StrCat(path_, ": ", read.status().message()));
}

void RouteKeeper::Keep(std::optional<routes::RouteProgress> progress) {
  const absl::MutexLock lock(&mutex_);
  waiting_ = std::move(progress);
  is_waiting_ = !path_.empty();
}

absl::Status RouteKeeper::keeping() const {
  if (path_.empty()) {
    return absl::FailedPreconditionError(
        "a restart forgets the route: the agent runs without --state-dir");
  }
  const absl::MutexLock lock(&mutex_);
  return written_;
}

void RouteKeeper::Write() {
  for (;;) {
    std::optional<routes::RouteProgress> progress;
    {
      const absl::MutexLock lock(&mutex_);
      const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return is_waiting_ || is_ending_;
      };
      mutex_.Await(absl::Condition(&has_work));
      if (!is_waiting_) return;
      progress = std::exchange(waiting_, std::nullopt);
      is_waiting_ = false;
    }
    absl::Status written =
        base::WriteFileAtomically(path_, routes::ProgressFileText(progress));
    const absl::MutexLock lock(&mutex_);
    written_ = std::move(written);
  }
}

}  // namespace treeline::agent_service
