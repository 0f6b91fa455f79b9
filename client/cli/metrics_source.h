// A server's /metrics, reached as its other calls are.
#ifndef CLIENT_CLI_METRICS_SOURCE_H_
#define CLIENT_CLI_METRICS_SOURCE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/relocalizer/connect_options.h"
#include "client/relocalizer/token_source.h"
#include "client/scrape/http_get.h"

namespace treeline::client_cli {

// Thread-safe.
class MetricsSource {
 public:
  // `url`: "http://HOST:PORT" or with a path; /metrics is the one without.
  // Certificates and token are those of the options; nothing else of them is
  // used. INVALID_ARGUMENT: no such address, or a token would travel in the
  // clear to another machine; otherwise what is wrong with the token's file.
  static absl::StatusOr<MetricsSource> Open(
      const std::string& url, const relocalizer::ConnectOptions& options);

  const std::string& url() const { return url_; }
  // As HttpGet.
  absl::StatusOr<std::string> Fetch() const;

 private:
  MetricsSource(std::string url, scrape::HttpGetOptions options,
                std::shared_ptr<relocalizer::TokenSource> token);

  std::string url_;
  scrape::HttpGetOptions options_;
  std::shared_ptr<relocalizer::TokenSource> token_;  // null: none
};

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_METRICS_SOURCE_H_
