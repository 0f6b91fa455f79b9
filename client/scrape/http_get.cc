#include "client/scrape/http_get.h"

#include <curl/curl.h>

#include <array>
#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/curl/curl_handles.h"

namespace treeline::scrape {
namespace {

constexpr size_t kMaxBytes = size_t{8} << 20;

size_t Take(const char* data, size_t size, size_t count, void* to) {
  auto* body = static_cast<std::string*>(to);
  if (body->size() + size * count > kMaxBytes) return 0;  // ends the transfer
  body->append(data, size * count);
  return size * count;
}

absl::Status ErrorOf(const std::string& url, long status) {
  const std::string message =
      absl::StrCat(url, " answered with HTTP status ", status);
  switch (status) {
    case 401:
      return absl::UnauthenticatedError(message + ": a token is needed");
    case 403:
      return absl::PermissionDeniedError(message);
    case 404:
      return absl::NotFoundError(message);
    default:
      return absl::UnknownError(message);
  }
}

}  // namespace

absl::StatusOr<std::string> HttpGet(const std::string& url,
                                    const HttpGetOptions& options) {
  const curl::Easy easy(curl_easy_init());
  curl::Headers headers;
  std::array<char, CURL_ERROR_SIZE> error{};
  std::string body;
  const auto set = [&](CURLoption option, auto value) {
    curl_easy_setopt(easy.get(), option, value);
  };
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_ERRORBUFFER, error.data());
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(options.timeout.count()));
  set(CURLOPT_WRITEFUNCTION, &Take);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&body));
  if (!options.ca_file.empty()) set(CURLOPT_CAINFO, options.ca_file.c_str());
  if (!options.certificate_file.empty()) {
    set(CURLOPT_SSLCERT, options.certificate_file.c_str());
    set(CURLOPT_SSLKEY, options.key_file.c_str());
  }
  if (!options.bearer_token.empty()) {
    curl::AddHeader(
        headers, absl::StrCat("Authorization: Bearer ", options.bearer_token));
    set(CURLOPT_HTTPHEADER, headers.get());
    // Nor does it go by way of a machine that need not see it.
    if (!absl::StartsWithIgnoreCase(url, "https:")) set(CURLOPT_NOPROXY, "*");
  }
  if (const CURLcode code = curl_easy_perform(easy.get()); code != CURLE_OK) {
    return absl::UnavailableError(absl::StrCat(
        url, ": ",
        code == CURLE_WRITE_ERROR ? "the answer is larger than 8 MiB"
        : error[0] != '\0'        ? error.data()
                                  : curl_easy_strerror(code)));
  }
  long status = 0;
  curl_easy_getinfo(easy.get(), CURLINFO_RESPONSE_CODE, &status);
  if (status != 200) return ErrorOf(url, status);
  return body;
}

}  // namespace treeline::scrape
