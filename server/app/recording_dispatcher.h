// A Dispatcher that keeps the queries that failed.
#ifndef SERVER_APP_RECORDING_DISPATCHER_H_
#define SERVER_APP_RECORDING_DISPATCHER_H_

#include <optional>
#include <string>
#include <utility>

#include "common/tracing/tracer.h"
#include "server/app/failed_query_recorder.h"
#include "server/service/dispatcher.h"

namespace treeline::server_app {

// What a failed query is kept under: NOT_LOCALIZED's reason, or the error's,
// for INVALID_ARGUMENT and INTERNAL. Empty: it is not kept. Never kept is what
// was turned away before it was looked at, so that nobody without a token can
// fill the disk.
std::string ReasonToRecord(const absl::StatusOr<v1::LocalizeResponse>& answer);

// Everything goes to `inner`, and what failed to `recorder` too, before it is
// answered. Nothing of the caller but its trace is kept. All must outlive this;
// `tracer` may be null: calls have no spans of their own.
class RecordingDispatcher final : public service::Dispatcher {
 public:
  RecordingDispatcher(service::Dispatcher& inner, FailedQueryRecorder& recorder,
                      tracing::Tracer* tracer = nullptr)
      : inner_(inner), recorder_(recorder), tracer_(tracer) {}

  absl::StatusOr<service::Client> Admit(const service::CallInfo& call,
                                        service::Scope scope) override {
    return inner_.Admit(call, scope);
  }
  absl::StatusOr<service::Client> Identify(const service::CallInfo& call,
                                           service::Scope scope) override {
    return inner_.Identify(call, scope);
  }
  void Localize(service::CallInfo call, const v1::LocalizeRequest& request,
                Done<v1::LocalizeResponse> done) override;
  void ListScenes(service::CallInfo call, const v1::ListScenesRequest& request,
                  Done<v1::ListScenesResponse> done) override;
  void GetScene(service::CallInfo call, const v1::GetSceneRequest& request,
                Done<v1::GetSceneResponse> done) override;
  void LoadScene(service::CallInfo call, const v1::LoadSceneRequest& request,
                 Done<v1::LoadSceneResponse> done) override;
  void UnloadScene(service::CallInfo call,
                   const v1::UnloadSceneRequest& request,
                   Done<v1::UnloadSceneResponse> done) override;
  void GetSceneMap(service::CallInfo call,
                   const v1::GetSceneMapRequest& request,
                   Done<v1::GetSceneMapResponse> done) override {
    inner_.GetSceneMap(std::move(call), request, std::move(done));
  }
  void ListRecentQueries(service::CallInfo call,
                         const v1::ListRecentQueriesRequest& request,
                         Done<v1::ListRecentQueriesResponse> done) override {
    inner_.ListRecentQueries(std::move(call), request, std::move(done));
  }
  void Reject(const service::CallInfo& call, const v1::LocalizeRequest& request,
              const absl::Status& status) override {
    inner_.Reject(call, request, status);
  }
  service::Load load() const override { return inner_.load(); }

 private:
  void Record(const v1::LocalizeRequest& request,
              const absl::StatusOr<v1::LocalizeResponse>& answer,
              const std::optional<tracing::TraceContext>& trace);

  service::Dispatcher& inner_;
  FailedQueryRecorder& recorder_;
  tracing::Tracer* const tracer_;
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_RECORDING_DISPATCHER_H_
