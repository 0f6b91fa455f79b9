// The files of a page that a program serves.
#ifndef COMMON_HTTP_STATIC_FILES_H_
#define COMMON_HTTP_STATIC_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::http {

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

// Where a page lies: in ../share/treeline/NAME beside the program, where it was
// installed, else in `built_folder`, of the sources that the program was built
// from; empty: in neither.
std::string FindPageFolder(const std::string& name,
                           const std::string& built_folder);

}  // namespace treeline::http

#endif  // COMMON_HTTP_STATIC_FILES_H_
