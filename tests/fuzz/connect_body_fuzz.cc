// Bodies of Connect calls, JSON and binary, as arbitrary bytes: no crash, what
// is refused is an error of the client's, and what is accepted survives being
// written and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "server/gateway/connect_routes.h"
#include "server/gateway/json_message.h"
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
  const treeline::gateway::ConnectRoutes routes(dispatcher, false, clock);
  treeline::http::HttpRequest request;
  request.method = "POST";
  request.path = "/treeline.v1.RelocalizationService/Localize";
  request.body.assign(reinterpret_cast<const char*>(data), size);
  for (const char* type : {"application/json", "application/proto"}) {
    request.headers["content-type"] = type;
    Check(routes.Handle(request));
  }
  treeline::v1::LocalizeRequest message;
  if (!treeline::gateway::MessageFromJson(request.body, message).ok()) return 0;
  const auto json = treeline::gateway::JsonFromMessage(message);
  if (!json.ok()) return 0;
  treeline::v1::LocalizeRequest again;
  if (!treeline::gateway::MessageFromJson(*json, again).ok()) std::abort();
  return 0;
}
