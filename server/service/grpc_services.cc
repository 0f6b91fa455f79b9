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

// For a request to arrive whole, once its call has been let in.
constexpr std::chrono::seconds kReadTimeout{60};
// A request for which there is no memory tries again so often, so many times.
constexpr std::chrono::milliseconds kRetryPause{10};
constexpr int kMaxRetries = 100;

// One unary call in flight. Lives until gRPC is done with it.
template <typename Request, typename Response>
class UnaryCall final
    : public RawReactor,
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
        lease_(source.budget) {}

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
    const std::weak_ptr<UnaryCall> weak = this->weak_from_this();
    // On the timer's own clock.
    timer_key_ =
        timer_.Arm(std::chrono::steady_clock::now() + kReadTimeout, [weak] {
          if (const auto self = weak.lock()) {
            self->context_.TryCancel();
          }
        });
    StartRead(&bytes_);
  }

 private:
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
    const grpc::Status status = FinishStatus(response.status(), context_);
    if (!status.ok()) {
      Finish(status);
      return;
    }
    bytes_ = BytesOf(*response);
    StartWriteAndFinish(&bytes_, grpc::WriteOptions(), status);
  }

  // gRPC calls this when the client cancels or goes away, and when the
  // deadline passes.
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override {
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
  Request request_;
};

template <typename Request, typename Response>
RawService::MakeReactor Unary(
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
