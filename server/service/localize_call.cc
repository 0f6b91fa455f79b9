#include "server/service/localize_call.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/service/convert.h"
#include "server/service/overload.h"
#include "server/service/worker_pool.h"

namespace treeline::service {
namespace {

constexpr int kMaxCandidateScenes = 1000;

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
  if (!service_.waiting_for_scene_.Enter()) {
    EndIfWaiting(QueueIsFull());
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
    service_.waiting_for_scene_.Leave();
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
  task.give_way = [self] { self->EndIfWaiting(QueueIsFull()); };
  const WorkerPool::Admission admission =
      service_.workers_.Submit(std::move(task));
  switch (admission.verdict) {
    case WorkerPool::Verdict::kAccepted:
      break;
    case WorkerPool::Verdict::kQueueFull:
      return QueueIsFull(admission.retry_after);
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
  absl::StatusOr<v1::LocalizeResponse> response = InternalFault();
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
    service_.waiting_for_scene_.Leave();
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

}  // namespace treeline::service
