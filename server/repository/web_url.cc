#include "server/repository/web_url.h"

#include <curl/curl.h>

#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace treeline::repository {
namespace {

struct UrlDeleter {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
using ParsedUrl = std::unique_ptr<CURLU, UrlDeleter>;

// Null: not an address.
ParsedUrl Parse(const std::string& url) {
  ParsedUrl parsed(curl_url());
  if (curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK) {
    return nullptr;
  }
  return parsed;
}

// Empty where it has none.
std::string Part(const ParsedUrl& url, CURLUPart part) {
  char* text = nullptr;
  if (curl_url_get(url.get(), part, &text, 0) != CURLUE_OK) return "";
  std::string value(text);
  curl_free(text);
  return value;
}

bool IsLoopback(const std::string& host) {
  return host == "localhost" || host == "[::1]" ||
         (absl::StartsWith(host, "127.") &&
          host.find_first_not_of("0123456789.") == std::string::npos);
}

}  // namespace

absl::StatusOr<std::string> ResolveUrl(const std::string& base,
                                       const std::string& reference) {
  const ParsedUrl url = base.empty() ? ParsedUrl(curl_url()) : Parse(base);
  if (url == nullptr || curl_url_set(url.get(), CURLUPART_URL,
                                     reference.c_str(), 0) != CURLUE_OK) {
    return absl::InvalidArgumentError("not the address of a web server");
  }
  const std::string scheme = Part(url, CURLUPART_SCHEME);
  if (scheme != "http" && scheme != "https") {
    return absl::InvalidArgumentError(
        "an address that starts with neither https:// nor http://");
  }
  curl_url_set(url.get(), CURLUPART_FRAGMENT, nullptr, 0);
  return Part(url, CURLUPART_URL);
}

std::string PublicUrl(const std::string& url) {
  const ParsedUrl parsed = Parse(url);
  if (parsed == nullptr) return "(an address)";
  for (const CURLUPart part :
       {CURLUPART_QUERY, CURLUPART_FRAGMENT, CURLUPART_USER, CURLUPART_PASSWORD,
        CURLUPART_OPTIONS}) {
    curl_url_set(parsed.get(), part, nullptr, 0);
  }
  return Part(parsed, CURLUPART_URL);
}

absl::Status CheckTransport(const std::string& url, bool allow_plain_http) {
  if (IsHttps(url) || allow_plain_http) return absl::OkStatus();
  const ParsedUrl parsed = Parse(url);
  if (parsed != nullptr && IsLoopback(Part(parsed, CURLUPART_HOST))) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(PublicUrl(url),
                   " is not encrypted: anyone on the way could put in other "
                   "models; use https"));
}

bool IsHttps(const std::string& url) {
  return absl::StartsWithIgnoreCase(url, "https://");
}

}  // namespace treeline::repository
