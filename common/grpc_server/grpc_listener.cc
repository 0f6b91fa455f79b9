#include "common/grpc_server/grpc_listener.h"

#include <grpcpp/ext/health_check_service_server_builder_option.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/impl/server_builder_option.h>
#include <grpcpp/impl/server_builder_plugin.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <set>

#include "absl/base/attributes.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "common/grpc_server/call_counter.h"

namespace treeline::grpc_server {
namespace {

// A peer that does not finish its handshake is cut off.
constexpr int kHandshake_ms = 10'000;
// Clients may ask as often as this themselves whether the server lives.
constexpr int kMinPingInterval_ms = 5'000;

void Enable(const GrpcPlugin& plugin) {
  ABSL_CONST_INIT static absl::Mutex mutex(absl::kConstInit);
  static std::set<std::string>& enabled = *new std::set<std::string>;
  const absl::MutexLock lock(&mutex);
  if (enabled.insert(plugin.name).second) plugin.enable();
}

// Of the plugins that a builder has, leaves those with these names.
class KeepPlugins final : public grpc::ServerBuilderOption {
 public:
  explicit KeepPlugins(const std::vector<GrpcPlugin>& plugins)
      : plugins_(plugins) {}
  void UpdateArguments(grpc::ChannelArguments* /*arguments*/) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>*
                         plugins) override {
    std::erase_if(*plugins, [this](const auto& each) {
      return std::none_of(
          plugins_.begin(), plugins_.end(),
          [&](const GrpcPlugin& kept) { return kept.name == each->name(); });
    });
  }

 private:
  const std::vector<GrpcPlugin> plugins_;
};

void SetServices(const GrpcListenerOptions& options,
                 grpc::ServerBuilder& builder) {
  builder.SetOption(std::make_unique<KeepPlugins>(options.plugins));
  if (options.default_health) {
    grpc::EnableDefaultHealthCheckService(true);
  } else {
    builder.SetOption(
        std::make_unique<grpc::HealthCheckServiceServerBuilderOption>(nullptr));
  }
}

void SetSizes(const GrpcListenerOptions& options,
              grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(options.max_message_bytes);
  if (!options.allow_compression) {
    builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
    builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
    builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  }
  grpc::ResourceQuota quota("treeline");
  if (options.max_buffered_bytes > 0) quota.Resize(options.max_buffered_bytes);
  if (options.max_threads > 0) quota.SetMaxThreads(options.max_threads);
  builder.SetResourceQuota(quota);
  if (options.max_calls_of_connection > 0) {
    builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                               options.max_calls_of_connection);
  }
}

void SetTimes(const GrpcListenerOptions& options,
              grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                             kHandshake_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS,
                             options.keepalive_time_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                             options.keepalive_timeout_ms);
  builder.AddChannelArgument(
      GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
      kMinPingInterval_ms);
  if (options.keepalive_without_calls) {
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  }
  if (options.max_connection_age_s > 0) {
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS,
                               options.max_connection_age_s * 1000);
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS,
                               options.connection_grace_s * 1000);
  }
}

}  // namespace

absl::StatusOr<GrpcListener> StartGrpcListener(
    const GrpcListenerOptions& options,
    const std::function<void(grpc::ServerBuilder&)>& add_services) {
  TL_ASSIGN_OR_RETURN(base::ListenAddress address,
                      base::ParseListenAddress(options.listen));
  // gRPC would fail too, but keep the reason to itself.
  TL_RETURN_IF_ERROR(base::TryBind(address));
  for (const GrpcPlugin& plugin : options.plugins) Enable(plugin);
  grpc::ServerBuilder builder;
  // Else a second server would share the port, and half the calls, in silence.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  SetServices(options, builder);
  SetSizes(options, builder);
  SetTimes(options, builder);
  if (options.guard != nullptr) CountCalls(options.guard, builder);
  add_services(builder);
  GrpcListener listener;
  const auto guard_port = [&] {
    if (options.guard == nullptr || address.port == 0) return;
    listener.guarded_port =
        std::make_unique<flood_guard::GuardedPort>(address.port, options.guard);
  };
  // Before anybody connects; who knows of a port that is still to be chosen?
  guard_port();
  int port = 0;
  builder.AddListeningPort(address.ToString(),
                           options.credentials != nullptr
                               ? options.credentials
                               : grpc::InsecureServerCredentials(),
                           &port);
  listener.server = builder.BuildAndStart();
  if (listener.server == nullptr || port == 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", address.ToString()));
  }
  address.port = port;
  if (listener.guarded_port == nullptr) guard_port();
  listener.address = address.ToString();
  return listener;
}

}  // namespace treeline::grpc_server
