// Whether a robot that maps has been carried off: scans that cannot be of where
// it thinks it is, one after another.
#ifndef NAV_AGENT_MAPPING_CARRY_WATCH_H_
#define NAV_AGENT_MAPPING_CARRY_WATCH_H_

#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/mapping/keyscan.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::mapping {

struct CarryWatchOptions {
  // A scan is looked at more closely if it responds by so much less than scans
  // usually do.
  double poor_response = 0.15;
  // It is in doubt if of what it and the last keyscans tell of each other so
  // much stands where the other looked through ...
  double max_contradicted = 0.2;
  // (of a robot that stands, for others may walk about before it, so much)
  double max_contradicted_standing = 0.4;
  // ... or if it matches elsewhere than where odometry has it, and responds by
  // so much less than usual: somewhere it always fits a little. Once a scan is
  // in doubt, only one that matches about as usual where odometry has it ends
  // that: by chance another fits, or says nothing.
  double very_poor_response = 0.2;
  // Fewer points say nothing.
  int min_told = 100;
  // A robot on its wheels does not tilt further than this (rad).
  double lifted_rad = 0.35;
  // So many scans in doubt, and nothing else for so long (s), are a carry.
  int min_scans = 5;
  double min_s = 0.3;
  // While the wheels stand, a scan is looked at if this share of its beams has
  // changed by changed_m since the last that was.
  double changed_share = 0.5;
  double changed_m = 0.3;

  bool IsValid() const;
};

// Not thread-safe.
class CarryWatch {
 public:
  explicit CarryWatch(const CarryWatchOptions& options) : options_(options) {}

  // What is known of a scan that was looked at.
  struct Evidence {
    double response = 0;
    double usual_response = 0;
    // The wheels stand, so that only people or a carry change what is seen.
    bool stands = false;
    // It matches somewhere else than where odometry has it.
    bool is_found_widely = false;
    geometry::Rotation3 level_from_base;
    // Asked only if the scan responds poorly.
    std::span<const Keyscan> keyscans;
    const ScanOutline* scan = nullptr;
    geometry::Rigid2 map_from_base;
  };
  // Whether the scan cannot be of where it is thought to be.
  bool IsDoubtful(const Evidence& evidence) const;

  // One that was looked at, at `stamp`. True: the robot was carried off.
  bool Add(bool is_doubtful, recording::RecordingTime stamp);
  bool in_doubt() const { return scans_ > 0; }
  // Of the first scan in doubt.
  recording::RecordingTime since() const { return since_; }
  void Reset() { scans_ = 0; }

  // Whether the surroundings have changed since the last scan that was noted.
  bool HasChanged(std::span<const float> ranges_m) const;
  void Note(std::span<const float> ranges_m) {
    noted_m_.assign(ranges_m.begin(), ranges_m.end());
  }

 private:
  CarryWatchOptions options_;
  int scans_ = 0;
  recording::RecordingTime since_;
  std::vector<float> noted_m_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_CARRY_WATCH_H_
