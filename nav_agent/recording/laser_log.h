// Recordings of a robot that drove about with a planar laser scanner.
#ifndef NAV_AGENT_RECORDING_LASER_LOG_H_
#define NAV_AGENT_RECORDING_LASER_LOG_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::recording {

struct RecordedOdometry {
  RecordingTime stamp;
  geometry::Rigid2 odom_from_base;
};

struct RecordedScan {
  RecordingTime stamp;
  // Where wheels say that the robot was at that time.
  geometry::Rigid2 odom_from_base;
  // One for each beam (m), kNoReturn or kInvalidRange; see LaserLogOptions.
  std::vector<float> ranges_m;
};

struct LaserLog {
  // Geometry of all scans. No log says when each beam was measured:
  // beam_interval_s is 0.
  core::RangeSensorInfo laser;
  geometry::Rigid2 base_from_laser;
  // In the order of time; stamps never decrease.
  std::vector<RecordedScan> scans;
  // Readings of odometry that came without a scan, in the order of time.
  std::vector<RecordedOdometry> odometry;
  // What is odd about the recording, a sentence each.
  std::vector<std::string> warnings{};
};

struct LaserLogOptions {
  // Ranges of at least this (m, above 0) are kNoReturn: scanners of SICK write
  // 81.83 for none. Ranges of at most range_min_m (0 or more) are
  // kInvalidRange.
  double range_min_m = 0.02;
  double range_max_m = 80;
  // Lines that are out of order by at most this are put in order (s, 0 or
  // more). More means that a clock has jumped back: all later stamps are moved
  // on by as much, so that time goes on, and a warning says so.
  double reorder_s = 1.0;

  absl::Status Validate() const;
};

// At most this many beams a scan, and bytes a log (after decompression).
inline constexpr int kMaxLogBeams = 16384;
inline constexpr size_t kMaxLogBytes = size_t{1} << 30;

// Reads a recording; the format is found from what is in the file:
// * JSON, {"map": {"<time stamp>": {"range": [...], "theta": t, "x": x, "y":
//   y}}}, m and rad, as the 910 scans of the Intel Research Lab are kept;
// * CARMEN logs: FLASER, ROBOTLASER1 and ODOM lines, others are passed over
//   (carmen.sourceforge.net, "logger");
// * the course logs of Wean Hall: L and O lines, cm and rad.
// Any of them may be compressed (gzip). JSON and FLASER do not tell where the
// beams are: they begin at -90 degrees, 1 degree apart where there are 180 or
// 181, 0.5 degrees with 360 or 361, and otherwise spread over 180 degrees.
//
// The errors of ReadFile, or INVALID_ARGUMENT with file and line: no scans,
// not finite numbers, different numbers of beams, a clock that jumps more often
// than clocks do.
absl::StatusOr<LaserLog> ReadLaserLog(const std::string& path,
                                      const LaserLogOptions& options = {});

// The same for bytes in memory, called `name` in errors. Safe on any bytes:
// memory is at most a small multiple of them, or of kMaxLogBytes if they are
// compressed.
absl::StatusOr<LaserLog> ParseLaserLog(absl::string_view bytes,
                                       const std::string& name,
                                       const LaserLogOptions& options = {});

// `log` in CARMEN's format (ROBOTLASER1 and ODOM), which holds all of it but
// for stamps below a microsecond and range_min_m.
std::string FormatCarmenLog(const LaserLog& log);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_LASER_LOG_H_
