// What is kept of failed queries, for people to look at.
#ifndef SERVER_APP_FAILED_QUERY_FOLDER_H_
#define SERVER_APP_FAILED_QUERY_FOLDER_H_

#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/gateway/gateway.h"

namespace treeline::server_app {

// Reads the folder that a FailedQueryRecorder writes. Thread-safe.
class FailedQueryFolder {
 public:
  // Of a list.
  static constexpr size_t kMostListed = 200;

  explicit FailedQueryFolder(std::string folder) : folder_(std::move(folder)) {}

  // GatewayHooks::failed_queries:
  //   ""              JSON: {"queries": [{"name", "time_utc", "reason",
  //                   "scene", "status", "trace_id"}...]}, the newest first, at
  //                   most kMostListed; what is not known is left out
  //   "NAME"          the query's own .json
  //   "NAME/picture"  its colour image, as a JPEG or PNG file
  // NOT_FOUND: no such query, or none with a picture; no other file of the
  // folder, or of another, can be named.
  absl::StatusOr<gateway::Content> Get(absl::string_view path) const;

 private:
  absl::StatusOr<gateway::Content> List() const;
  absl::StatusOr<gateway::Content> Picture(const std::string& name) const;

  const std::string folder_;
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_FAILED_QUERY_FOLDER_H_
