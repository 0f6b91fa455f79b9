// The AR page of client/web, below /ar/.
#ifndef SERVER_GATEWAY_AR_PAGE_H_
#define SERVER_GATEWAY_AR_PAGE_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/http/http_message.h"
#include "common/http/static_files.h"

namespace treeline::gateway {

// Its files are the same for everyone and need no token; what the page asks of
// the server does. Thread-safe.
class ArPage {
 public:
  // Whether `path` is the page's, there or not: /ar and all below it.
  static bool Owns(absl::string_view path);

  // `folder`: as scripts/build-ar-page makes it.
  explicit ArPage(std::string folder) : files_(std::move(folder)) {}

  // Of GET and HEAD. 308 leads from /ar to /ar/; 404: no such file. Says how
  // long it may be kept.
  http::HttpResponse Handle(const http::HttpRequest& request) const;

  // What the page may do in its browser: nothing of other hosts, and the
  // camera.
  static std::vector<std::pair<std::string, std::string>> Headers();

 private:
  const http::StaticFiles files_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_AR_PAGE_H_
