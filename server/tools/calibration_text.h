// A calibration as a person reads it.
#ifndef SERVER_TOOLS_CALIBRATION_TEXT_H_
#define SERVER_TOOLS_CALIBRATION_TEXT_H_

#include <string>

#include "server/core/training/rgbd_calibrator.h"

namespace treeline::tools {

// A few lines: the cameras, the offset, and what the fit improved.
std::string CalibrationText(const training::CalibrationReport& report);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_CALIBRATION_TEXT_H_
