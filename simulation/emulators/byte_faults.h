// What a bad cable does to bytes.
#ifndef SIMULATION_EMULATORS_BYTE_FAULTS_H_
#define SIMULATION_EMULATORS_BYTE_FAULTS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "simulation/emulators/fault_plan.h"

namespace treeline::emulators {

// Turns what a device sends into what arrives: the writes to make now. What
// happens to the n-th byte is a function of the seed, of n and of the faults.
class ByteFaults {
 public:
  explicit ByteFaults(uint64_t seed) : seed_(seed) {}

  // To be called regularly, also with no bytes: some may have been kept back.
  std::vector<std::string> Apply(absl::string_view bytes,
                                 const ActiveFaults& faults,
                                 base::MonotonicTime now);
  // The connection was lost, and what was kept back with it.
  void Forget() { held_.clear(); }

 private:
  uint64_t seed_;
  uint64_t bytes_seen_ = 0;
  uint64_t pieces_ = 0;
  std::string held_;
  base::MonotonicTime held_since_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_BYTE_FAULTS_H_
