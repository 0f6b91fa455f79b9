#include "server/tools/calibration_file.h"

#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"

namespace treeline::tools {
namespace {

constexpr uint64_t kMaxBytes = 1 << 20;

}  // namespace

absl::StatusOr<camera::RgbdCalibration> ReadCalibrationFile(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string json, base::ReadFile(path, kMaxBytes));
  absl::StatusOr<camera::RgbdCalibration> calibration =
      camera::CalibrationFromJson(json);
  if (!calibration.ok()) return base::Annotate(calibration.status(), path);
  return calibration;
}

}  // namespace treeline::tools
