// The body of POST /localize as arbitrary bytes behind a line with its
// content-type: no crash, and nothing that was not in the body.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "absl/strings/string_view.h"
#include "common/http/http_message.h"
#include "server/gateway/form_data.h"
#include "server/gateway/picture_query.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  namespace gateway = treeline::gateway;
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const size_t line = bytes.find('\n');
  if (line == absl::string_view::npos) return 0;
  const std::string type(bytes.substr(0, line));
  treeline::http::HttpRequest http;
  http.headers["content-type"] = type;
  http.body = std::string(bytes.substr(line + 1));
  const auto parts = gateway::ParseFormData(type, http.body);
  if (parts.ok()) {
    size_t total = 0;
    for (const gateway::FormPart& part : *parts) {
      total += part.name.size() + part.bytes.size();
    }
    if (total > http.body.size()) std::abort();
  }
  const auto query = gateway::ParsePictureQuery(http);
  if (!query.ok() && !absl::IsInvalidArgument(query.status())) std::abort();
  if (query.ok() && query->frame().color().encoded().empty()) std::abort();
  return 0;
}
