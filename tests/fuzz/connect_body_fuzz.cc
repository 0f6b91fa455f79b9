// Bodies of Connect calls, JSON and binary, as arbitrary bytes: no crash, what
// is refused is an error of the client's, and what is accepted survives being
// written and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>

#include "common/base/clock.h"
#include "common/connect_rpc/connect_router.h"
#include "common/connect_rpc/json_message.h"
#include "common/http/http_message.h"
#include "server/gateway/connect_services.h"
#include "server/gateway/testing_dispatcher.h"
#include "treeline/v1/relocalization.pb.h"

namespace {

void Check(const treeline::http::HttpResponse& response) {
  if (response.status != 200 && response.status != 400) std::abort();
  if (response.content_type.empty()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const treeline::base::SteadyClock clock{};
  treeline::gateway::TestingDispatcher dispatcher;
  treeline::connect_rpc::ConnectRouter router(
      clock, {.max_request_bytes = std::numeric_limits<size_t>::max()});
  treeline::gateway::AddConnectServices(dispatcher, false, clock, router);
  treeline::http::HttpRequest request;
  request.method = "POST";
  request.path = "/treeline.v1.RelocalizationService/Localize";
  request.body.assign(reinterpret_cast<const char*>(data), size);
  for (const char* type : {"application/json", "application/proto"}) {
    request.headers["content-type"] = type;
    Check(router.Handle(request));
  }
  treeline::v1::LocalizeRequest message;
  if (!treeline::connect_rpc::MessageFromJson(request.body, message).ok())
    return 0;
  const auto json = treeline::connect_rpc::JsonFromMessage(message);
  if (!json.ok()) return 0;
  treeline::v1::LocalizeRequest again;
  if (!treeline::connect_rpc::MessageFromJson(*json, again).ok()) std::abort();
  return 0;
}
