// Pictures of a synthetic world for the simulator's camera.
#ifndef SIMULATION_SIMULATOR_IMAGER_H_
#define SIMULATION_SIMULATOR_IMAGER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "simulation/simulator/simulated_devices.h"

namespace treeline::simulator {

// Prepares the light of `world` (a second or two), if it is to be lit. Pictures
// are `scale` (in [0.1, 1]) times as wide and high as the camera's own, of the
// same view. threads < 1: all.
absl::StatusOr<std::shared_ptr<const Imager>> MakeImager(
    const worlds::World& world, uint64_t seed, double scale, bool is_lit,
    int threads);

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_IMAGER_H_
