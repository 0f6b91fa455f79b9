// While a place is on trial: how many scans fit there, and how far the robot
// has turned.
#ifndef NAV_AGENT_BEHAVIOR_SCAN_WATCH_H_
#define NAV_AGENT_BEHAVIOR_SCAN_WATCH_H_

#include <cstdint>
#include <optional>

#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

// A scan fits if the map explains this share of it and contradicts at most
// that; of fewer judged beams it says nothing.
struct ScanFitLimits {
  double min_explained = 0;
  double max_contradicted = 0;
  int min_judged = 0;
};

enum class ScanVerdict : uint8_t { kNothingNew, kGood, kBad };

// Judges each scan of the tracker once, where the tracker has the robot then.
// Not thread-safe.
class ScanWatch {
 public:
  // The newest scan, if it was not judged before. Not counted yet.
  ScanVerdict Watch(const localization::RobotTracker& tracker,
                    const ScanFitLimits& limits);
  // The scan that there is now is not judged any more.
  void SkipNewest(const localization::RobotTracker& tracker) {
    last_ = tracker.ScanStamp();
  }

  void Count(ScanVerdict verdict);
  // Good ones in a row: a bad one takes back all good ones.
  void CountInRow(ScanVerdict verdict);
  void ForgetCounts();
  int good() const { return good_; }
  int bad() const { return bad_; }

 private:
  std::optional<base::MonotonicTime> last_;
  int good_ = 0;
  int bad_ = 0;
};

// By how much the robot turns, to either side. Not thread-safe.
class TurnMeter {
 public:
  // Since the call before, at least 0 (rad); the first says 0.
  double Add_rad(double yaw_rad);
  void Reset() { last_yaw_rad_.reset(); }

 private:
  std::optional<double> last_yaw_rad_;
};

// AMCL's particles have gathered at one place: at least this share of the
// weight is there, within this standard deviation, and it does not look
// everywhere. Whether it is the right one of several is not asked.
bool IsPoseGathered(const localization::RobotTracker& tracker, double min_share,
                    double max_std_m);
// The same, and no other place is possible.
bool IsPoseTight(const localization::RobotTracker& tracker, double min_share,
                 double max_std_m);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SCAN_WATCH_H_
