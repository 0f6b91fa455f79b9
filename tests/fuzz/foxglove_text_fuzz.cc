// What a viewer of the robot may send over Foxglove's WebSocket protocol.
// Arbitrary bytes: no crash, and no more ids than there are bytes.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "absl/strings/string_view.h"
#include "nav_agent/bridge/foxglove/foxglove_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto request = treeline::foxglove::ParseClientText(
      absl::string_view(reinterpret_cast<const char*>(data), size));
  if (request.ok() &&
      request->subscribe.size() + request->unsubscribe.size() > size) {
    std::abort();
  }
  // Why it was refused goes back to the viewer.
  const auto status = nlohmann::json::parse(
      treeline::foxglove::StatusText(treeline::foxglove::StatusLevel::kError,
                                     request.status().message()),
      nullptr, /*allow_exceptions=*/false);
  if (!status.is_object() || status["op"] != "status") std::abort();
  return 0;
}
