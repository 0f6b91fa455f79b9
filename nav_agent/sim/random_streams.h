// Random numbers of the simulator: one family for each purpose, in it one
// stream for each step, reading or scan.
#ifndef NAV_AGENT_SIM_RANDOM_STREAMS_H_
#define NAV_AGENT_SIM_RANDOM_STREAMS_H_

#include <cstdint>

#include "common/base/random.h"

namespace treeline {

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

inline Random RandomFor(uint64_t seed, SimRandom purpose, int64_t index) {
  return Random(MixBits(seed + (static_cast<uint64_t>(purpose) << 56)),
                static_cast<uint64_t>(index));
}

}  // namespace treeline

#endif  // NAV_AGENT_SIM_RANDOM_STREAMS_H_
