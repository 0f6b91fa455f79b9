// Where a scan was taken, among a few others and about where odometry has it.
#ifndef NAV_AGENT_MAPPING_WINDOW_MATCHER_H_
#define NAV_AGENT_MAPPING_WINDOW_MATCHER_H_

#include <cstdint>
#include <span>

#include "nav_agent/mapping/laser_slam_options.h"
#include "nav_agent/mapping/scan_matcher.h"

namespace treeline::mapping {

// What a scan matched, and how widely it had to be searched for.
struct WindowMatch {
  ScanMatch match;
  int searched_widely = 0;
  int found_widely = 0;
};

// The scan among references, near to a guess; and, if it responds by less than
// `enough` there, farther from it. The options' matcher and wide searches.
WindowMatch MatchInWindow(std::span<const PlacedScan> references,
                          const ScanOutline& scan,
                          const geometry::Rigid2& guess,
                          const MatchSearch& search, double enough,
                          const LaserSlamOptions& options);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_WINDOW_MATCHER_H_
