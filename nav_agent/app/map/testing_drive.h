// A recorded drive in a box, for tests.
#ifndef NAV_AGENT_APP_MAP_TESTING_DRIVE_H_
#define NAV_AGENT_APP_MAP_TESTING_DRIVE_H_

#include <string>

namespace treeline::map_app {

// Half the length and width of the box (m), and its height.
inline constexpr double kBoxX_m = 3;
inline constexpr double kBoxY_m = 2.5;
inline constexpr double kBoxZ_m = 2.4;

struct BoxDrive {
  // Turns once round on the spot in so many seconds.
  double seconds = 12;
  // 0: without a camera.
  double frames_hz = 2;
};

// Writes the agent log of a robot in the middle of a closed box: 180 beams at
// 20 Hz, wheels, pictures of 80 x 60 pixels, and the truth.
void RecordBoxDrive(const std::string& path, const BoxDrive& drive);

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_TESTING_DRIVE_H_
