// multipart/form-data (RFC 7578, RFC 2046 5.1): what a page's form and `curl
// -F` send.
#ifndef SERVER_GATEWAY_FORM_DATA_H_
#define SERVER_GATEWAY_FORM_DATA_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::gateway {

struct FormPart {
  std::string name;
  // Views into the body.
  absl::string_view bytes;
};

// The parts of `body` in their order. `content_type` is that of the request,
// with its parameter `boundary`. Allocates no more than names of at most 100
// bytes of 32 parts. INVALID_ARGUMENT (INVALID_REQUEST): no such body, more
// parts, a part without a name.
absl::StatusOr<std::vector<FormPart>> ParseFormData(
    absl::string_view content_type, absl::string_view body);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_FORM_DATA_H_
