// OpenNI2 itself, as far as it goes without a camera: it is loaded, and says
// that there is none.
#include "nav_agent/drivers/camera/openni/openni2.h"

#include "gtest/gtest.h"
#include "nav_agent/drivers/camera/openni/openni_device.h"

namespace treeline::openni_camera {
namespace {

TEST(OpenNi2, ACameraThatIsNotThereIsReported) {
  base::SteadyClock clock;
  const auto system = MakeOpenNi2(clock);
  const auto device = system->Open({.uri = "no/such/device"});
  ASSERT_FALSE(device.ok());
  EXPECT_EQ(device.status().code(), absl::StatusCode::kNotFound)
      << device.status();
}

}  // namespace
}  // namespace treeline::openni_camera
