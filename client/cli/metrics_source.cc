#include "client/cli/metrics_source.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {

MetricsSource::MetricsSource(std::string url, scrape::HttpGetOptions options,
                             std::shared_ptr<relocalizer::TokenSource> token)
    : url_(std::move(url)),
      options_(std::move(options)),
      token_(std::move(token)) {}

absl::StatusOr<MetricsSource> MetricsSource::Open(
    const std::string& url, const ConnectionFlags& flags) {
  absl::string_view rest = url;
  const bool secure = absl::ConsumePrefix(&rest, "https://");
  if (!secure && !absl::ConsumePrefix(&rest, "http://")) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", url,
                     "\" is no address of metrics: write "
                     "http://HOST:PORT or https://HOST:PORT"));
  }
  const absl::string_view host = rest.substr(0, rest.find('/'));
  std::string full = url;
  if (host.size() == rest.size()) full += "/metrics";
  const relocalizer::ConnectOptions options = ConnectOptionsOf(flags);
  std::shared_ptr<relocalizer::TokenSource> token;
  if (!options.token_file.empty()) {
    TL_ASSIGN_OR_RETURN(token,
                        relocalizer::TokenSource::FromFile(options.token_file));
  } else if (!options.token_variable.empty()) {
    TL_ASSIGN_OR_RETURN(token, relocalizer::TokenSource::FromEnvironment(
                                   options.token_variable));
  }
  if (token != nullptr && !secure && !relocalizer::IsOnThisMachine(host)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the token would travel in the clear to ", host, ": use https://"));
  }
  return MetricsSource(std::move(full),
                       {.ca_file = flags.tls.ca_file,
                        .certificate_file = flags.tls.certificate_file,
                        .key_file = flags.tls.key_file},
                       std::move(token));
}

absl::StatusOr<std::string> MetricsSource::Fetch() const {
  scrape::HttpGetOptions options = options_;
  if (token_ != nullptr) options.bearer_token = token_->Get();
  return scrape::HttpGet(url_, options);
}

}  // namespace treeline::client_cli
