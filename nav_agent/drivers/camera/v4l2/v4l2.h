// Video4Linux2 behind the driver's interface. Its .cc is the only file that
// talks to the kernel.
#ifndef NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_H_
#define NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_H_

#include <memory>

#include "nav_agent/drivers/camera/v4l2/v4l2_device.h"

namespace treeline::v4l2_camera {

// The kernel's Video4Linux2, with buffers mapped into memory.
std::unique_ptr<V4l2System> MakeV4l2();

}  // namespace treeline::v4l2_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_H_
