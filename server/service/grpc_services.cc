#include "server/service/grpc_services.h"

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "common/base/error_info.h"
#include "server/service/grpc_call.h"
#include "server/service/grpc_message.h"

namespace treeline::service {
namespace {

// For a request to arrive whole, once its call has been let in; and for an
// answer to be taken.
constexpr std::chrono::seconds kTransferTimeout{60};
// Answers that are larger are counted. Poses are far smaller: they are never
// turned away for what others do not take.
constexpr size_t kLargeAnswer = 16384;
// A request for which there is no memory tries again so often, so many times.
constexpr std::chrono::milliseconds kRetryPause{10};
constexpr int kMaxRetries = 100;

// One unary call in flight. Lives until gRPC is done with it.
template <typename Request, typename Response>
class UnaryCall final
    : public grpc_server::RawReactor,
      public std::enable_shared_from_this<UnaryCall<Request, Response>> {
 public:
  using Method = void (Dispatcher::*)(CallInfo, const Request&,
                                      Dispatcher::Done<Response>);

  UnaryCall(grpc::CallbackServerContext& context, Dispatcher& dispatcher,
            Method method, const CallSource& source, DeadlineTimer& timer)
      : context_(context),
        dispatcher_(dispatcher),
        method_(method),
        source_(source),
        timer_(timer),
        lease_(source.budget),
        answer_lease_(source.answers) {}

  // To be called once, on one that a shared_ptr owns.
  void Start(const char* rpc, Scope scope) {
    self_ = this->shared_from_this();
    call_ = CallInfoFrom(context_, rpc, source_, stop_.get_token());
    const absl::StatusOr<Client> client = dispatcher_.Admit(call_, scope);
    if (!client.ok()) {
      Finish(FinishStatus(client.status(), context_));
      return;
    }
    call_.client = client->id;
    LimitTransfer();
    StartRead(&bytes_);
  }

 private:
  // The call ends if what begins now takes too long.
  void LimitTransfer() {
    const std::weak_ptr<UnaryCall> weak = this->weak_from_this();
    // On the timer's own clock.
    timer_key_ =
        timer_.Arm(std::chrono::steady_clock::now() + kTransferTimeout, [weak] {
          if (const auto self = weak.lock()) {
            self->context_.TryCancel();
          }
        });
  }

  void OnReadDone(bool ok) override {
    timer_.Disarm(*timer_key_);
    if (!ok) {
      Finish(FinishStatus(base::WithReason(absl::InvalidArgumentError(
                                               "the call has no request"),
                                           "INVALID_REQUEST"),
                          context_));
      return;
    }
    call_.arrival = source_.clock.Now();
    Take();
  }

  // Parses the request, now or when there is memory for it.
  void Take() {
    const absl::Status taken = TakeMessage(bytes_, lease_, request_);
    if (absl::IsUnavailable(taken) && ++tries_ <= kMaxRetries &&
        !context_.IsCancelled()) {
      const std::shared_ptr<UnaryCall> self = this->shared_from_this();
      timer_.Arm(std::chrono::steady_clock::now() + kRetryPause,
                 [self] { self->Take(); });
      return;
    }
    if (!taken.ok()) {
      if (absl::IsUnavailable(taken)) {
        dispatcher_.Reject(call_, v1::LocalizeRequest(), taken);
      }
      Finish(FinishStatus(taken, context_));
      return;
    }
    (dispatcher_.*method_)(
        std::move(call_), request_,
        [this](const absl::StatusOr<Response>& response) { Answer(response); });
  }

  void Answer(const absl::StatusOr<Response>& response) {
    // A client that takes its time, or does not take its answer at all, holds
    // no memory that others' requests need.
    request_ = Request();
    lease_.Release();
    absl::Status answered = response.status();
    if (answered.ok()) {
      bytes_ = BytesOf(*response);
      if (bytes_.Length() > kLargeAnswer &&
          !answer_lease_.Resize(bytes_.Length())) {
        bytes_.Clear();
        answered = base::NoMemoryForRequest();
      }
    }
    const grpc::Status status = FinishStatus(answered, context_);
    if (!status.ok()) {
      Finish(status);
      return;
    }
    LimitTransfer();
    StartWriteAndFinish(&bytes_, grpc::WriteOptions(), status);
  }

  // gRPC calls this when the client cancels or goes away, and when the
  // deadline passes.
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override {
    if (timer_key_.has_value()) timer_.Disarm(*timer_key_);
    // Gone with the last that holds it, at the end of this at the earliest.
    const std::shared_ptr<UnaryCall> self = std::move(self_);
  }

  grpc::CallbackServerContext& context_;
  Dispatcher& dispatcher_;
  const Method method_;
  const CallSource& source_;
  DeadlineTimer& timer_;
  std::shared_ptr<UnaryCall> self_;
  std::stop_source stop_;
  std::optional<DeadlineTimer::Key> timer_key_;
  CallInfo call_;
  int tries_ = 0;
  // Of the request, then of the answer.
  grpc::ByteBuffer bytes_;
  base::ByteLease lease_;
  base::ByteLease answer_lease_;
  Request request_;
};

template <typename Request, typename Response>
grpc_server::RawService::MakeReactor Unary(
    Dispatcher& dispatcher,
    void (Dispatcher::*method)(CallInfo, const Request&,
                               Dispatcher::Done<Response>),
    const char* rpc, Scope scope, const CallSource& source,
    DeadlineTimer& timer) {
  return [&dispatcher, method, rpc, scope, &source,
          &timer](grpc::CallbackServerContext* context) {
    const auto call = std::make_shared<UnaryCall<Request, Response>>(
        *context, dispatcher, method, source, timer);
    call->Start(rpc, scope);
    return call.get();
  };
}

}  // namespace

RelocalizationGrpcService::RelocalizationGrpcService(Dispatcher& dispatcher,
                                                     const CallSource& source)
    : dispatcher_(dispatcher), source_(source) {
  AddRawMethod("/treeline.v1.RelocalizationService/Localize",
               Unary(dispatcher_, &Dispatcher::Localize, "Localize",
                     Scope::kLocalize, source_, timer_));
  AddRawMethod("/treeline.v1.RelocalizationService/LocalizeStream",
               [this](grpc::CallbackServerContext* context) {
                 return streams_.Begin(*context, dispatcher_, source_);
               });
}

SceneGrpcService::SceneGrpcService(Dispatcher& dispatcher,
                                   const CallSource& source)
    : dispatcher_(dispatcher), source_(source) {
  AddRawMethod("/treeline.v1.SceneService/ListScenes",
               Unary(dispatcher_, &Dispatcher::ListScenes, "ListScenes",
                     Scope::kLocalize, source_, timer_));
  AddRawMethod("/treeline.v1.SceneService/GetScene",
               Unary(dispatcher_, &Dispatcher::GetScene, "GetScene",
                     Scope::kLocalize, source_, timer_));
  AddRawMethod("/treeline.v1.SceneService/LoadScene",
               Unary(dispatcher_, &Dispatcher::LoadScene, "LoadScene",
                     Scope::kAdmin, source_, timer_));
  AddRawMethod("/treeline.v1.SceneService/UnloadScene",
               Unary(dispatcher_, &Dispatcher::UnloadScene, "UnloadScene",
                     Scope::kAdmin, source_, timer_));
  AddRawMethod("/treeline.v1.SceneService/GetSceneMap",
               Unary(dispatcher_, &Dispatcher::GetSceneMap, "GetSceneMap",
                     Scope::kLocalize, source_, timer_));
  AddRawMethod("/treeline.v1.SceneService/ListRecentQueries",
               Unary(dispatcher_, &Dispatcher::ListRecentQueries,
                     "ListRecentQueries", Scope::kLocalize, source_, timer_));
}

}  // namespace treeline::service
