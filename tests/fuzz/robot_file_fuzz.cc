// Robots as configuration.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/core/robot_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view text(reinterpret_cast<const char*>(data), size);
  const auto robot = treeline::core::ParseRobot(text, "fuzz");
  // What is read can be driven.
  if (robot.ok() && !robot->Validate().ok()) std::abort();
  return 0;
}
