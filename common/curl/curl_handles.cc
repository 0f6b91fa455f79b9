#include "common/curl/curl_handles.h"

namespace treeline::curl {

void AddHeader(Headers& headers, const std::string& line) {
  headers.reset(curl_slist_append(headers.release(), line.c_str()));
}

}  // namespace treeline::curl
