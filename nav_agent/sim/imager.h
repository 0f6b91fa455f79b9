// Pictures of a synthetic world for the simulator's camera.
#ifndef NAV_AGENT_SIM_IMAGER_H_
#define NAV_AGENT_SIM_IMAGER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "nav_agent/sim/simulated_devices.h"

namespace treeline {

// Prepares the light of `world` (a second or two), if it is to be lit. Pictures
// are `scale` (in [0.1, 1]) times as wide and high as the camera's own, of the
// same view. threads < 1: all.
absl::StatusOr<std::shared_ptr<const Imager>> MakeImager(
    const World& world, uint64_t seed, double scale, bool is_lit, int threads);

}  // namespace treeline

#endif  // NAV_AGENT_SIM_IMAGER_H_
