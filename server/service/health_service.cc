#include "server/service/health_service.h"

#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "server/service/grpc_message.h"

namespace treeline::service {
namespace {

using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

// A name of a service is shorter.
constexpr size_t kMaxRequestBytes = 1024;
// At a time: anybody may watch the whole server.
constexpr size_t kMaxWatchers = 1000;

grpc::ByteBuffer HealthResponse(ServingStatus status) {
  HealthCheckResponse response;
  response.set_status(status);
  const grpc::Slice slice(response.SerializeAsString());
  return grpc::ByteBuffer(&slice, 1);
}

}  // namespace

absl::StatusOr<std::string> DecodeHealthRequest(absl::string_view bytes) {
  HealthCheckRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return base::WithReason(
        absl::InvalidArgumentError("the request is not a HealthCheckRequest"),
        "INVALID_REQUEST");
  }
  return std::move(*request.mutable_service());
}

// One Check or one Watch. Lives until gRPC is done with it.
class HealthGrpcService::Call final
    : public grpc_server::RawReactor,
      public std::enable_shared_from_this<HealthGrpcService::Call> {
 public:
  Call(HealthGrpcService& service, grpc::CallbackServerContext& context,
       bool is_watch)
      : service_(service), context_(context), is_watch_(is_watch) {}

  void Start() {
    self_ = shared_from_this();
    StartRead(&bytes_);
  }

  // Says what has changed, once gRPC has taken what was said before.
  void Tell() {
    {
      absl::MutexLock lock(&mutex_);
      if (is_writing_ || is_finished_) return;
      const ServingStatus status = service_.Get(name_);
      if (told_ == status) return;
      told_ = status;
      is_writing_ = true;
      outgoing_ = HealthResponse(status);
    }
    StartWrite(&outgoing_);
  }

 private:
  void OnReadDone(bool ok) override {
    std::vector<grpc::Slice> slices;
    if (!ok || bytes_.Length() > kMaxRequestBytes ||
        !bytes_.Dump(&slices).ok()) {
      End(base::WithReason(
          absl::InvalidArgumentError("not a request for health"),
          "INVALID_REQUEST"));
      return;
    }
    std::string bytes;
    for (const grpc::Slice& slice : slices) {
      absl::StrAppend(&bytes, absl::string_view(
                                  reinterpret_cast<const char*>(slice.begin()),
                                  slice.size()));
    }
    absl::StatusOr<std::string> name = DecodeHealthRequest(bytes);
    absl::Status status = name.status();
    if (status.ok()) status = service_.MayAsk(context_, *name);
    if (!status.ok()) {
      End(status);
      return;
    }
    name_ = *std::move(name);
    is_watch_ ? Watch() : Check();
  }

  void Check() {
    const ServingStatus status = service_.Get(name_);
    if (status == HealthCheckResponse::SERVICE_UNKNOWN) {
      End(absl::NotFoundError("service name unknown"));
      return;
    }
    {
      absl::MutexLock lock(&mutex_);
      if (std::exchange(is_finished_, true)) return;
    }
    outgoing_ = HealthResponse(status);
    StartWriteAndFinish(&outgoing_, grpc::WriteOptions(), grpc::Status::OK);
  }

  void Watch() {
    if (service_.Watch(this)) {
      Tell();
    } else {
      End(absl::ResourceExhaustedError("too many watch already"));
    }
  }

  void OnWriteDone(bool ok) override {
    std::optional<absl::Status> end;
    {
      absl::MutexLock lock(&mutex_);
      is_writing_ = false;
      end = std::exchange(end_, std::nullopt);
    }
    if (end.has_value()) {
      Finish(FinishStatus(*end, context_));
    } else if (!ok) {
      End(absl::CancelledError("the client has gone"));
    } else {
      Tell();
    }
  }

  void OnCancel() override { End(absl::CancelledError("cancelled")); }

  void End(const absl::Status& status) {
    {
      absl::MutexLock lock(&mutex_);
      if (std::exchange(is_finished_, true)) return;
      // gRPC wants no end while it is still being given what to write.
      if (is_writing_) {
        end_ = status;
        return;
      }
    }
    Finish(FinishStatus(status, context_));
  }

  void OnDone() override {
    service_.Unwatch(this);
    // Gone with the last that holds it, at the end of this at the earliest.
    const std::shared_ptr<Call> self = std::move(self_);
  }

  HealthGrpcService& service_;
  grpc::CallbackServerContext& context_;
  const bool is_watch_;
  std::shared_ptr<Call> self_;
  grpc::ByteBuffer bytes_;
  std::string name_;

  // Of the write under way, or of the answer of Check.
  grpc::ByteBuffer outgoing_;
  absl::Mutex mutex_;
  bool is_writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_finished_ ABSL_GUARDED_BY(mutex_) = false;
  // How it ends once the write is done.
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
  std::optional<ServingStatus> told_ ABSL_GUARDED_BY(mutex_);
};

HealthGrpcService::HealthGrpcService(Dispatcher& dispatcher,
                                     const CallSource& source)
    : dispatcher_(dispatcher), source_(source) {
  for (const bool is_watch : {false, true}) {
    AddRawMethod(
        absl::StrCat("/grpc.health.v1.Health/", is_watch ? "Watch" : "Check"),
        [this, is_watch](grpc::CallbackServerContext* context) {
          const auto call = std::make_shared<Call>(*this, *context, is_watch);
          call->Start();
          return call.get();
        });
  }
}

absl::Status HealthGrpcService::MayAsk(
    const grpc::CallbackServerContext& context, const std::string& name) {
  if (name.empty()) return absl::OkStatus();
  const CallInfo call = CallInfoFrom(context, "Health", source_, {});
  return dispatcher_
      .Identify(call, source_.admin_listener ? Scope::kAdmin : Scope::kLocalize)
      .status();
}

ServingStatus HealthGrpcService::Get(const std::string& name) {
  absl::MutexLock lock(&mutex_);
  const auto found = serving_.find(name);
  if (found == serving_.end()) return HealthCheckResponse::SERVICE_UNKNOWN;
  return found->second && !stopped_ ? HealthCheckResponse::SERVING
                                    : HealthCheckResponse::NOT_SERVING;
}

void HealthGrpcService::Set(const std::string& name, bool is_serving) {
  {
    absl::MutexLock lock(&mutex_);
    serving_[name] = is_serving;
  }
  TellWatchers();
}

void HealthGrpcService::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stopped_ = true;
  }
  TellWatchers();
}

bool HealthGrpcService::Watch(Call* call) {
  absl::MutexLock lock(&mutex_);
  if (watchers_.size() >= kMaxWatchers) return false;
  watchers_[call] = call->weak_from_this();
  return true;
}

void HealthGrpcService::Unwatch(Call* call) {
  absl::MutexLock lock(&mutex_);
  watchers_.erase(call);
}

void HealthGrpcService::TellWatchers() {
  std::vector<std::shared_ptr<Call>> watchers;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [address, call] : watchers_) {
      watchers.push_back(call.lock());
    }
  }
  for (const auto& call : watchers) {
    if (call != nullptr) call->Tell();
  }
}

}  // namespace treeline::service
