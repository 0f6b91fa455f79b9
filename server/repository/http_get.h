// One GET of a file, with everything that can go wrong on the way told apart.
#ifndef SERVER_REPOSITORY_HTTP_GET_H_
#define SERVER_REPOSITORY_HTTP_GET_H_

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/clock.h"

namespace treeline::repository {

struct HttpOptions {
  // To reach the server and agree on keys.
  std::chrono::milliseconds connect_timeout{10000};
  // A transfer that brings less than 1 KiB/s over this long is given up.
  std::chrono::milliseconds stall_timeout{30000};
  int max_redirects = 5;
  // PEM file of the authorities to trust instead of the system's; empty: the
  // system's. Certificates are always verified.
  std::string ca_file = {};
  // http:// to other machines than this one.
  bool allow_plain_http = false;

  absl::Status Validate() const;
};

struct HttpGetRequest {
  // Absolute, http or https.
  std::string url;
  // Not empty: answer 304 without a body where it is still this one.
  std::string etag = {};
  // Not 0: only what follows these bytes.
  uint64_t offset = 0;
};

struct HttpGetResponse {
  // 200, 206 or 304.
  int status = 0;
  // Empty: none.
  std::string etag = {};
};

// What takes the body.
class HttpSink {
 public:
  virtual ~HttpSink() = default;
  // Before the first byte. offset: which byte of the file it is: that of the
  // request, or 0 where the server sends all.
  virtual absl::Status Begin(uint64_t offset) = 0;
  virtual absl::Status Write(absl::string_view bytes) = 0;
};

// Follows redirects, but none from https to http. Blocks; returns within
// 100 ms when stopped. Messages hold no query and no password. Of the reasons
// (common/base/error_info.h):
//   UNAVAILABLE          SOURCE_UNREACHABLE: no connection, it broke or
//                        stalled; 408, 429, 5xx, with the time to try again
//                        where the server gave one
//   OUT_OF_RANGE         RANGE_REFUSED: ask again from 0
//   NOT_FOUND            SOURCE_FILE_MISSING: 404, 410
//   PERMISSION_DENIED    SOURCE_REFUSED: 401, 403
//   FAILED_PRECONDITION  SOURCE_UNTRUSTED: its certificate, a redirect to
//                        http; SOURCE_REFUSED: any other answer
//   CANCELLED, and whatever the sink returns.
absl::StatusOr<HttpGetResponse> HttpGet(const HttpGetRequest& request,
                                        const HttpOptions& options,
                                        const base::Clock& clock,
                                        HttpSink& sink,
                                        const std::stop_token& stop);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_HTTP_GET_H_
