// What gRPC knows about a call, as the service wants it.
#ifndef SERVER_SERVICE_GRPC_CALL_H_
#define SERVER_SERVICE_GRPC_CALL_H_

#include <grpcpp/server_context.h>

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "server/service/call.h"

namespace treeline::service {

using CertificateNamesOf =
    std::function<std::vector<std::string>(const grpc::AuthContext&)>;

// What all calls of a listener have in common.
struct CallSource {
  const base::Clock& clock;
  // What requests are held by; nullptr: without a bound.
  base::ByteBudget* budget = nullptr;
  // What large answers are held by until their clients have taken them.
  base::ByteBudget* answers = nullptr;
  bool admin_listener = false;
  CertificateNamesOf certificate_names = {};
};

// Of a call whose metadata, or whose request, has just arrived. rpc: a literal.
CallInfo CallInfoFrom(const grpc::CallbackServerContext& context,
                      const char* rpc, const CallSource& source,
                      std::stop_token stop);

// The status for the wire; adds the trailer grpc-retry-pushback-ms, which gRPC
// clients obey, if the status says when to try again.
grpc::Status FinishStatus(const absl::Status& status,
                          grpc::CallbackServerContext& context);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_GRPC_CALL_H_
