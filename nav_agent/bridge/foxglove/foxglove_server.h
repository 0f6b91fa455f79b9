// Lets Foxglove, and what else speaks its WebSocket protocol, watch the robot.
#ifndef NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_SERVER_H_
#define NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_SERVER_H_

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/http_server.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/agent_info.h"
#include "nav_agent/service/device_taps.h"

namespace treeline::foxglove {

struct FoxgloveServerOptions {
  // "HOST:PORT"; Foxglove itself looks at port 8765.
  std::string listen = "127.0.0.1:8765";
  // See http::HttpServerOptions.
  bool insecure_any_address = false;
  // Viewers at a time, 1..1000.
  int max_viewers = 16;
  // Pages of these origins may watch; "*": any. A program that is no page of a
  // browser sends none, and may.
  std::vector<std::string> origins = {"https://app.foxglove.dev", "file://"};
};

// Serves from construction on. Any path of the address is the WebSocket. It
// only shows: nobody can drive the robot by it.
class FoxgloveServer final : public http::HttpHandler {
 public:
  // camera: null: there is none. Keeps references to all but `options`; the hub
  // must be closed before the server goes: viewers end with it.
  // INVALID_ARGUMENT, UNAVAILABLE: as http::HttpServer::Start says it.
  static absl::StatusOr<std::unique_ptr<FoxgloveServer>> Start(
      const agent_service::AgentInfo& info, const agent_service::AgentHub& hub,
      const agent_service::PictureKeeper* camera, FoxgloveServerOptions options,
      const base::Clock& clock);
  // Viewers are told, if the hub is closed.
  ~FoxgloveServer() override;

  // HOST:PORT with the port that was bound.
  const std::string& address() const { return server_->address(); }

  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) override;
  http::HttpResponse Handle(const http::HttpRequest& request) override;
  http::HttpResponse Error(int status) override;
  std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const http::HttpRequest& request) override;

 private:
  FoxgloveServer(const agent_service::AgentInfo& info,
                 const agent_service::AgentHub& hub,
                 const agent_service::PictureKeeper* camera,
                 FoxgloveServerOptions options, const base::Clock& clock);

  bool IsAllowed(absl::string_view origin) const;
  void Watch(http::HttpDuplex& connection);

  const agent_service::AgentInfo& info_;
  const agent_service::AgentHub& hub_;
  const agent_service::PictureKeeper* const camera_;
  const FoxgloveServerOptions options_;
  const base::Clock& clock_;
  // Of this run of the agent.
  const std::string session_id_;
  std::atomic<int> viewers_ = 0;
  // The last member: it uses all of them.
  std::unique_ptr<http::HttpServer> server_;
};

}  // namespace treeline::foxglove

#endif  // NAV_AGENT_BRIDGE_FOXGLOVE_FOXGLOVE_SERVER_H_
