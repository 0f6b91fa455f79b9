#include "server/app/watched_folder.h"

#include <utility>
#include <vector>

namespace treeline::server_app {
namespace {

constexpr size_t kMostNamed = 100;

}  // namespace

WatchedFolder::WatchedFolder(std::string root,
                             std::function<void(const std::string& path)> tell)
    : root_(std::move(root)), tell_(std::move(tell)), folder_(root_) {}

absl::StatusOr<repository::SourceListing> WatchedFolder::List() {
  std::vector<std::string> news;
  {
    std::vector<std::string> found =
        repository::MisplacedModels(root_, kMostNamed);
    absl::MutexLock lock(&mutex_);
    for (const std::string& path : found) {
      if (!told_.contains(path)) news.push_back(path);
    }
    // What went may come again, and is told again.
    told_ = {found.begin(), found.end()};
  }
  for (const std::string& path : news) tell_(path);
  return folder_.List();
}

absl::StatusOr<std::string> WatchedFolder::LocalPath(
    const repository::ModelRef& model) {
  return folder_.LocalPath(model);
}

absl::StatusOr<std::string> WatchedFolder::Fetch(
    const repository::ModelRef& model, const std::stop_token& stop) {
  return folder_.Fetch(model, stop);
}

}  // namespace treeline::server_app
