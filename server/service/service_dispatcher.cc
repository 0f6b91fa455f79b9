#include "server/service/service_dispatcher.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/error_info.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"
#include "server/repository/names.h"
#include "server/service/convert.h"
#include "server/service/trace_context.h"

namespace treeline::service {
namespace {

constexpr int kMaxCandidateScenes = 1000;

constexpr char kInternalFault[] =
    "a fault of the server; its log has the details";

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

// Whether a call that no worker had begun was ended by too much work.
bool IsShed(const absl::Status& status) {
  const std::string reason = base::ErrorInfoOf(status).reason;
  return reason == "QUEUE_FULL" || reason == "DEADLINE_UNREACHABLE" ||
         absl::IsDeadlineExceeded(status);
}

// Whether it says in one way which scene it may be.
absl::Status CheckSceneChoice(const v1::LocalizeRequest& request) {
  if (request.scene().empty() && request.options().has_prior()) {
    return absl::InvalidArgumentError(
        "options.prior: is a pose in a scene, and no scene is named");
  }
  if (request.scene().empty() && !request.model_version().empty()) {
    return absl::InvalidArgumentError(
        "model_version: is of a scene, and no scene is named");
  }
  if (request.candidate_scenes().empty()) return absl::OkStatus();
  if (!request.scene().empty()) {
    return absl::InvalidArgumentError(
        "candidate_scenes: are for requests that name no scene");
  }
  if (request.candidate_scenes_size() > kMaxCandidateScenes) {
    return absl::InvalidArgumentError(
        absl::StrCat("candidate_scenes: ", request.candidate_scenes_size(),
                     " of them; at most ", kMaxCandidateScenes));
  }
  for (const std::string& candidate : request.candidate_scenes()) {
    if (const absl::Status valid =
            repository::CheckName("candidate_scenes", candidate);
        !valid.ok()) {
      return valid;
    }
  }
  return absl::OkStatus();
}

// What ended a call before it could be answered.
absl::Status WhyStopped(const CallInfo& call, base::MonotonicTime now,
                        absl::string_view where) {
  if (now >= call.deadline) {
    return absl::DeadlineExceededError(
        absl::StrCat("the deadline passed ", where));
  }
  return absl::CancelledError(absl::StrCat("the call was cancelled ", where));
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

// One query. Shared by whoever may end it next: the repository, a worker, the
// timer, the client. The first to claim it does so.
class ServiceDispatcher::LocalizeCall final
    : public std::enable_shared_from_this<LocalizeCall> {
 public:
  LocalizeCall(ServiceDispatcher& service, CallInfo call,
               const v1::LocalizeRequest& request,
               Done<v1::LocalizeResponse> done)
      : service_(service),
        call_(std::move(call)),
        request_(request),
        done_(std::move(done)) {
    service_.CallBegins();
    client_stop_ = std::exchange(call_.stop, stop_.get_token());
    record_.scene = request.scene().substr(0, repository::kLongestName);
    record_.request_bytes = request.ByteSizeLong();
  }
  ~LocalizeCall() { service_.CallEnds(); }

  void Start();

 private:
  // kWaiting: nobody works on it; whoever moves it on from there owns it.
  enum class Stage { kWaiting, kRunning, kEnded };

  absl::Status Admit();
  void UseScene(absl::StatusOr<std::shared_ptr<const repository::Scene>> scene);
  absl::Status Enqueue();
  void Work();
  void OnStop();
  void EndIfWaiting(const absl::Status& status);
  void End(absl::StatusOr<v1::LocalizeResponse> response);
  bool Claim(Stage stage) {
    Stage waiting = Stage::kWaiting;
    return stage_.compare_exchange_strong(waiting, stage);
  }

  ServiceDispatcher& service_;
  CallInfo call_;
  const v1::LocalizeRequest& request_;
  Done<v1::LocalizeResponse> done_;
  CallRecord record_;
  std::string client_;
  std::shared_ptr<const repository::Scene> scene_;

  std::atomic<Stage> stage_{Stage::kWaiting};
  std::atomic<bool> counted_as_waiting_{false};
  absl::Mutex mutex_;
  std::optional<uint64_t> ticket_ ABSL_GUARDED_BY(mutex_);
  std::optional<DeadlineTimer::Key> timer_key_ ABSL_GUARDED_BY(mutex_);

  std::stop_source stop_;
  std::stop_token client_stop_;
  std::optional<std::stop_callback<std::function<void()>>> on_client_stop_;
};

void ServiceDispatcher::LocalizeCall::Start() {
  if (const absl::Status admitted = Admit(); !admitted.ok()) {
    EndIfWaiting(admitted);
    return;
  }
  const std::weak_ptr<LocalizeCall> weak = weak_from_this();
  const auto on_stop = [weak] {
    if (const auto self = weak.lock()) self->OnStop();
  };
  if (call_.deadline != base::MonotonicTime::max()) {
    absl::MutexLock lock(&mutex_);
    timer_key_ = service_.timer_.Arm(call_.deadline, on_stop);
  }
  // Runs at once if the client has gone already.
  on_client_stop_.emplace(client_stop_, on_stop);
  if (stage_ != Stage::kWaiting) return;
  if (service_.waiting_for_scene_.fetch_add(1) >=
      service_.workers_.capacity()) {
    service_.waiting_for_scene_.fetch_sub(1);
    EndIfWaiting(base::WithRetryAfter(
        base::WithReason(
            absl::UnavailableError("overloaded: the queue is full"),
            "QUEUE_FULL"),
        std::chrono::milliseconds(100)));
    return;
  }
  counted_as_waiting_ = true;
  if (request_.scene().empty()) {
    // Which it is, is found out on a worker.
    UseScene(std::shared_ptr<const repository::Scene>());
    return;
  }
  service_.repository_.AcquireAsync(
      request_.scene(), request_.model_version(),
      [self = shared_from_this()](
          absl::StatusOr<std::shared_ptr<const repository::Scene>> scene) {
        self->UseScene(std::move(scene));
      });
}

absl::Status ServiceDispatcher::LocalizeCall::Admit() {
  TL_ASSIGN_OR_RETURN(client_, service_.ClientOf(call_, Scope::kLocalize));
  record_.client = client_;
  TL_RETURN_IF_ERROR(CheckOptions(request_.options()));
  TL_RETURN_IF_ERROR(CheckSceneChoice(request_));
  if (request_.options().has_time_budget_ms()) {
    call_.deadline =
        std::min(call_.deadline,
                 call_.arrival +
                     std::chrono::duration_cast<base::MonotonicTime::duration>(
                         std::chrono::duration<double, std::milli>(
                             request_.options().time_budget_ms())));
  }
  return absl::OkStatus();
}

void ServiceDispatcher::LocalizeCall::UseScene(
    absl::StatusOr<std::shared_ptr<const repository::Scene>> scene) {
  if (counted_as_waiting_.exchange(false)) {
    service_.waiting_for_scene_.fetch_sub(1);
  }
  if (!scene.ok()) {
    EndIfWaiting(scene.status());
    return;
  }
  scene_ = *std::move(scene);
  if (const absl::Status queued = Enqueue(); !queued.ok()) EndIfWaiting(queued);
}

absl::Status ServiceDispatcher::LocalizeCall::Enqueue() {
  if (stage_ != Stage::kWaiting) return absl::OkStatus();
  const auto self = shared_from_this();
  WorkerPool::Task task;
  task.client = client_;
  if (scene_ != nullptr) task.kind = scene_->name;
  task.deadline = call_.deadline;
  task.run = [self] { self->Work(); };
  const auto full = [](std::chrono::milliseconds retry_after) {
    return base::WithRetryAfter(
        base::WithReason(
            absl::UnavailableError("overloaded: the queue is full"),
            "QUEUE_FULL"),
        retry_after);
  };
  task.give_way = [self, full] {
    self->EndIfWaiting(full(std::chrono::milliseconds(100)));
  };
  const WorkerPool::Admission admission =
      service_.workers_.Submit(std::move(task));
  switch (admission.verdict) {
    case WorkerPool::Verdict::kAccepted:
      break;
    case WorkerPool::Verdict::kQueueFull:
      return full(admission.retry_after);
    case WorkerPool::Verdict::kTooLate:
      return base::WithRetryAfter(
          base::WithReason(absl::UnavailableError(
                               "overloaded: the deadline would pass before the "
                               "answer"),
                           "DEADLINE_UNREACHABLE"),
          admission.retry_after);
  }
  {
    absl::MutexLock lock(&mutex_);
    ticket_ = admission.ticket;
  }
  // It may have been stopped before it had a ticket to give back.
  if (stage_ == Stage::kEnded) service_.workers_.Withdraw(admission.ticket);
  return absl::OkStatus();
}

void ServiceDispatcher::LocalizeCall::Work() {
  if (!Claim(Stage::kRunning)) return;
  absl::StatusOr<v1::LocalizeResponse> response =
      absl::InternalError(kInternalFault);
  try {
    if (scene_ != nullptr) {
      response = service_.localize_.Handle(request_, *scene_, call_, record_);
    } else {
      response = service_.localize_.HandleAmong(
          request_, service_.recognizer_,
          [this](const std::string& name) {
            return service_.AcquireOnWorker(name, call_.stop);
          },
          call_, record_);
    }
  } catch (const std::exception& error) {
    record_.internal_error = error.what();
  } catch (...) {
    record_.internal_error = "an exception of unknown type";
  }
  End(std::move(response));
}

void ServiceDispatcher::LocalizeCall::OnStop() {
  // Whoever works on it sees this, and ends it.
  stop_.request_stop();
  EndIfWaiting(WhyStopped(call_, service_.clock_.Now(), "in the queue"));
}

void ServiceDispatcher::LocalizeCall::EndIfWaiting(const absl::Status& status) {
  if (!Claim(Stage::kEnded)) return;
  std::optional<uint64_t> ticket;
  {
    absl::MutexLock lock(&mutex_);
    ticket = ticket_;
  }
  if (ticket) service_.workers_.Withdraw(*ticket);
  if (counted_as_waiting_.exchange(false)) {
    service_.waiting_for_scene_.fetch_sub(1);
  }
  record_.shed = IsShed(status);
  record_.timings.queue_ms =
      base::MillisecondsBetween(call_.arrival, service_.clock_.Now());
  End(status);
}

void ServiceDispatcher::LocalizeCall::End(
    absl::StatusOr<v1::LocalizeResponse> response) {
  stage_ = Stage::kEnded;
  std::optional<DeadlineTimer::Key> timer_key;
  {
    absl::MutexLock lock(&mutex_);
    timer_key = timer_key_;
  }
  if (timer_key) service_.timer_.Disarm(*timer_key);
  const absl::Status status =
      service_.Report(call_, response.status(), record_);
  if (status.ok()) {
    done_(std::move(response));
  } else {
    done_(status);
  }
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
      scene_maps_(repository, workers_, clock),
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
  record.trace = ParseTraceparent(call.traceparent);
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
  scene_maps_.Start({.request = request,
                     .client = *std::move(client),
                     .deadline = call.deadline,
                     .stop = call.stop,
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
          .waiting_for_scene = waiting_for_scene_,
          .running = workers_.running(),
          .workers = workers_.workers(),
          .queue_capacity = workers_.capacity()};
}

}  // namespace treeline::service
