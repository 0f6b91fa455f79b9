#include "simulation/emulators/app/device_server.h"

#include <chrono>

#include "common/base/status_macros.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::emulator_app {

absl::StatusOr<emulators::EmulatorServerOptions> ServerOptionsOf(
    const std::string& listen, const std::vector<std::string>& faults,
    uint64_t seed) {
  emulators::EmulatorServerOptions options = {
      .listen = {}, .faults = {}, .seed = seed};
  TL_ASSIGN_OR_RETURN(options.listen, emulators::ParseDeviceAddress(listen));
  for (const std::string& fault : faults) {
    TL_RETURN_IF_ERROR(options.faults.Add(fault));
  }
  return options;
}

void WaitForStop(const std::stop_token& stop) {
  while (!stream::StopRequestedWithin(std::chrono::hours(1), stop)) {
  }
}

}  // namespace treeline::emulator_app
