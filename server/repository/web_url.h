// Addresses of web servers, with what must not be shown taken out.
#ifndef SERVER_REPOSITORY_WEB_URL_H_
#define SERVER_REPOSITORY_WEB_URL_H_

#include <string>

#include "absl/status/statusor.h"

namespace treeline::repository {

// `reference`, absolute or relative to `base`, as an absolute http or https
// address without fragment (RFC 3986). base "": reference must be absolute.
// INVALID_ARGUMENT repeats neither.
absl::StatusOr<std::string> ResolveUrl(const std::string& base,
                                       const std::string& reference);

// scheme://host:port/path, for logs and messages: the query may hold a
// signature, and the user information a password. "(an address)" where it is
// none.
std::string PublicUrl(const std::string& url);

// INVALID_ARGUMENT: plain http to another machine than this one, unless
// allowed.
absl::Status CheckTransport(const std::string& url, bool allow_plain_http);

bool IsHttps(const std::string& url);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_WEB_URL_H_
