// URDF as arbitrary bytes: read or refused; what is made of it is a robot.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/urdf/urdf_robot.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view text(reinterpret_cast<const char*>(data), size);
  const auto urdf = treeline::urdf::ParseUrdf(text, "fuzz");
  if (!urdf.ok()) return 0;
  const auto robot = treeline::urdf::RobotOfUrdf(*urdf, {});
  if (robot.ok() && !treeline::core::ParseRobot(robot->yaml, "fuzz").ok()) {
    std::abort();
  }
  return 0;
}
