// Laser logs and relations, as arbitrary bytes: no crash, and no log that
// contradicts itself.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/recording/laser_log.h"
#include "nav_agent/recording/relations.h"

namespace treeline {
namespace {

bool IsFinitePose(const geometry::Rigid2& pose) {
  return std::isfinite(pose.translation.x) &&
         std::isfinite(pose.translation.y) && std::isfinite(pose.yaw_rad);
}

void CheckLog(const recording::LaserLog& log) {
  if (log.scans.empty() || !IsFinitePose(log.base_from_laser)) std::abort();
  for (size_t i = 0; i < log.scans.size(); ++i) {
    const recording::RecordedScan& scan = log.scans[i];
    if (static_cast<int>(scan.ranges_m.size()) != log.laser.beams ||
        !IsFinitePose(scan.odom_from_base)) {
      std::abort();
    }
    if (i > 0 && scan.stamp < log.scans[i - 1].stamp) std::abort();
    for (const float range_m : scan.ranges_m) {
      if (range_m < 0) std::abort();
    }
  }
}

void Parse(absl::string_view text) {
  if (const auto log = recording::ParseLaserLog(text, "fuzz"); log.ok()) {
    CheckLog(*log);
    // What is written can be read.
    if (!recording::ParseLaserLog(recording::FormatCarmenLog(*log), "back")
             .ok())
      std::abort();
  }
  if (const auto relations = recording::ParseRelations(text, "fuzz");
      relations.ok()) {
    for (const recording::PoseRelation& relation : *relations) {
      if (!IsFinitePose(relation.from_base_from_to_base)) std::abort();
    }
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
