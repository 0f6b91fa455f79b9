// What the commands of emulated devices share.
#ifndef SIMULATION_EMULATORS_APP_DEVICE_SERVER_H_
#define SIMULATION_EMULATORS_APP_DEVICE_SERVER_H_

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "simulation/emulators/emulator_server.h"

namespace treeline::emulator_app {

// From --listen, --fault and --seed. Errors of ParseDeviceAddress and
// DeviceFaultPlan::Add.
absl::StatusOr<emulators::EmulatorServerOptions> ServerOptionsOf(
    const std::string& listen, const std::vector<std::string>& faults,
    uint64_t seed);

// Returns when `stop` is requested.
void WaitForStop(const std::stop_token& stop);

}  // namespace treeline::emulator_app

#endif  // SIMULATION_EMULATORS_APP_DEVICE_SERVER_H_
