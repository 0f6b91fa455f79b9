// The picture of a calibration.
#ifndef NAV_AGENT_APP_CALIBRATE_CALIBRATION_PICTURE_H_
#define NAV_AGENT_APP_CALIBRATE_CALIBRATION_PICTURE_H_

#include "common/image/image.h"
#include "nav_agent/calibration/calibration.h"

namespace treeline::calibrate_app {

// Left: the way by wheels as assumed (orange), as calibrated (blue), and by
// scans (grey). Right: what wheels and scans differ by in each stretch of the
// drive, ahead, to the side and in yaw, before (orange) and after (blue).
image::ColorImage DrawCalibration(const calibration::Drive& drive,
                                  const calibration::Calibration& found);

}  // namespace treeline::calibrate_app

#endif  // NAV_AGENT_APP_CALIBRATE_CALIBRATION_PICTURE_H_
