// The files of the operator's page.
#ifndef NAV_AGENT_SERVICE_STATIC_FILES_H_
#define NAV_AGENT_SERVICE_STATIC_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::agent_service {

struct StaticFile {
  std::string content_type;
  std::string bytes;
};

// Files below one folder, read when they are asked for. Thread-safe.
class StaticFiles {
 public:
  // An empty folder: there are none.
  explicit StaticFiles(std::string folder) : folder_(std::move(folder)) {}

  // The file of a URL's decoded path; "/" is /index.html. NOT_FOUND for what is
  // not there, and for whatever leads out of the folder, by "..", a backslash,
  // a zero or a link; RESOURCE_EXHAUSTED above 64 MiB.
  absl::StatusOr<StaticFile> Get(absl::string_view url_path) const;

  // Whether there is a page at all.
  bool HasPage() const;
  const std::string& folder() const { return folder_; }

 private:
  const std::string folder_;
};

// "text/html; charset=utf-8" of "index.html".
std::string ContentTypeOf(absl::string_view path);

// The first of the places where a page may be that has one; empty: none.
// ../share/treeline/page beside the program, and build/page of the sources that
// it was built from.
std::string DefaultPageFolder();

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_STATIC_FILES_H_
