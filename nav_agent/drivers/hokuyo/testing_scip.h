// Replies as a sensor sends them, for tests.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_TESTING_SCIP_H_
#define NAV_AGENT_DRIVERS_HOKUYO_TESTING_SCIP_H_

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "nav_agent/drivers/hokuyo/scip_codec.h"
#include "nav_agent/drivers/hokuyo/scip_replies.h"

namespace treeline::hokuyo {

// All that a UTM-30LX-EW measures.
inline ScanCommand FullScan(ScanContent content = ScanContent::kDistance) {
  return {.continuous = true,
          .content = content,
          .first_step = 0,
          .last_step = 1080};
}

// A scan whose every number is different from its neighbours.
inline ScipScan ExampleScan(ScanContent content, int64_t time_ms = 123456) {
  ScipScan scan = {.time_ms = time_ms, .codes = {}, .intensities = {}};
  for (uint32_t i = 0; i < 1081; ++i) {
    scan.codes.push_back(1000 + (i * 7919) % 20000);
    if (content == ScanContent::kDistanceAndIntensity) {
      scan.intensities.push_back(static_cast<uint16_t>((i * 31) % 5000));
    }
  }
  return scan;
}

inline std::string ReplyText(absl::string_view echo, absl::string_view status,
                             absl::string_view rest = "\n") {
  return absl::StrCat(echo, "\n", ScipLine(status), rest);
}

inline std::string ScanText(const ScanCommand& command, const ScipScan& scan) {
  return ReplyText(command.Text(), command.continuous ? "99" : "00",
                   EncodeScan(scan, command.content));
}

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_TESTING_SCIP_H_
