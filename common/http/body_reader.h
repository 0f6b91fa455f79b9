// The body of a request, from a connection to a string: framing, gzip, limits.
#ifndef COMMON_HTTP_BODY_READER_H_
#define COMMON_HTTP_BODY_READER_H_

#include <chrono>
#include <cstddef>
#include <string>

#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/http/byte_source.h"
#include "common/http/inflater.h"
#include "common/http/request_head.h"

namespace treeline::http {

struct BodyOptions {
  // Of the body, as sent and as inflated.
  size_t max_bytes = 0;
  InflationLimit inflation = {};
  // For how long to wait until others have given back memory.
  std::chrono::milliseconds patience{2000};
};

// Chunks are read as RFC 9112, 7.1 writes them: sizes of 1 to 8 hexadecimal
// digits, CRLF. Extensions of chunks and trailers are passed over.
class BodyReader {
 public:
  // `lease` holds what the body takes, while it arrives too.
  BodyReader(ByteSource& source, const BodyOptions& options,
             base::ByteLease& lease)
      : source_(source), options_(options), lease_(lease) {}

  // 0: `body` is whole. Else the status to answer with: 400 the framing, or the
  // connection has ended; 413 it is larger than the limits; 503 there is no
  // memory left for it.
  int Read(const RequestHead& head, std::string& body);

 private:
  int ReadPlain(uint64_t bytes);
  int ReadChunked();
  // A line without its CRLF, of up to kLongestLine bytes.
  int ReadLine(std::string& line);
  // Bytes of the body as they came.
  int Take(absl::string_view bytes);
  // Bytes of the body as they are kept.
  int Keep(absl::string_view bytes);

  ByteSource& source_;
  const BodyOptions options_;
  base::ByteLease& lease_;
  std::string* body_ = nullptr;
  Inflater* inflater_ = nullptr;
  uint64_t raw_bytes_ = 0;
  // What the body may come to.
  size_t max_bytes_ = 0;
  bool is_size_known_ = false;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_BODY_READER_H_
