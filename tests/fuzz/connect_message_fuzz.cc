// Bodies of Connect calls as arbitrary bytes, in both formats and in envelopes:
// no crash, what is refused is an error of the client's, and what is accepted
// survives being written and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "absl/strings/string_view.h"
#include "common/connect_rpc/connect_message.h"
#include "treeline/v1/navigation.pb.h"

namespace {

void Check(bool holds) {
  if (!holds) std::abort();
}

void CheckMessage(bool is_json, absl::string_view bytes) {
  treeline::v1::NavigateRequest message;
  const absl::Status parsed =
      treeline::connect_rpc::ParseConnectMessage(is_json, bytes, message);
  if (!parsed.ok()) {
    Check(absl::IsInvalidArgument(parsed) && !parsed.message().empty());
    return;
  }
  const auto written =
      treeline::connect_rpc::WriteConnectMessage(is_json, message);
  if (!written.ok()) return;
  treeline::v1::NavigateRequest again;
  Check(treeline::connect_rpc::ParseConnectMessage(is_json, *written, again)
            .ok());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view body(reinterpret_cast<const char*>(data), size);
  const auto inside = treeline::connect_rpc::OutOfEnvelope(body);
  if (inside.ok()) {
    Check(treeline::connect_rpc::InEnvelope(*inside) == body);
  } else {
    Check(!inside.status().message().empty());
  }
  for (const bool is_json : {false, true}) {
    CheckMessage(is_json, body);
    if (inside.ok()) CheckMessage(is_json, *inside);
  }
  treeline::connect_rpc::ConnectFormatOf(body);
  return 0;
}
