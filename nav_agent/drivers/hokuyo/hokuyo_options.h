// What a laser driver is told about its sensor.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_OPTIONS_H_
#define NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_OPTIONS_H_

#include <cstdint>
#include <numbers>

#include "absl/status/status.h"
#include "nav_agent/drivers/stream/backoff.h"

namespace treeline::hokuyo {

struct HokuyoOptions {
  // Which beams are asked for (laser frame, counter-clockwise from straight
  // ahead); what the sensor does not see is left out. [-2 pi, 2 pi].
  double angle_min_rad = -std::numbers::pi;
  double angle_max_rad = std::numbers::pi;
  // So many neighbouring beams become one, the nearest of them. [1, 99]
  int cluster = 1;
  // So many scans are left out after each that is sent. [0, 9]
  int skipped_scans = 0;
  // Intensities as well (ME instead of MD): twice the bytes.
  bool intensities = false;
  // Asks for every scan on its own (GD, GE) instead of once for all. Slower;
  // for sensors or connections that lose continuous data.
  bool single_shot = false;
  // Info().range_max_m is this or what the sensor says, whichever is smaller.
  // A UTM-30LX tells up to 60 m and guarantees 30 m.
  double max_range_m = 30;

  // Uses TM to learn the sensor's clock; without it, scans are taken to have
  // arrived assumed_delay_s after their stamp at the fastest.
  bool time_sync = true;
  double assumed_delay_s = 0.02;
  // Added to every stamp: what a calibration against another sensor finds.
  double stamp_offset_s = 0;

  // How long an answer may take, and the first scan (the mirror spins up),
  // before the sensor is given up and reached anew.
  double reply_timeout_s = 0.5;
  double first_scan_timeout_s = 5;
  // For so long no good scan may come before the laser counts as lost. More
  // than three scans' time. [0.1, 10]
  double silence_timeout_s = 0.5;
  // Reboots the sensor (RB) when it reports broken hardware. It takes half a
  // minute, and sometimes helps.
  bool reboot_on_fault = false;

  stream::BackoffOptions backoff;
  uint64_t seed = 1;  // of the back-off

  absl::Status Validate() const;
};

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_OPTIONS_H_
