#include "server/gateway/connect_services.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/gateway/call_headers.h"
#include "server/gateway/pending_call.h"

namespace treeline::gateway {
namespace {

std::string PathOf(const char* service, const char* rpc) {
  return absl::StrCat("/treeline.v1.", service, "/", rpc);
}

// What all methods need to make their calls. They keep copies.
struct Context {
  service::Dispatcher& dispatcher;
  const bool admin_listener;
  const base::Clock& clock;
};

template <typename Request, typename Response>
void Add(
    const Context& context, const char* service, const char* rpc,
    service::Scope scope,
    void (service::Dispatcher::*method)(service::CallInfo, const Request&,
                                        service::Dispatcher::Done<Response>),
    connect_rpc::ConnectRouter& router) {
  router.AddUnary<Request>(
      PathOf(service, rpc),
      [context, rpc, method](
          const connect_rpc::ConnectCall& about,
          const Request& request) -> absl::StatusOr<Response> {
        TL_ASSIGN_OR_RETURN(
            service::CallInfo call,
            CallInfoOf(about.request, rpc, context.admin_listener));
        return CallAndWait(context.dispatcher, method, std::move(call), request,
                           about.request.socket, context.clock);
      },
      [context, rpc, scope](http::HttpRequest& request) {
        return AdmitRequest(context.dispatcher, rpc, scope,
                            context.admin_listener, context.clock, request);
      });
}

}  // namespace

void AddConnectServices(service::Dispatcher& dispatcher, bool admin_listener,
                        const base::Clock& clock,
                        connect_rpc::ConnectRouter& router) {
  using service::Dispatcher;
  using service::Scope;
  constexpr char kRelocalization[] = "RelocalizationService";
  constexpr char kScenes[] = "SceneService";
  const Context context{dispatcher, admin_listener, clock};
  Add(context, kRelocalization, "Localize", Scope::kLocalize,
      &Dispatcher::Localize, router);
  Add(context, kScenes, "ListScenes", Scope::kLocalize, &Dispatcher::ListScenes,
      router);
  Add(context, kScenes, "GetScene", Scope::kLocalize, &Dispatcher::GetScene,
      router);
  Add(context, kScenes, "LoadScene", Scope::kAdmin, &Dispatcher::LoadScene,
      router);
  Add(context, kScenes, "UnloadScene", Scope::kAdmin, &Dispatcher::UnloadScene,
      router);
  Add(context, kScenes, "GetSceneMap", Scope::kLocalize,
      &Dispatcher::GetSceneMap, router);
  Add(context, kScenes, "ListRecentQueries", Scope::kLocalize,
      &Dispatcher::ListRecentQueries, router);
  router.AddUnimplemented(
      PathOf(kRelocalization, "LocalizeStream"),
      "LocalizeStream is served over gRPC and as a WebSocket; "
      "in calls, call Localize for each frame");
}

}  // namespace treeline::gateway
