#include "server/service/grpc_call.h"

#include <chrono>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/wire/status.h"

namespace treeline::service {
namespace {

constexpr absl::string_view kBearer = "bearer ";

// gRPC gives deadlines on the system clock; everything here is on the
// monotonic one.
base::MonotonicTime MonotonicDeadline(
    const grpc::CallbackServerContext& context, base::MonotonicTime now) {
  const auto deadline = context.deadline();
  if (deadline == std::chrono::system_clock::time_point::max()) {
    return base::MonotonicTime::max();
  }
  const auto left = deadline - std::chrono::system_clock::now();
  // Far deadlines must not overflow the sum.
  if (left > std::chrono::hours(24 * 365)) return base::MonotonicTime::max();
  return now + std::chrono::duration_cast<base::MonotonicTime::duration>(left);
}

std::string MetadataOf(const grpc::CallbackServerContext& context,
                       const char* key) {
  const auto entry = context.client_metadata().find(key);
  if (entry == context.client_metadata().end()) return "";
  return std::string(entry->second.data(), entry->second.size());
}

}  // namespace

CallInfo CallInfoFrom(const grpc::CallbackServerContext& context,
                      const char* rpc, const CallSource& source,
                      std::stop_token stop) {
  CallInfo call;
  call.rpc = rpc;
  call.peer = context.peer();
  const std::string authorization = MetadataOf(context, "authorization");
  if (absl::StartsWithIgnoreCase(authorization, kBearer)) {
    call.credentials.bearer_token = authorization.substr(kBearer.size());
  }
  call.traceparent = MetadataOf(context, "traceparent");
  if (source.certificate_names) {
    call.credentials.certificate_names =
        source.certificate_names(*context.auth_context());
  }
  call.admin_listener = source.admin_listener;
  call.arrival = source.clock.Now();
  call.deadline = MonotonicDeadline(context, call.arrival);
  call.stop = std::move(stop);
  return call;
}

grpc::Status FinishStatus(const absl::Status& status,
                          grpc::CallbackServerContext& context) {
  if (const auto retry_after = base::RetryAfterOf(status)) {
    context.AddTrailingMetadata("grpc-retry-pushback-ms",
                                absl::StrCat(retry_after->count()));
  }
  return wire::ToGrpc(status);
}

}  // namespace treeline::service
