// Scans between keyscans: where they were taken, and what they saw.
#ifndef NAV_AGENT_MAPPING_BETWEEN_SCANS_H_
#define NAV_AGENT_MAPPING_BETWEEN_SCANS_H_

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/mapping/keyscan.h"
#include "nav_agent/mapping/odometry_doubt.h"
#include "nav_agent/mapping/scan_bundle.h"
#include "nav_agent/mapping/scan_outline.h"
#include "nav_agent/mapping/scan_surfels.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::mapping {

// The keyscan of a scan of which nobody knows where it was taken.
inline constexpr size_t kNowhere = std::numeric_limits<size_t>::max();

// A scan's place, tied to the keyscan before it so that it moves with it.
struct ScanPlace {
  recording::RecordingTime stamp;
  size_t keyscan = 0;  // or kNowhere
  geometry::Rigid2 keyscan_from_base;
  double climb_m = 0;  // since the keyscan
  geometry::Rotation3 level_from_base;
  double way_m = 0;  // in odometry, turns too
};

// Scans that are no keyscans. What is kept of one is a hundred surfels or so,
// of 16 bytes each.
class BetweenScans {
 public:
  explicit BetweenScans(const ScanBundleOptions& options) : options_(options) {}

  // `place`: its number among all, above those of scans added before.
  void Add(size_t place, const ScanOutline& scan) {
    scans_.push_back(
        {.place = place, .surfels = SurfelsOf(scan, options_.surfels)});
  }

  // Once keyscans are where they belong: lays these scans upon those, from
  // where odometry, bent to lead from one keyscan to the next, has them, and
  // spreads what that corrects over the scans that were not kept. Keyscans
  // farther apart than max_gap_m in height, or inclined to each other by more
  // than max_tilt, see different things. Places of other keyscans than those
  // given stay as they are.
  void Refine(std::span<Keyscan> keyscans, const OdometryDoubt& doubt,
              double max_gap_m, double max_tilt,
              std::span<ScanPlace> places) const;

 private:
  struct Scan {
    size_t place = 0;
    std::vector<Surfel> surfels;
  };

  const ScanBundleOptions options_;
  std::vector<Scan> scans_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_BETWEEN_SCANS_H_
