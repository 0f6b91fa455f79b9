// Where bytes of a request come from.
#ifndef COMMON_HTTP_BYTE_SOURCE_H_
#define COMMON_HTTP_BYTE_SOURCE_H_

#include <sys/types.h>

#include <cstddef>

namespace treeline::http {

// A connection, or a test.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  // Waits for at least one byte; 0: there are no more; -1: failed.
  virtual ssize_t Read(char* to, size_t size) = 0;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_BYTE_SOURCE_H_
