#include "client/cli/metrics_source.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {

MetricsSource::MetricsSource(std::string url, scrape::HttpGetOptions options,
                             std::shared_ptr<relocalizer::TokenSource> token)
    : url_(std::move(url)),
      options_(std::move(options)),
      token_(std::move(token)) {}

absl::StatusOr<MetricsSource> MetricsSource::Open(
    const std::string& url, const relocalizer::ConnectOptions& options) {
  absl::string_view rest = url;
  const bool secure = absl::ConsumePrefix(&rest, "https://");
  const bool has_scheme = secure || absl::ConsumePrefix(&rest, "http://");
  const absl::string_view host = rest.substr(0, rest.find('/'));
  // Nothing that curl could read in another way than we do.
  if (!has_scheme || !relocalizer::IsUrlHost(host)) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", url,
                     "\" is no address of metrics: write "
                     "http://HOST:PORT or https://HOST:PORT"));
  }
  std::string full = url;
  if (host.size() == rest.size()) full += "/metrics";
  TL_ASSIGN_OR_RETURN(std::shared_ptr<relocalizer::TokenSource> token,
                      relocalizer::TokenSource::Open(options));
  if (token != nullptr && !secure &&
      !relocalizer::IsUrlHostOnThisMachine(host)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the token would travel in the clear to ", host, ": use https://"));
  }
  return MetricsSource(std::move(full),
                       {.ca_file = options.tls.ca_file,
                        .certificate_file = options.tls.certificate_file,
                        .key_file = options.tls.key_file},
                       std::move(token));
}

absl::StatusOr<std::string> MetricsSource::Fetch() const {
  scrape::HttpGetOptions options = options_;
  if (token_ != nullptr) options.bearer_token = token_->Get();
  return scrape::HttpGet(url_, options);
}

}  // namespace treeline::client_cli
