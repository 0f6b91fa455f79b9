// Whether a robot is fit to drive, and what to mend if it is not.
#ifndef NAV_AGENT_APP_DOCTOR_DOCTOR_H_
#define NAV_AGENT_APP_DOCTOR_DOCTOR_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/relocalizer/relocalizer.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/calibration/calibration.h"
#include "nav_agent/core/devices.h"

namespace treeline::doctor_app {

enum class Verdict { kOk, kWarn, kFail };
const char* VerdictName(Verdict verdict);

// One thing that was looked at.
struct Finding {
  // "laser", "map: levels" and so on.
  std::string what;
  Verdict verdict = Verdict::kOk;
  // What was found, with its figures.
  std::string found;
  // What to mend; empty if nothing is wrong.
  std::string mend;
};

// What a laser, a base and a camera told while they were listened to.
struct HeardLaser {
  // "laser" or "rear laser".
  std::string name = "laser";
  core::RangeSensorInfo info;
  core::DeviceHealth health;
  double seconds = 0;
  std::vector<core::LaserScan> scans;
};
struct HeardBase {
  core::DeviceHealth health;
  double seconds = 0;
  std::vector<core::BaseReading> readings;
};
struct HeardCamera {
  core::DeviceHealth health;
  double seconds = 0;
  int64_t frames = 0;
  // Of the last frame: the share of pixels with depth, in [0, 1], and the mean
  // of its colour, in [0, 255].
  double depth_share = 0;
  double brightness = 0;
};

std::vector<Finding> JudgeLaser(const HeardLaser& heard);
std::vector<Finding> JudgeBase(const HeardBase& heard);
std::vector<Finding> JudgeCamera(const HeardCamera& heard);
// A recorded drive at `drive` against what the robot's file assumes, or why it
// could not be looked at.
Finding JudgeCalibration(
    const std::string& drive,
    const absl::StatusOr<calibration::Calibration>& calibration);
// `map` as it loaded, or why it did not.
std::vector<Finding> JudgeMap(
    const std::string& path, const absl::StatusOr<behavior::NavigatorMap>& map);
// The scenes of a server as it listed them, and how long that took (s); `scene`
// is the one that is asked for, `version` ours.
std::vector<Finding> JudgeServer(
    const std::string& address, const std::string& scene,
    const std::string& version,
    const absl::StatusOr<std::vector<relocalizer::SceneDescription>>& scenes,
    double round_trip_s);
// Free bytes of the disk that `path` is on.
Finding JudgeDisk(const std::string& path,
                  const absl::StatusOr<uint64_t>& free_bytes);
// The wall clock (s since 1970), and whether the system says that it is
// synchronised.
Finding JudgeClock(double unix_s, bool is_synchronised);

// The worst of them.
Verdict WorstOf(const std::vector<Finding>& findings);
// A line each, and what to mend below it.
std::string FindingsText(const std::vector<Finding>& findings);
// {"verdict","findings":[{"what","verdict","found","mend"}]}
std::string FindingsJson(const std::vector<Finding>& findings);

}  // namespace treeline::doctor_app

#endif  // NAV_AGENT_APP_DOCTOR_DOCTOR_H_
