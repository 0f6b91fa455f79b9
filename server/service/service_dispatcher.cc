#include "server/service/service_dispatcher.h"

#include <algorithm>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"
#include "common/tracing/trace_context.h"
#include "server/repository/names.h"
#include "server/service/convert.h"
#include "server/service/localize_call.h"
#include "server/service/overload.h"

namespace treeline::service {
namespace {

// The reason of an error that brought none.
const char* ReasonOfCode(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
      return "INVALID_REQUEST";
    case absl::StatusCode::kCancelled:
      return "CANCELLED";
    case absl::StatusCode::kDeadlineExceeded:
      return "DEADLINE_EXCEEDED";
    case absl::StatusCode::kUnimplemented:
      return "UNIMPLEMENTED";
    default:
      return "INTERNAL";
  }
}

// Messages about a request start with the path of the field: "frame.depth:
// ...".
std::map<std::string, std::string> FieldOf(const absl::Status& status) {
  const absl::string_view message = status.message();
  const size_t end = message.find(": ");
  if (!absl::IsInvalidArgument(status) || end == absl::string_view::npos ||
      message.substr(0, end).find(' ') != absl::string_view::npos) {
    return {};
  }
  return {{"field", std::string(message.substr(0, end))}};
}

}  // namespace

absl::Status DispatcherOptions::Validate() const {
  const auto check = [](absl::string_view name, int value, int low, int high) {
    if (value >= low && value <= high) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat(name, " is ", value, "; it must be ", low, "..", high));
  };
  TL_RETURN_IF_ERROR(check("number of workers", workers, 0, 1024));
  return check("length of the queue", queue, 1, 100000);
}

ServiceDispatcher::ServiceDispatcher(repository::SceneRepository& repository,
                                     AccessPolicy& access,
                                     CallObserver& observer,
                                     const base::Clock& clock,
                                     const DispatcherOptions& options)
    : repository_(repository),
      access_(access),
      observer_(observer),
      clock_(clock),
      localize_(options.decode_limits, clock),
      recognizer_(repository),
      recent_queries_(options.recent_queries),
      tracer_(options.tracer),
      waiting_for_scene_(options.queue),
      scene_maps_(repository, workers_, waiting_for_scene_, clock),
      workers_(options.workers > 0 ? options.workers : base::HardwareThreads(),
               options.queue, clock) {}

ServiceDispatcher::~ServiceDispatcher() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(
      +[](int* calls) { return *calls == 0; }, &calls_));
}

absl::StatusOr<std::shared_ptr<const repository::Scene>>
ServiceDispatcher::AcquireOnWorker(const std::string& name,
                                   const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const repository::SceneStatus status,
                      repository_.Get(name));
  if (status.serving != nullptr) return repository_.Acquire(name, "", stop);
  const int most = std::max(1, workers_.workers() / 2);
  if (waiting_workers_.fetch_add(1) >= most) {
    waiting_workers_.fetch_sub(1);
    // For the next query.
    repository_.AcquireAsync(name, "", [](const auto&) {});
    return base::WithReason(absl::UnavailableError(absl::StrCat(
                                "scene '", name, "' is being loaded")),
                            "SCENE_NOT_LOADED");
  }
  auto scene = repository_.Acquire(name, "", stop);
  waiting_workers_.fetch_sub(1);
  return scene;
}

absl::StatusOr<Client> ServiceDispatcher::Admit(const CallInfo& call,
                                                Scope scope) {
  return OrReport(call, access_.Admit(call, scope));
}

absl::StatusOr<Client> ServiceDispatcher::Identify(const CallInfo& call,
                                                   Scope scope) {
  return OrReport(call, access_.Identify(call, scope));
}

absl::StatusOr<Client> ServiceDispatcher::OrReport(
    const CallInfo& call, absl::StatusOr<Client> client) {
  if (client.ok()) return client;
  CallRecord record;
  return Report(call, client.status(), record);
}

absl::StatusOr<std::string> ServiceDispatcher::ClientOf(const CallInfo& call,
                                                        Scope scope) {
  if (call.client.has_value()) return *call.client;
  TL_ASSIGN_OR_RETURN(Client client, access_.Admit(call, scope));
  return std::move(client.id);
}

void ServiceDispatcher::CallBegins() {
  absl::MutexLock lock(&mutex_);
  ++calls_;
}

void ServiceDispatcher::CallEnds() {
  absl::MutexLock lock(&mutex_);
  --calls_;
}

void ServiceDispatcher::Localize(CallInfo call,
                                 const v1::LocalizeRequest& request,
                                 Done<v1::LocalizeResponse> done) {
  std::make_shared<LocalizeCall>(*this, std::move(call), request,
                                 std::move(done))
      ->Start();
}

absl::Status ServiceDispatcher::Report(const CallInfo& call,
                                       const absl::Status& status,
                                       CallRecord& record) {
  record.rpc = call.rpc;
  record.transport = call.transport;
  record.peer = call.peer;
  record.trace = tracing::ParseTraceparent(call.traceparent);
  record.span = call.span;
  if (tracer_ != nullptr && !record.span.has_value()) {
    record.span = tracer_->Begin(record.trace);
  }
  record.status =
      base::WithReason(status, ReasonOfCode(status.code()), FieldOf(status));
  record.timings.total_ms =
      base::MillisecondsBetween(call.arrival, clock_.Now());
  observer_.OnCall(record);
  return record.status;
}

void ServiceDispatcher::Reject(const CallInfo& call,
                               const v1::LocalizeRequest& request,
                               const absl::Status& status) {
  CallRecord record;
  record.scene = request.scene().substr(0, repository::kLongestName);
  record.shed = true;
  Report(call, status, record).IgnoreError();
}

template <typename Response, typename Answer>
void ServiceDispatcher::AnswerNow(const CallInfo& call,
                                  const std::string& scene, Scope scope,
                                  const Done<Response>& done, Answer answer) {
  CallRecord record;
  record.scene = scene.substr(0, repository::kLongestName);
  absl::StatusOr<Response> response = [&]() -> absl::StatusOr<Response> {
    TL_ASSIGN_OR_RETURN(record.client, ClientOf(call, scope));
    return answer();
  }();
  const absl::Status status = Report(call, response.status(), record);
  if (status.ok()) {
    done(std::move(response));
  } else {
    done(status);
  }
}

void ServiceDispatcher::ListScenes(CallInfo call, const v1::ListScenesRequest&,
                                   Done<v1::ListScenesResponse> done) {
  AnswerNow<v1::ListScenesResponse>(
      call, "", Scope::kLocalize, done,
      [&]() -> absl::StatusOr<v1::ListScenesResponse> {
        v1::ListScenesResponse response;
        for (const repository::SceneStatus& status : repository_.List()) {
          *response.add_scenes() = ToProto(status);
        }
        return response;
      });
}

void ServiceDispatcher::GetScene(CallInfo call,
                                 const v1::GetSceneRequest& request,
                                 Done<v1::GetSceneResponse> done) {
  AnswerNow<v1::GetSceneResponse>(
      call, request.scene(), Scope::kLocalize, done,
      [&]() -> absl::StatusOr<v1::GetSceneResponse> {
        TL_ASSIGN_OR_RETURN(const repository::SceneStatus status,
                            repository_.Get(request.scene()));
        v1::GetSceneResponse response;
        *response.mutable_scene() = ToProto(status);
        return response;
      });
}

void ServiceDispatcher::LoadScene(CallInfo call,
                                  const v1::LoadSceneRequest& request,
                                  Done<v1::LoadSceneResponse> done) {
  CallRecord record;
  record.scene = request.scene().substr(0, repository::kLongestName);
  absl::StatusOr<std::string> client = ClientOf(call, Scope::kAdmin);
  if (!client.ok()) {
    done(Report(call, client.status(), record));
    return;
  }
  record.client = *std::move(client);
  // Nobody can take the load back; who cancels only does not learn of its end.
  CallBegins();
  repository_.Load(request.scene(), request.model_version(),
                   [this, call = std::move(call), record = std::move(record),
                    done = std::move(done)](
                       absl::StatusOr<repository::SceneStatus> scene) mutable {
                     const absl::Status status =
                         Report(call, scene.status(), record);
                     if (status.ok()) {
                       v1::LoadSceneResponse response;
                       *response.mutable_scene() = ToProto(*scene);
                       done(std::move(response));
                     } else {
                       done(status);
                     }
                     CallEnds();
                   });
}

void ServiceDispatcher::UnloadScene(CallInfo call,
                                    const v1::UnloadSceneRequest& request,
                                    Done<v1::UnloadSceneResponse> done) {
  AnswerNow<v1::UnloadSceneResponse>(
      call, request.scene(), Scope::kAdmin, done,
      [&]() -> absl::StatusOr<v1::UnloadSceneResponse> {
        TL_ASSIGN_OR_RETURN(
            const repository::SceneStatus status,
            repository_.Unload(request.scene(), request.model_version()));
        v1::UnloadSceneResponse response;
        *response.mutable_scene() = ToProto(status);
        return response;
      });
}

void ServiceDispatcher::GetSceneMap(CallInfo call,
                                    const v1::GetSceneMapRequest& request,
                                    Done<v1::GetSceneMapResponse> done) {
  auto record = std::make_shared<CallRecord>();
  record->scene = request.scene().substr(0, repository::kLongestName);
  CallBegins();
  const auto end = [this, call, record, done = std::move(done)](
                       absl::StatusOr<v1::GetSceneMapResponse> response) {
    record->shed = IsShed(response.status());
    const absl::Status status = Report(call, response.status(), *record);
    if (status.ok()) {
      done(std::move(response));
    } else {
      done(status);
    }
    CallEnds();
  };
  absl::StatusOr<std::string> client = ClientOf(call, Scope::kLocalize);
  if (!client.ok()) {
    end(client.status());
    return;
  }
  record->client = *client;
  scene_maps_.Start(
      {.request = request,
       .client = *std::move(client),
       .deadline = call.deadline,
       .stop = call.stop,
       .on_fault =
           [record](const char* what) { record->internal_error = what; },
       .done = end});
}

void ServiceDispatcher::ListRecentQueries(
    CallInfo call, const v1::ListRecentQueriesRequest& request,
    Done<v1::ListRecentQueriesResponse> done) {
  AnswerNow<v1::ListRecentQueriesResponse>(
      call, request.scene(), Scope::kLocalize, done,
      [&]() -> absl::StatusOr<v1::ListRecentQueriesResponse> {
        if (recent_queries_ == nullptr) {
          return base::WithReason(
              absl::FailedPreconditionError(
                  "the server keeps no queries: setting recent_queries is 0"),
              "RECENT_QUERIES_OFF");
        }
        TL_RETURN_IF_ERROR(repository_.Get(request.scene()).status());
        return recent_queries_->Of(request.scene());
      });
}

Load ServiceDispatcher::load() const {
  return {.queued = workers_.queued(),
          .waiting_for_scene = waiting_for_scene_.waiting(),
          .running = workers_.running(),
          .workers = workers_.workers(),
          .queue_capacity = workers_.capacity()};
}

}  // namespace treeline::service
