// What goes wrong with an emulated device, and when.
#ifndef SIMULATION_EMULATORS_FAULT_PLAN_H_
#define SIMULATION_EMULATORS_FAULT_PLAN_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::emulators {

// The faults of one moment.
struct ActiveFaults {
  // Of the connection. Each byte is changed, or lost, with this probability.
  double corrupt = 0;
  double drop = 0;
  // Bytes are sent in pieces of 1 to so many; 0: as they come.
  int split_bytes = 0;
  // Bytes are kept back for so long and then sent all at once.
  double merge_s = 0;
  // Sends nothing at all, but is there.
  bool stuck = false;
  // Is not there.
  bool unplugged = false;
  // Sends noise instead of what it should.
  bool garbage = false;
  // Of the device: a status that it reports (of the laser: 21 to 97), and how
  // much faster than the host's its clock runs.
  int error_status = 0;
  double skew_ppm = 0;

  bool operator==(const ActiveFaults&) const = default;
};

// Faults, each with the time at which it begins and how long it lasts.
class DeviceFaultPlan {
 public:
  DeviceFaultPlan() = default;

  // KIND[:VALUE][@START[+DURATION]], in seconds since the emulator was
  // started; always, or for ever, where that is left out:
  //   corrupt:0.001  drop:0.001  split:7  merge:0.05  stuck  unplug  garbage
  //   error:52  skew:200
  // INVALID_ARGUMENT says what is wrong.
  absl::Status Add(absl::string_view text);
  ActiveFaults At(double elapsed_s) const;

 private:
  struct Fault {
    std::string kind;
    double value = 0;
    double start_s = 0;
    double end_s = 0;
  };
  std::vector<Fault> faults_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_FAULT_PLAN_H_
