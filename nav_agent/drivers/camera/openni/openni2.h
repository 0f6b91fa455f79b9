// OpenNI2 behind the driver's interface. Its .cc is the only file that knows
// OpenNI2.
#ifndef NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI2_H_
#define NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI2_H_

#include <memory>

#include "common/base/clock.h"
#include "nav_agent/drivers/camera/openni/openni_device.h"

namespace treeline::openni_camera {

// OpenNI2 itself, loaded when the first device is opened. `clock` outlives it.
std::unique_ptr<OpenNiSystem> MakeOpenNi2(const base::Clock& clock);

}  // namespace treeline::openni_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI2_H_
