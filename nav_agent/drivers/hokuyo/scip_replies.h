// What the replies of a Hokuyo sensor say.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_SCIP_REPLIES_H_
#define NAV_AGENT_DRIVERS_HOKUYO_SCIP_REPLIES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/drivers/hokuyo/scip_codec.h"
#include "nav_agent/drivers/hokuyo/scip_parser.h"

namespace treeline::hokuyo {

// PP: what the sensor measures. Defaults: UTM-30LX-EW.
struct ScipParameters {
  std::string model = "UTM-30LX-EW";  // MODL
  int min_mm = 23;                    // DMIN
  int max_mm = 60000;                 // DMAX
  int steps_per_turn = 1440;          // ARES
  int first_step = 0;                 // AMIN
  int last_step = 1080;               // AMAX
  int front_step = 540;               // AFRT
  int turns_per_minute = 2400;        // SCAN

  bool operator==(const ScipParameters&) const = default;
};

// VV: which sensor it is.
struct ScipVersion {
  std::string vendor = {};    // VEND
  std::string product = {};   // PROD
  std::string firmware = {};  // FIRM
  std::string protocol = {};  // PROT
  std::string serial = {};    // SERI
};

// DATA_LOSS for lines whose check sum or form is wrong, INVALID_ARGUMENT for
// parameters that no sensor can have.
absl::StatusOr<ScipParameters> DecodeParameters(const ScipReply& reply);
absl::StatusOr<ScipVersion> DecodeVersion(const ScipReply& reply);
// II: its STAT, such as "Sensor works well."; empty if it does not say.
absl::StatusOr<std::string> DecodeCondition(const ScipReply& reply);
// TM1: milliseconds, [0, kScipTimeSpan_ms).
absl::StatusOr<int64_t> DecodeTime(const ScipReply& reply);

// The lines of those replies after echo and status, for emulators; the last
// one is empty, and ends the reply.
std::string EncodeParameters(const ScipParameters& parameters);
std::string EncodeVersion(const ScipVersion& version);

// A scan as it was sent.
struct ScipScan {
  int64_t time_ms = 0;
  // One for each step: millimetres, or what is wrong (see RangeOfCode).
  std::vector<uint32_t> codes;
  std::vector<uint16_t> intensities;  // or empty
};

// Reads the lines of a reply to `command`: the time, then data. `scan` is
// overwritten (its memory is used again). DATA_LOSS if a check sum, a
// character, the length of a line, or the number of steps is wrong: any one
// changed, lost or added byte is found. (Two changes in one line pass the
// six-bit check sum once in 64 times.)
absl::Status DecodeScan(const ScipReply& reply, const ScanCommand& command,
                        ScipScan& scan);
// Time, data and the empty line that ends the reply, for emulators.
std::string EncodeScan(const ScipScan& scan, ScanContent content);

// The range that a number stands for (m, or one of REP 117's): 1 is no echo,
// 2 and 4 too near, 3 interference from another sensor, 0 and 5 other errors;
// below min_mm too near; from max_mm on no return.
float RangeOfCode(uint32_t code, const ScipParameters& parameters);
// The number that stands for a range, for emulators.
uint32_t CodeOfRange(float range_m, const ScipParameters& parameters);

// How the scans that answer `command` lie: step s looks towards
// (s - front_step) * 2 pi / steps_per_turn. `command` must lie within the
// parameters.
core::RangeSensorInfo InfoOf(const ScipParameters& parameters,
                             const ScanCommand& command);

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_SCIP_REPLIES_H_
