// libcurl's handles, closed by whoever owns them.
#ifndef COMMON_CURL_CURL_HANDLES_H_
#define COMMON_CURL_CURL_HANDLES_H_

#include <curl/curl.h>

#include <memory>
#include <string>

namespace treeline::curl {

struct EasyDeleter {
  void operator()(CURL* easy) const { curl_easy_cleanup(easy); }
};
using Easy = std::unique_ptr<CURL, EasyDeleter>;

struct MultiDeleter {
  void operator()(CURLM* multi) const { curl_multi_cleanup(multi); }
};
using Multi = std::unique_ptr<CURLM, MultiDeleter>;

struct HeadersDeleter {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using Headers = std::unique_ptr<curl_slist, HeadersDeleter>;

// "Name: value".
void AddHeader(Headers& headers, const std::string& line);

}  // namespace treeline::curl

#endif  // COMMON_CURL_CURL_HANDLES_H_
