#include "server/gateway/ar_page.h"

#include "absl/strings/match.h"
#include "absl/strings/strip.h"

namespace treeline::gateway {
namespace {

constexpr absl::string_view kPath = "/ar";
// The names of these files change with what is in them.
constexpr absl::string_view kAssets = "/assets/";

}  // namespace

bool ArPage::Owns(absl::string_view path) {
  return absl::ConsumePrefix(&path, kPath) &&
         (path.empty() || path.front() == '/');
}

http::HttpResponse ArPage::Handle(const http::HttpRequest& request) const {
  absl::string_view path = request.path;
  absl::ConsumePrefix(&path, kPath);
  if (path.empty()) {
    // Relative: a proxy may have put the server below a path of its own.
    return {.status = 308,
            .headers = {{"Location", "ar/"}, {"Cache-Control", "no-cache"}}};
  }
  auto file = files_.Get(path);
  if (!file.ok()) {
    return {.status = 404,
            .content_type = "text/plain; charset=utf-8",
            .body = "there is no such file\n",
            .headers = {{"Cache-Control", "no-store"}}};
  }
  const bool is_asset = absl::StartsWith(path, kAssets);
  return {.content_type = file->content_type,
          .body = std::move(file->bytes),
          .headers = {
              {"Cache-Control",
               is_asset ? "public, max-age=31536000, immutable" : "no-cache"}}};
}

std::vector<std::pair<std::string, std::string>> ArPage::Headers() {
  return {
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; "
       "img-src 'self' blob:; connect-src 'self'; base-uri 'none'; "
       "form-action 'none'; frame-ancestors 'none'"},
      {"Permissions-Policy", "camera=(self), microphone=(), geolocation=()"},
      {"Referrer-Policy", "no-referrer"}};
}

}  // namespace treeline::gateway
