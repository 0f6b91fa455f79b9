#include "nav_agent/app/map/calibrated_log.h"

#include <chrono>
#include <utility>

#include "common/base/status_macros.h"
#include "nav_agent/app/calibrate/calibrate_run.h"
#include "nav_agent/calibration/calibration_text.h"

namespace treeline::map_app {

absl::StatusOr<CalibratedLog> CalibratedLog::Make(const std::string& log,
                                                  const std::string& robot,
                                                  const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(base::TemporaryFolder folder,
                      base::TemporaryFolder::Make("treeline-calibrated"));
  CalibratedLog made(std::move(folder));
  absl::StatusOr<calibrate_app::CalibrateResult> result =
      calibrate_app::RunCalibration(
          {.log = log, .robot = robot, .corrected = made.path()}, stop);
  if (!result.ok()) {
    return base::Annotate(result.status(), "--calibrate");
  }
  made.has_gyroscope_ = result->calibration.gyroscope.has_value();
  if (result->calibration.noise.has_value()) {
    made.noise_ = result->calibration.noise->noise;
  }
  made.scan_delay_ =
      std::chrono::duration_cast<recording::RecordingTime::duration>(
          std::chrono::duration<double>(
              result->calibration.found.laser_delay_s));
  made.summary_ = calibration::CalibrationTable(result->calibration);
  return made;
}

}  // namespace treeline::map_app
