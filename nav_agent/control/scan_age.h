// How old the newest scan of a laser may be.
#ifndef NAV_AGENT_CONTROL_SCAN_AGE_H_
#define NAV_AGENT_CONTROL_SCAN_AGE_H_

#include <algorithm>

#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// A scan is as old as it took to measure when it comes, and the next one comes
// as much later, and late by half of that: older, and it is missing (s).
inline double OldestScan_s(const core::RangeSensorInfo& laser) {
  constexpr double kScans = 2.5;
  return kScans * laser.scan_interval_s;
}

// The same to drive by, whatever a laser says of itself (a driver may state any
// time between scans): a person walks a metre in a second.
inline double OldestScanToDriveBy_s(const core::RangeSensorInfo& laser) {
  constexpr double kLongest_s = 1;
  return std::min(OldestScan_s(laser), kLongest_s);
}

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SCAN_AGE_H_
