// A folder of models, and what somebody put there where it is not looked for.
#ifndef SERVER_APP_WATCHED_FOLDER_H_
#define SERVER_APP_WATCHED_FOLDER_H_

#include <functional>
#include <set>
#include <stop_token>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/repository/folder_source.h"

namespace treeline::server_app {

// As a FolderSource; each List() also tells of misplaced models
// (folder_source.h) that were not told of before. Thread-safe.
class WatchedFolder final : public repository::ModelSource {
 public:
  // `tell` gets paths relative to `root`, of at most a hundred models.
  WatchedFolder(std::string root,
                std::function<void(const std::string& path)> tell);

  absl::StatusOr<repository::SourceListing> List() override;
  absl::StatusOr<std::string> LocalPath(
      const repository::ModelRef& model) override;
  absl::StatusOr<std::string> Fetch(const repository::ModelRef& model,
                                    const std::stop_token& stop) override;

 private:
  const std::string root_;
  const std::function<void(const std::string& path)> tell_;
  repository::FolderSource folder_;
  absl::Mutex mutex_;
  std::set<std::string> told_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_WATCHED_FOLDER_H_
