// For how long and how much a connection is listened to.
#ifndef COMMON_HTTP_STREAM_LIMITS_H_
#define COMMON_HTTP_STREAM_LIMITS_H_

#include <chrono>
#include <cstddef>

namespace treeline::http {

struct StreamLimits {
  // Request line and headers, bytes.
  size_t head_bytes = 16384;
  // From the first byte of a request to the end of its headers; and for the
  // whole TLS handshake.
  std::chrono::milliseconds head_timeout{10000};
  // From then to the end of its body.
  std::chrono::milliseconds body_timeout{60000};
  // What must have come of a body, on average, once it has been arriving for
  // `body_rate_grace`: else a client could hold a connection for the price of a
  // byte now and then.
  int min_body_bytes_per_s = 8192;
  std::chrono::milliseconds body_rate_grace{5000};
  // For the whole response.
  std::chrono::milliseconds write_timeout{30000};
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_STREAM_LIMITS_H_
