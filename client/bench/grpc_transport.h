// Calls over gRPC.
#ifndef CLIENT_BENCH_GRPC_TRANSPORT_H_
#define CLIENT_BENCH_GRPC_TRANSPORT_H_

#include <memory>
#include <vector>

#include "client/bench/transport.h"
#include "client/bench/workload.h"
#include "client/relocalizer/channel.h"

namespace treeline::bench {

// Calls go over the connections in turn. `items` must outlive the transport.
std::unique_ptr<Transport> MakeGrpcTransport(
    const std::vector<relocalizer::Connection>& connections,
    const std::vector<WorkItem>& items);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_GRPC_TRANSPORT_H_
