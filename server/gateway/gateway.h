// The service over HTTP: the Connect protocol, GeoPose Protocol, the AR page,
// health and metrics. docs/reference/http.md describes it to clients.
#ifndef SERVER_GATEWAY_GATEWAY_H_
#define SERVER_GATEWAY_GATEWAY_H_

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/http/http_server.h"
#include "server/service/call.h"
#include "server/service/dispatcher.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::gateway {

struct GatewayOptions {
  http::HttpServerOptions http = {};
  // Origins whose pages may call; see CorsPolicy.
  std::vector<std::string> allowed_origins = {};
  // What is served; /healthz and /readyz always are. A server may have one
  // gateway for clients and a second one for operators.
  // All RPCs, and /geopose.
  bool serve_rpc = true;
  // Calls that come in here are an operator's: CallInfo::admin_listener.
  bool serve_admin = false;
  // /metrics.
  bool serve_metrics = true;
  // Folder of the AR page, served below /ar/; empty: there is none.
  std::string ar_page_folder = {};

  absl::Status Validate() const;
};

// What a path answers.
struct Content {
  std::string type;
  std::string bytes;
};

// What the gateway asks of the rest of the server. All may be called from many
// threads at a time; none may block for long.
struct GatewayHooks {
  // For a reader whose header `Accept` is this; empty function: there is no
  // /metrics.
  std::function<Content(absl::string_view accept)> metrics = {};
  // Whether who asks may read them, which name scenes; empty function: everyone
  // may.
  std::function<absl::Status(const service::CallInfo&)> may_read_metrics = {};
  // What lies below /failed-queries: "" is the list, "NAME" one of them,
  // "NAME/picture" its picture. NOT_FOUND, or why it cannot be read. Empty
  // function: there is no such path.
  std::function<absl::StatusOr<Content>(absl::string_view path)>
      failed_queries = {};
  // Whether who asks may see them; without it nobody may.
  std::function<absl::Status(const service::CallInfo&)> may_inspect = {};
  // Whether queries are answered; empty function: always.
  std::function<bool()> ready = {};
  // All scenes, for the geo-anchors of /geopose; empty function: there is no
  // /geopose.
  std::function<std::vector<v1::SceneInfo>()> scenes = {};
};

// Serves from construction to Stop().
class Gateway {
 public:
  // INVALID_ARGUMENT: options. UNAVAILABLE: the address cannot be bound, with
  // the system's reason. `dispatcher` and `clock` must outlive the gateway.
  static absl::StatusOr<std::unique_ptr<Gateway>> Start(
      const GatewayOptions& options, service::Dispatcher& dispatcher,
      GatewayHooks hooks, const base::Clock& clock);
  // Stops without waiting for calls in flight: they are cancelled.
  ~Gateway();

  // HOST:PORT with the port that was bound.
  const std::string& address() const;

  // Closes the listener, waits up to `grace` for the calls in flight, asks the
  // rest to stop, and returns when the last has ended. /readyz is the app's to
  // turn before.
  void Stop(std::chrono::milliseconds grace);

 private:
  struct Parts;
  explicit Gateway(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_GATEWAY_H_
