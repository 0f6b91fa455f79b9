// Request line and headers of HTTP/1.1, read as RFC 9112 writes them and not
// otherwise: what a proxy may read in another way than we do is refused, for
// there the next request would begin in two places (request smuggling).
#ifndef COMMON_HTTP_REQUEST_HEAD_H_
#define COMMON_HTTP_REQUEST_HEAD_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::http {

struct RequestHead {
  // "POST".
  std::string method = {};
  // As it came, not decoded.
  std::string target = {};
  // Names in lower case, values without the blanks around them and not decoded.
  // Of a header that came twice, the first.
  std::map<std::string, std::string> headers = {};
  // Of the body; nullopt: no Content-Length.
  std::optional<uint64_t> content_length = std::nullopt;
  // Whether the body comes in chunks.
  bool is_chunked = false;

  bool has_body() const { return is_chunked || content_length.value_or(0) > 0; }
};

// Where a head that is still arriving ends.
class HeadScanner {
 public:
  enum class Verdict {
    kIncomplete,
    kComplete,
    // No head of ours, whatever follows: a line feed without its carriage
    // return, or NUL.
    kMalformed
  };

  // `bytes` are all of the head so far, and maybe what follows it; each call
  // brings the bytes of the last one again.
  Verdict Scan(absl::string_view bytes);
  // With kComplete: the size of the head, with the empty line.
  size_t end() const { return scanned_; }

 private:
  size_t scanned_ = 0;
  // Where the line at hand begins.
  size_t line_ = 0;
};

// Reads a whole head, with the empty line at its end. nullopt: it is to be
// refused with 400. That are, among others: line ends other than CRLF; control
// characters; a blank before a colon; a line that continues the one before it;
// a Content-Length that is not 1 to 18 digits; a Transfer-Encoding other than
// "chunked", or with a Content-Length, or in HTTP/1.0; two of any of the
// headers that say what the request is, or whose it is; more than 100 headers.
std::optional<RequestHead> ParseRequestHead(absl::string_view head);

}  // namespace treeline::http

#endif  // COMMON_HTTP_REQUEST_HEAD_H_
