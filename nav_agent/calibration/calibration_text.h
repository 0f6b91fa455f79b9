// A calibration for people, for programs, and for a robot's file.
#ifndef NAV_AGENT_CALIBRATION_CALIBRATION_TEXT_H_
#define NAV_AGENT_CALIBRATION_CALIBRATION_TEXT_H_

#include <string>
#include <utility>
#include <vector>

#include "nav_agent/calibration/calibration.h"
#include "nav_agent/calibration/camera_calibration.h"

namespace treeline::calibration {

// A table: each number, what was assumed, its uncertainty; what to drive for
// those that the drive does not show; how well wheels and scans agree before
// and after.
std::string CalibrationTable(const Calibration& calibration);

// {"quantities":[{"name","unit","assumed","value","sigma","known"}], ...}
std::string CalibrationJson(const Calibration& calibration);

// What a file of a robot is to say: section (empty: top level), key, value as
// YAML; of what the drive shows alone.
struct FileEntry {
  std::string section;
  std::string key;
  std::string value;
  // For a comment: "+- 0.0021 m".
  std::string uncertainty;
};
// As docs/reference/robots.md has them. The laser is at laser_z_m above the
// ground, which a drive does not show.
std::vector<FileEntry> RobotFileEntries(const Calibration& calibration,
                                        double laser_z_m);
// As the file of --hardware has them: flat.
std::vector<FileEntry> HardwareFileEntries(const Calibration& calibration);

// As the file of --ros2 has them: flat. Turns of its odometry do not follow
// from how far wheels are apart: what was found of the track is a scale of
// turns, by `wheel_track_m`, which the recording was made with.
std::vector<FileEntry> RosFileEntries(const Calibration& calibration,
                                      double wheel_track_m, double laser_z_m);

// The same of a camera.
std::string CameraTable(const CameraCalibration& calibration);
std::vector<FileEntry> CameraFileEntries(const CameraCalibration& calibration);
// Flat; a file of --hardware has no yaw of a camera.
std::vector<FileEntry> CameraHardwareEntries(
    const CameraCalibration& calibration);
std::vector<FileEntry> CameraRosEntries(const CameraCalibration& calibration);

// The entries as YAML with comments, below the comment `title`.
std::string EntriesYaml(const std::vector<FileEntry>& entries,
                        const std::string& title);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_CALIBRATION_TEXT_H_
