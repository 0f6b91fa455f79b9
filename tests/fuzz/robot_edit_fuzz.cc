// A calibration put into a file of any bytes: what comes out says what it is to
// say, or nothing comes out.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "absl/strings/string_view.h"
#include "nav_agent/calibration/robot_file_edit.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view text(reinterpret_cast<const char*>(data), size);
  const std::vector<treeline::calibration::FileEntry> entries = {
      {"", "wheel_track_m", "0.5562", ""},
      {"odometry", "left_scale", "1.0100", ""},
      {"laser", "at", "[0.2600, -0.0400, 0.3500]", ""}};
  const auto edited = treeline::calibration::WithEntries(text, "fuzz", entries);
  if (!edited.ok()) return 0;
  // Once more changes nothing.
  const auto again =
      treeline::calibration::WithEntries(*edited, "fuzz", entries);
  if (!again.ok() || *again != *edited) std::abort();
  return 0;
}
