// One small GET.
#ifndef CLIENT_SCRAPE_HTTP_GET_H_
#define CLIENT_SCRAPE_HTTP_GET_H_

#include <chrono>
#include <string>

#include "absl/status/statusor.h"

namespace treeline::scrape {

struct HttpGetOptions {
  // As ClientTlsOptions: PEM files, empty for none.
  std::string ca_file = {};
  std::string certificate_file = {};
  std::string key_file = {};
  std::string bearer_token = {};  // empty: none
  std::chrono::milliseconds timeout = std::chrono::seconds(2);
};

// The body of the answer, at most 8 MiB; redirects are not followed, and a
// token in the clear passes no proxy.
// UNAVAILABLE: no answer in time; otherwise the status code's own error
// (UNAUTHENTICATED for 401, PERMISSION_DENIED for 403, NOT_FOUND for 404,
// UNKNOWN for others). Every error names the address. Thread-safe.
absl::StatusOr<std::string> HttpGet(const std::string& url,
                                    const HttpGetOptions& options);

}  // namespace treeline::scrape

#endif  // CLIENT_SCRAPE_HTTP_GET_H_
