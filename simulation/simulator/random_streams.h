// Random numbers of the simulator: one family for each purpose, in it one
// stream for each step, reading or scan.
#ifndef SIMULATION_SIMULATOR_RANDOM_STREAMS_H_
#define SIMULATION_SIMULATOR_RANDOM_STREAMS_H_

#include <cstdint>

#include "common/base/random.h"

namespace treeline::simulator {

enum class SimRandom : uint64_t {
  kSystematic = 1,
  kWheels,
  kSlip,
  kInertial,
  kInertialBias,
  kFault,
  kLaser,
  kCamera,
  kRearLaser
};

inline base::Random RandomFor(uint64_t seed, SimRandom purpose, int64_t index) {
  return base::Random(
      base::MixBits(seed + (static_cast<uint64_t>(purpose) << 56)),
      static_cast<uint64_t>(index));
}

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_RANDOM_STREAMS_H_
