// What the agent answers over HTTP: the operator's page, pictures and maps,
// navigation.proto's services over Connect, and JSON for scripts.
// docs/reference/agent.md specifies it.
#ifndef NAV_AGENT_SERVICE_HTTP_API_H_
#define NAV_AGENT_SERVICE_HTTP_API_H_

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "common/base/clock.h"
#include "common/connect_rpc/connect_router.h"
#include "common/http/http_message.h"
#include "common/http/static_files.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/agent_metrics.h"
#include "nav_agent/service/device_taps.h"
#include "nav_agent/service/docking_calls.h"
#include "nav_agent/service/event_stream.h"
#include "nav_agent/service/navigation_calls.h"
#include "nav_agent/service/simulation_calls.h"

namespace treeline::agent_service {

struct HttpApiOptions {
  // Streams at a time, 1..1000: of server-sent events, and of Connect.
  int max_streams = 16;
  // No stream is silent for longer: a comment, or an empty message, is sent.
  absl::Duration heartbeat = absl::Seconds(5);
  // A robot whose newest state is older is not ready.
  absl::Duration ready_within = absl::Seconds(2);
  // Folder of the page; empty: none.
  std::string page_folder;

  absl::Status Validate() const;
};

// Thread-safe.
class HttpApi final : public http::HttpHandler {
 public:
  // camera, query: null if there is no camera. All must outlive it, and
  // commands' hub be closed before the HTTP server is stopped: streams end with
  // it. `options` must be valid.
  HttpApi(AgentCommands& commands, AgentMetrics& metrics,
          const PictureKeeper* camera, const PictureKeeper* query,
          const HttpApiOptions& options, const base::Clock& clock);

  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) override;
  http::HttpResponse Handle(const http::HttpRequest& request) override;
  http::HttpResponse Error(int status) override;
  std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const http::HttpRequest& request) override;

 private:
  using Get = std::function<http::HttpResponse()>;
  // The JSON of the answer.
  using Post =
      std::function<absl::StatusOr<std::string>(absl::string_view body)>;

  void AddGets();
  void AddPosts();
  void AddSimulationPosts();
  http::HttpResponse GetState(bool scene);
  http::HttpResponse GetReady() const;
  http::HttpResponse GetLevel(absl::string_view path);
  http::HttpResponse GetLevelPicture(int level);
  http::HttpResponse GetOctomap();
  http::HttpResponse GetFile(const std::string& path) const;
  http::HttpResponse OpenStream();
  // Made once for all streams.
  std::shared_ptr<const StateTexts> TextsOf(const AgentState& state);

  AgentCommands& commands_;
  AgentMetrics& metrics_;
  const PictureKeeper* const camera_;
  const PictureKeeper* const query_;
  const HttpApiOptions options_;
  const http::StaticFiles files_;
  NavigationCalls navigation_;
  DockingCalls docking_;
  SimulationCalls simulation_;
  connect_rpc::ConnectRouter connect_;
  std::map<std::string, Get> gets_;
  std::map<std::string, Post> posts_;
  std::atomic<int> streams_ = 0;
  absl::Mutex mutex_;
  std::shared_ptr<const StateTexts> texts_ ABSL_GUARDED_BY(mutex_);
  std::string info_ ABSL_GUARDED_BY(mutex_);
  std::string octomap_ ABSL_GUARDED_BY(mutex_);
  std::map<int, std::string> levels_ ABSL_GUARDED_BY(mutex_);
};

// What HTTP calls an error: INVALID_ARGUMENT is 400, and so on.
int HttpStatusOfCode(absl::StatusCode code);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_HTTP_API_H_
