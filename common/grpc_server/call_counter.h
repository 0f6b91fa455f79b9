// Tells a FloodGuard which calls are open.
#ifndef COMMON_GRPC_SERVER_CALL_COUNTER_H_
#define COMMON_GRPC_SERVER_CALL_COUNTER_H_

#include <grpcpp/server_builder.h>

#include <memory>

#include "common/flood_guard/flood_guard.h"

namespace treeline::grpc_server {

// Of the server that is built, the calls of all services.
void CountCalls(std::shared_ptr<flood_guard::FloodGuard> guard,
                grpc::ServerBuilder& builder);

}  // namespace treeline::grpc_server

#endif  // COMMON_GRPC_SERVER_CALL_COUNTER_H_
