#include "client/relocalizer/channel.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::relocalizer {
namespace {

// A request larger than this buffer is sent once and never retried; gRPC's
// default of 256 KiB is less than an ordinary frame with depth.
constexpr int kRetryBufferBytes = 16 << 20;

// A server that hangs (a stopped process, a machine that is gone) goes on
// holding its connections, and round robin goes on sending calls to it. A ping
// that is not answered ends the connection, and its calls go elsewhere: within
// 4 s here, of the 10 s that a call has. Pings are sent while calls wait only.
constexpr int kPingAfter_ms = 2000;
constexpr int kPingTimeout_ms = 2000;

// gRPC would wait up to two minutes before it tries a lost server again; a
// replica that was restarted should be used at once.
constexpr int kFirstReconnect_ms = 100;
constexpr int kLastReconnect_ms = 2000;

// gRPC would look a name up again only 30 s after the last time, whatever went
// meanwhile; servers that are restarted in turn may all be others by then.
constexpr int kLookUpAgain_ms = 1000;

constexpr unsigned kCertificateRefresh_s = 1;

// gRPC's service configuration: calls go to every address in turn, and are
// tried again while the answer is UNAVAILABLE. A server that goes down ends
// calls that arrive while it says so with CANCELLED; calls that the client
// itself cancels are over without any answer.
std::string ServiceConfig(int max_attempts) {
  constexpr char kRetryPolicy[] =
      R"(, "retryPolicy": {"maxAttempts": %d, "initialBackoff": "0.05s",)"
      R"( "maxBackoff": "1s", "backoffMultiplier": 3,)"
      R"( "retryableStatusCodes": ["UNAVAILABLE", "CANCELLED"]})";
  const std::string retry_policy =
      max_attempts > 1 ? absl::StrFormat(kRetryPolicy, max_attempts) : "";
  return absl::StrCat(
      R"({"loadBalancingConfig": [{"round_robin": {}}], "methodConfig": [)",
      R"({"name": [{"service": "treeline.v1.RelocalizationService"},)",
      R"( {"service": "treeline.v1.SceneService"}])", retry_policy, "}]}");
}

// gRPC would only log what is wrong with a file, and wait for a better one.
absl::Status CheckPem(const std::string& path, absl::string_view what) {
  if (path.empty()) return absl::OkStatus();
  const absl::StatusOr<std::string> text = base::ReadFile(path, 16 << 20);
  if (!text.ok()) return text.status();
  if (absl::StrContains(*text, "-----BEGIN ")) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": there is no ", what, " in PEM format in it"));
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> TlsCredentialsOf(
    const ClientTlsOptions& tls) {
  TL_RETURN_IF_ERROR(CheckPem(tls.ca_file, "certificate"));
  TL_RETURN_IF_ERROR(CheckPem(tls.certificate_file, "certificate"));
  TL_RETURN_IF_ERROR(CheckPem(tls.key_file, "key"));
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(
      std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
          tls.key_file, tls.certificate_file, tls.ca_file,
          kCertificateRefresh_s));
  options.watch_root_certs();
  if (!tls.certificate_file.empty()) options.watch_identity_key_cert_pairs();
  auto credentials = grpc::experimental::TlsCredentials(options);
  if (credentials == nullptr) {
    return absl::InternalError("gRPC takes no such TLS options");
  }
  return credentials;
}

// The host that all addresses of a list have; empty if they differ, or if it is
// no list. gRPC would look for the whole list in the certificate.
std::string HostOfList(const std::string& server) {
  const size_t comma = server.find(',');
  if (comma == std::string::npos) return "";
  const std::string host = server.substr(0, server.rfind(':', comma));
  for (size_t at = comma; at != std::string::npos;
       at = server.find(',', at + 1)) {
    if (server.compare(at + 1, host.size() + 1, host + ":") != 0) return "";
  }
  return host;
}

absl::Status NameServer(const ConnectOptions& options,
                        grpc::ChannelArguments& arguments) {
  std::string name = options.tls.server_name;
  if (name.empty() && absl::StrContains(options.server, ",")) {
    name = HostOfList(options.server);
    if (name.empty()) {
      return absl::InvalidArgumentError(
          "several servers: say which name all their certificates have");
    }
  }
  if (!name.empty()) arguments.SetSslTargetNameOverride(name);
  return absl::OkStatus();
}

grpc::ChannelArguments ArgumentsOf(const ConnectOptions& options) {
  grpc::ChannelArguments arguments;
  arguments.SetServiceConfigJSON(ServiceConfig(options.max_attempts));
  arguments.SetInt(GRPC_ARG_PER_RPC_RETRY_BUFFER_SIZE, kRetryBufferBytes);
  arguments.SetMaxReceiveMessageSize(options.max_message_mib << 20);
  arguments.SetMaxSendMessageSize(options.max_message_mib << 20);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kPingAfter_ms);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kPingTimeout_ms);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirstReconnect_ms);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kLastReconnect_ms);
  arguments.SetInt(GRPC_ARG_DNS_MIN_TIME_BETWEEN_RESOLUTIONS_MS,
                   kLookUpAgain_ms);
  if (IsOnThisMachine(options.server)) {
    // gRPC would ask the proxy of http_proxy to connect to itself.
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  }
  if (options.own_connections) {
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  }
  return arguments;
}

// docs/reference/service.md. What is no name goes to the server in the request
// alone, which says what is wrong with it; gRPC would end the call for a
// character that no header may hold.
constexpr char kSceneMetadata[] = "x-treeline-scene";
constexpr size_t kMaxSceneName = 128;

bool IsSceneName(absl::string_view scene) {
  return !scene.empty() && scene.size() <= kMaxSceneName &&
         std::all_of(scene.begin(), scene.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  c == '.' || c == '_' || c == '-';
         });
}

// At least so far that gRPC takes it.
bool IsTraceparent(absl::string_view text) {
  constexpr size_t kLength = 55;
  return text.size() == kLength &&
         text.find_first_not_of("0123456789abcdef-") == absl::string_view::npos;
}

}  // namespace

Connection::Connection(std::shared_ptr<grpc::Channel> channel,
                       std::shared_ptr<TokenSource> token)
    : channel_(std::move(channel)), token_(std::move(token)) {}

absl::StatusOr<Connection> Connection::Open(const ConnectOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(const std::string target, GrpcTarget(options.server));
  TL_ASSIGN_OR_RETURN(std::shared_ptr<TokenSource> token,
                      TokenSource::Open(options));
  grpc::ChannelArguments arguments = ArgumentsOf(options);
  std::shared_ptr<grpc::ChannelCredentials> credentials =
      grpc::InsecureChannelCredentials();
  if (!options.tls.ca_file.empty()) {
    TL_RETURN_IF_ERROR(NameServer(options, arguments));
    TL_ASSIGN_OR_RETURN(credentials, TlsCredentialsOf(options.tls));
  }
  return Connection(grpc::CreateCustomChannel(target, credentials, arguments),
                    std::move(token));
}

void Connection::Prepare(grpc::ClientContext& context, absl::string_view scene,
                         absl::string_view traceparent) const {
  if (token_ != nullptr) {
    context.AddMetadata("authorization", "Bearer " + token_->Get());
  }
  if (IsSceneName(scene)) {
    context.AddMetadata(kSceneMetadata, std::string(scene));
  }
  if (IsTraceparent(traceparent)) {
    context.AddMetadata("traceparent", std::string(traceparent));
  }
}

}  // namespace treeline::relocalizer
