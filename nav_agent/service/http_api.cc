#include "nav_agent/service/http_api.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/metrics/exposition.h"
#include "nav_agent/service/api_json.h"
#include "nav_agent/service/api_request.h"
#include "nav_agent/service/connect_services.h"
#include "nav_agent/service/map_pictures.h"
#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/stream_slot.h"

namespace treeline::agent_service {
namespace {

constexpr char kJson[] = "application/json";
constexpr char kOk[] = "{\"ok\":true}";
constexpr char kNoPage[] =
    "The operator's page is not built.\n\n"
    "The robot runs without it; its API is here (GET /api/state, "
    "docs/reference/agent.md)."
    "\nTo build the page: scripts/build-page, or give --page-dir DIR.\n";

http::HttpResponse Failure(const absl::Status& status) {
  return {.status = HttpStatusOfCode(status.code()),
          .content_type = kJson,
          .body = ErrorJson(status)};
}

http::HttpResponse Failure(int http_status, const std::string& code,
                           const std::string& message) {
  return {.status = http_status,
          .content_type = kJson,
          .body = ErrorJson(code, message)};
}

http::HttpResponse JsonAnswer(std::string body) {
  return {.content_type = kJson, .body = std::move(body)};
}

http::HttpResponse PictureAnswer(const PictureKeeper* keeper,
                                 const char* what) {
  if (keeper == nullptr) {
    return Failure(404, "not_found",
                   absl::StrCat("no ", what, ": the robot has no camera"));
  }
  const auto jpeg = keeper->Jpeg();
  if (!jpeg.ok()) return Failure(jpeg.status());
  return {.content_type = "image/jpeg", .body = **jpeg};
}

// Digits alone name a level: no sign, no space, and not too many of them.
std::optional<int> LevelCalled(absl::string_view name, size_t levels) {
  constexpr size_t kMaxDigits = 4;
  int level = 0;
  if (name.size() > kMaxDigits ||
      !std::all_of(name.begin(), name.end(), absl::ascii_isdigit) ||
      !absl::SimpleAtoi(name, &level) || static_cast<size_t>(level) >= levels) {
    return std::nullopt;
  }
  return level;
}

}  // namespace

int HttpStatusOfCode(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kOk:
      return 200;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
      return 400;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kFailedPrecondition:
      return 409;
    case absl::StatusCode::kResourceExhausted:
      return 429;
    case absl::StatusCode::kUnimplemented:
      return 501;
    case absl::StatusCode::kUnavailable:
      return 503;
    case absl::StatusCode::kDeadlineExceeded:
      return 504;
    default:
      return 500;
  }
}

absl::Status HttpApiOptions::Validate() const {
  if (max_streams < 1 || max_streams > 1000) {
    return absl::InvalidArgumentError(
        absl::StrCat("streams are ", max_streams, "; it must be 1..1000"));
  }
  if (heartbeat <= absl::ZeroDuration() ||
      ready_within <= absl::ZeroDuration()) {
    return absl::InvalidArgumentError("the page's times must be above 0");
  }
  return absl::OkStatus();
}

HttpApi::HttpApi(AgentCommands& commands, AgentMetrics& metrics,
                 const PictureKeeper* camera, const PictureKeeper* query,
                 const HttpApiOptions& options, const base::Clock& clock)
    : commands_(commands),
      metrics_(metrics),
      camera_(camera),
      query_(query),
      options_(options),
      files_(options.page_folder),
      navigation_(commands, options.max_streams),
      docking_(commands, options.max_streams),
      simulation_(commands),
      connect_(clock,
               {.require_protocol_version = true,
                .heartbeat = absl::ToChronoMilliseconds(options.heartbeat)}) {
  AddGets();
  AddPosts();
  AddNavigationCalls(navigation_, connect_);
  AddDockingCalls(docking_, connect_);
  if (!commands_.is_simulated()) return;
  AddSimulationPosts();
  AddSimulationCalls(simulation_, connect_);
}

void HttpApi::AddGets() {
  gets_["/api/info"] = [this] {
    const absl::MutexLock lock(&mutex_);
    if (info_.empty()) info_ = InfoJson(InfoToProto(commands_.info()));
    return JsonAnswer(info_);
  };
  gets_["/api/state"] = [this] { return GetState(/*scene=*/false); };
  gets_["/api/scene"] = [this] { return GetState(/*scene=*/true); };
  gets_["/api/stream"] = [this] { return OpenStream(); };
  gets_["/api/octomap"] = [this] { return GetOctomap(); };
  gets_["/api/camera.jpg"] = [this] {
    return PictureAnswer(camera_, "camera picture");
  };
  gets_["/api/query.jpg"] = [this] {
    return PictureAnswer(query_, "picture that was sent to the server");
  };
  gets_["/metrics"] = [this] {
    return http::HttpResponse{.content_type = metrics::ContentTypeOf(
                                  metrics::ExpositionFormat::kPrometheus),
                              .body = metrics_.Expose()};
  };
  gets_["/healthz"] = [] {
    return http::HttpResponse{.content_type = "text/plain", .body = "ok\n"};
  };
  gets_["/readyz"] = [this] { return GetReady(); };
}

void HttpApi::AddPosts() {
  const auto plain = [](absl::Status (*run)(AgentCommands&),
                        AgentCommands& commands) {
    return [run,
            &commands](absl::string_view body) -> absl::StatusOr<std::string> {
      TL_RETURN_IF_ERROR(ParseEmptyRequest(body));
      TL_RETURN_IF_ERROR(run(commands));
      return kOk;
    };
  };
  posts_["/api/cancel"] = plain(
      [](AgentCommands& commands) { return commands.Cancel(0); }, commands_);
  posts_["/api/pause"] = plain(
      [](AgentCommands& commands) { return commands.Pause(); }, commands_);
  posts_["/api/resume"] = plain(
      [](AgentCommands& commands) { return commands.Resume(); }, commands_);
  posts_["/api/stop"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_RETURN_IF_ERROR(ParseEmptyRequest(body));
    TL_ASSIGN_OR_RETURN(const StopKeeping kept, commands_.Stop(""));
    return WarnedJson(kept.status);
  };
  posts_["/api/release"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_RETURN_IF_ERROR(ParseEmptyRequest(body));
    TL_ASSIGN_OR_RETURN(const StopKeeping kept, commands_.Release());
    return WarnedJson(kept.status);
  };
  posts_["/api/find-yourself"] =
      plain([](AgentCommands& commands) { return commands.FindYourself(); },
            commands_);
  posts_["/api/goal"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const std::vector<RequestedPose> poses,
                        ParseGoalRequest(body));
    TL_ASSIGN_OR_RETURN(const uint64_t id, commands_.SetGoal(poses));
    return absl::StrCat("{\"ok\":true,\"id\":", id, "}");
  };
  posts_["/api/initial-pose"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const InitialPoseRequest request,
                        ParseInitialPoseRequest(body));
    TL_RETURN_IF_ERROR(
        commands_.SetPose(request.pose, request.std_m, request.std_rad));
    return kOk;
  };
}

void HttpApi::AddSimulationPosts() {
  posts_["/api/sim/kidnap"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const KidnapRequest request, ParseKidnapRequest(body));
    absl::StatusOr<geometry::Rigid3> result;
    if (request.place.has_value()) {
      result = commands_.KidnapTo(*request.place);
    } else if (request.pose.has_value()) {
      result = commands_.Kidnap(*request.pose);
    } else {
      result = commands_.KidnapAnywhere();
    }
    TL_RETURN_IF_ERROR(result.status());
    return absl::StrCat("{\"ok\":true,\"x\":", result->translation.x,
                        ",\"y\":", result->translation.y, "}");
  };
  posts_["/api/sim/obstacle"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const ObstacleRequest request,
                        ParseObstacleRequest(body));
    TL_ASSIGN_OR_RETURN(const std::string name,
                        commands_.AddObstacle(request.pose, request.size_m));
    // Names are ours: letters, digits, dashes.
    return absl::StrCat(R"({"ok":true,"name":")", name, "\"}");
  };
  posts_["/api/sim/remove-obstacle"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const std::string name, ParseNameRequest(body));
    TL_RETURN_IF_ERROR(commands_.RemoveObstacle(name));
    return kOk;
  };
  posts_["/api/sim/fault"] =
      [this](absl::string_view body) -> absl::StatusOr<std::string> {
    TL_ASSIGN_OR_RETURN(const RequestedFault fault, ParseFaultRequest(body));
    TL_RETURN_IF_ERROR(commands_.InjectFault(fault));
    return kOk;
  };
}

std::optional<http::HttpResponse> HttpApi::CheckHead(
    const http::HttpRequest& request) {
  if (request.method == "GET" || request.method == "HEAD") return std::nullopt;
  if (request.method != "POST") {
    // Preflights too: pages of other origins have no business here.
    return Failure(405, "unimplemented", "GET and POST alone are answered");
  }
  if (connect_rpc::ConnectRouter::Owns(request.path))
    return connect_.CheckHead(request);
  if (posts_.find(request.path) == posts_.end()) {
    if (absl::StartsWith(request.path, "/api/sim/")) {
      return Failure(404, "not_found",
                     "there is no such call: the robot is real, or the name is "
                     "wrong");
    }
    return Failure(404, "not_found", "there is no such call");
  }
  if (request.Header("x-treeline") != "1") {
    return Failure(403, "permission_denied",
                   "the header 'X-Treeline: 1' is missing, which shows that no "
                   "page of somebody else asks");
  }
  const absl::string_view type = request.Header("content-type");
  if (!absl::StartsWithIgnoreCase(type, kJson)) {
    return Failure(415, "invalid_argument",
                   "Content-Type must be application/json");
  }
  return std::nullopt;
}

http::HttpResponse HttpApi::Handle(const http::HttpRequest& request) {
  if (request.method == "POST") {
    if (connect_rpc::ConnectRouter::Owns(request.path))
      return connect_.Handle(request);
    const auto post = posts_.find(request.path);
    if (post == posts_.end()) return Error(404);
    const auto answer = post->second(request.body);
    return answer.ok() ? JsonAnswer(*answer) : Failure(answer.status());
  }
  const auto get = gets_.find(request.path);
  if (get != gets_.end()) return get->second();
  if (absl::StartsWith(request.path, "/api/levels/")) {
    return GetLevel(request.path);
  }
  return GetFile(request.path);
}

http::HttpResponse HttpApi::Error(int status) {
  const char* message = "the request cannot be understood";
  if (status == 404) message = "there is no such page";
  if (status == 408) message = "the request took too long";
  if (status == 411) message = "the request has no Content-Length";
  if (status == 413) message = "the request is too large";
  if (status == 431) message = "the request's headers are too large";
  if (status == 500) message = "a fault of the agent";
  return Failure(status, status >= 500 ? "internal" : "invalid_argument",
                 message);
}

std::vector<std::pair<std::string, std::string>> HttpApi::CommonHeaders(
    const http::HttpRequest& /*request*/) {
  return {{"Cache-Control", "no-cache"},
          {"X-Content-Type-Options", "nosniff"},
          {"X-Frame-Options", "DENY"},
          {"Referrer-Policy", "no-referrer"},
          {"Content-Security-Policy",
           "default-src 'self'; img-src 'self' data: blob:; style-src 'self'; "
           "object-src 'none'; base-uri 'none'; frame-ancestors 'none'"}};
}

http::HttpResponse HttpApi::GetState(bool scene) {
  const auto state = commands_.hub().Latest();
  if (state == nullptr) {
    return Failure(absl::UnavailableError("the robot has not begun to step"));
  }
  const auto texts = TextsOf(*state);
  return JsonAnswer(scene ? texts->scene : texts->state);
}

http::HttpResponse HttpApi::GetReady() const {
  AgentHub& hub = commands_.hub();
  const auto before = hub.Latest();
  // A robot that steps publishes while one waits.
  const bool is_ready =
      !hub.is_closed() &&
      hub.WaitForNewer(before == nullptr ? 0 : before->number,
                       absl::Now() + options_.ready_within) != nullptr;
  if (is_ready) return {.content_type = "text/plain", .body = "ready\n"};
  return {.status = 503,
          .content_type = "text/plain",
          .body = hub.is_closed() ? "stopping\n" : "the robot does not step\n"};
}

http::HttpResponse HttpApi::GetLevel(absl::string_view path) {
  absl::ConsumePrefix(&path, "/api/levels/");
  const auto& levels = commands_.info().map->levels.levels;
  const bool is_heights = absl::ConsumeSuffix(&path, ".heights");
  const bool is_known = is_heights || absl::ConsumeSuffix(&path, ".png");
  const std::optional<int> level =
      is_known ? LevelCalled(path, levels.size()) : std::nullopt;
  if (!level.has_value()) {
    return Failure(404, "not_found",
                   absl::StrCat("there is no such level; the map has 0..",
                                levels.size() - 1,
                                ": /api/levels/0.png, /api/levels/0.heights"));
  }
  if (!is_heights) return GetLevelPicture(*level);
  return {.content_type = "application/octet-stream",
          .body = LevelHeights(levels[static_cast<size_t>(*level)])};
}

http::HttpResponse HttpApi::GetLevelPicture(int level) {
  const absl::MutexLock lock(&mutex_);
  const auto known = levels_.find(level);
  if (known != levels_.end()) {
    return {.content_type = "image/png", .body = known->second};
  }
  const auto& levels = commands_.info().map->levels.levels;
  auto png = LevelPng(levels[static_cast<size_t>(level)].grid);
  if (!png.ok()) return Failure(png.status());
  levels_[level] = *png;
  return {.content_type = "image/png", .body = *std::move(png)};
}

http::HttpResponse HttpApi::GetOctomap() {
  const absl::MutexLock lock(&mutex_);
  if (octomap_.empty()) {
    const behavior::NavigatorMap& map = *commands_.info().map;
    octomap_ = OctomapBytes(map.voxels, MapFromVoxels(map.voxels, map.levels));
  }
  return {.content_type = "application/octet-stream", .body = octomap_};
}

http::HttpResponse HttpApi::OpenStream() {
  const auto slot =
      std::make_shared<StreamSlot>(streams_, options_.max_streams);
  if (!slot->is_taken()) {
    return {.status = 503,
            .content_type = kJson,
            .body = ErrorJson("resource_exhausted",
                              "too many pages watch already; close one"),
            .headers = {{"Retry-After", "5"}}};
  }
  return {.content_type = "text/event-stream",
          .stream = [this, slot](http::HttpBodyWriter& writer) {
            RunEventStream(
                commands_.hub(),
                [this](const AgentState& state) { return TextsOf(state); },
                options_.heartbeat, writer);
          }};
}

http::HttpResponse HttpApi::GetFile(const std::string& path) const {
  if (path == "/" && !files_.HasPage()) {
    return {.content_type = "text/plain; charset=utf-8", .body = kNoPage};
  }
  auto file = files_.Get(path);
  if (!file.ok()) return Failure(file.status());
  return {.content_type = file->content_type, .body = std::move(file->bytes)};
}

std::shared_ptr<const StateTexts> HttpApi::TextsOf(const AgentState& state) {
  {
    const absl::MutexLock lock(&mutex_);
    if (texts_ != nullptr && texts_->number == state.number) return texts_;
  }
  auto texts = std::make_shared<StateTexts>();
  texts->number = state.number;
  texts->state = StateJson(StateToProto(commands_.info(), state));
  texts->scene = SceneJson(SceneToProto(state));
  const absl::MutexLock lock(&mutex_);
  if (texts_ == nullptr || texts_->number < texts->number) texts_ = texts;
  return texts;
}

}  // namespace treeline::agent_service
