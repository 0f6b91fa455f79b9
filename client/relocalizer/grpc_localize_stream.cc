#include "client/relocalizer/grpc_localize_stream.h"

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include <deque>
#include <functional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "client/relocalizer/convert.h"
#include "common/base/clock.h"
#include "common/wire/status.h"

namespace treeline::relocalizer {
namespace {

class GrpcLocalizeStream final : public LocalizeStream {
 public:
  GrpcLocalizeStream(const Connection& connection,
                     v1::RelocalizationService::Stub& stub,
                     const StreamOptions& options)
      : connection_(connection), options_(options) {
    connection_.Prepare(context_, options_.scene, options_.traceparent);
    stream_ = stub.LocalizeStream(&context_);
    on_stop_.emplace(options_.stop, [this] { context_.TryCancel(); });
  }

  ~GrpcLocalizeStream() override {
    on_stop_.reset();
    if (finished_) return;
    context_.TryCancel();
    v1::LocalizeStreamResponse rest;
    while (stream_->Read(&rest)) {
    }
    stream_->Finish().error_code();
  }

  bool Send(uint64_t id, const LocalizeQuery& query) override {
    v1::LocalizeStreamRequest request;
    request.set_id(id);
    *request.mutable_localize() = ToProto(query);
    if (first_) {
      request.mutable_settings()->set_drop_oldest(options_.drop_oldest);
      request.mutable_settings()->set_max_pending(options_.max_pending);
      first_ = false;
    }
    {
      absl::MutexLock lock(&mutex_);
      sent_.push_back({.id = id, .at = clock_.Now()});
    }
    return stream_->Write(request);
  }

  void FinishSending() override { stream_->WritesDone(); }

  std::optional<StreamAnswer> Receive() override {
    v1::LocalizeStreamResponse response;
    if (!stream_->Read(&response)) return std::nullopt;
    const base::MonotonicTime now = clock_.Now();
    StreamAnswer received{.id = response.id(), .answer = AnswerOf(response)};
    absl::MutexLock lock(&mutex_);
    if (sent_.empty() || sent_.front().id != response.id()) {
      received.answer = absl::InternalError(
          absl::StrCat("the server's answer is not valid: it is to frame ",
                       response.id(), ", which is not the next one"));
    } else {
      if (received.answer.ok()) {
        received.answer->round_trip_ms =
            base::MillisecondsBetween(sent_.front().at, now);
      }
      sent_.pop_front();
    }
    return received;
  }

  absl::Status Finish() override {
    finished_ = true;
    return wire::FromGrpc(stream_->Finish());
  }

 private:
  struct Sent {
    uint64_t id = 0;
    base::MonotonicTime at = {};
  };

  static absl::StatusOr<LocalizeAnswer> AnswerOf(
      const v1::LocalizeStreamResponse& response) {
    switch (response.result_case()) {
      case v1::LocalizeStreamResponse::kResponse:
        return FromProto(response.response());
      case v1::LocalizeStreamResponse::kError: {
        const absl::Status error = wire::FromProto(response.error());
        if (!error.ok()) return error;
        break;
      }
      default:
        break;
    }
    return absl::InternalError(
        "the server's answer is not valid: neither an answer nor an error");
  }

  const Connection connection_;
  const StreamOptions options_;
  const base::SteadyClock clock_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriterInterface<v1::LocalizeStreamRequest,
                                                    v1::LocalizeStreamResponse>>
      stream_;
  std::optional<std::stop_callback<std::function<void()>>> on_stop_;
  bool first_ = true;  // of the sending thread
  bool finished_ = false;
  absl::Mutex mutex_;
  // What has no answer yet.
  std::deque<Sent> sent_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<LocalizeStream> OpenGrpcStream(
    const Connection& connection, v1::RelocalizationService::Stub& stub,
    const StreamOptions& options) {
  return std::make_unique<GrpcLocalizeStream>(connection, stub, options);
}

}  // namespace treeline::relocalizer
