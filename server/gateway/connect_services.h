// The services over the Connect protocol.
#ifndef SERVER_GATEWAY_CONNECT_SERVICES_H_
#define SERVER_GATEWAY_CONNECT_SERVICES_H_

#include "common/base/clock.h"
#include "common/connect_rpc/connect_router.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

// Adds the unary RPCs of RelocalizationService and SceneService, each with its
// access, and says of LocalizeStream that it is no call here.
// `admin_listener`: see CallInfo. Keeps references to `dispatcher` and `clock`.
void AddConnectServices(service::Dispatcher& dispatcher, bool admin_listener,
                        const base::Clock& clock,
                        connect_rpc::ConnectRouter& router);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_CONNECT_SERVICES_H_
