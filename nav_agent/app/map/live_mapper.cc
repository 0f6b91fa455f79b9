#include "nav_agent/app/map/live_mapper.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/app/map/live_questions.h"
#include "nav_agent/app/map/live_scene.h"
#include "nav_agent/core/corrected_devices.h"

namespace treeline::map_app {
namespace {

// Scans come more often; a learner publishes more seldom.
constexpr std::chrono::milliseconds kFollowEvery(250);

base::MonotonicTime::duration FromSeconds(double seconds) {
  return std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

// Adds why a device is silent, if it is.
void Explain(const char* name, const core::DeviceHealth& health,
             std::string& text) {
  if (health.state == core::DeviceState::kRunning) return;
  absl::StrAppend(&text, text.empty() ? "" : "; ", name, ": ",
                  health.cause.ok() ? "nothing has been heard of it yet"
                                    : health.cause.message());
}

}  // namespace

LiveMapper::LiveMapper(const LiveSensors& sensors,
                       const LiveMapOptions& options, const base::Clock& clock,
                       std::unique_ptr<recording::AgentLogWriter> log)
    : sensors_(sensors),
      options_(options),
      clock_(&clock),
      log_(std::move(log)),
      next_picture_(clock.Now()),
      next_follow_(clock.Now()) {}

absl::StatusOr<std::unique_ptr<LiveMapper>> LiveMapper::Create(
    const LiveSensors& sensors, const LiveMapOptions& options,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.drive.Validate());
  TL_RETURN_IF_ERROR(sensors.robot.Validate());
  TL_ASSIGN_OR_RETURN(std::unique_ptr<recording::AgentLogWriter> log,
                      recording::AgentLogWriter::Open(options.log_path,
                                                      /*append=*/false, clock));
  TL_RETURN_IF_ERROR(
      log->Write(recording::LogInformation{"treeline-agent map --live"}));
  TL_RETURN_IF_ERROR(log->Write(sensors.robot));
  return std::unique_ptr<LiveMapper>(
      new LiveMapper(sensors, options, clock, std::move(log)));
}

absl::Status LiveMapper::TakeScans() {
  for (core::LaserScan& scan : sensors_.laser.TakeScans()) {
    const core::RangeSensorInfo info = sensors_.laser.Info();
    if (laser_ != info) {
      TL_RETURN_IF_ERROR(log_->Write(info));
      laser_ = info;
    }
    if (mapper_ == nullptr) {
      TL_ASSIGN_OR_RETURN(mapper_, mapping::OnlineMapper::Create(
                                       info, sensors_.robot, options_.drive));
    }
    TL_RETURN_IF_ERROR(log_->Write(scan));
    scan.stamp -= core::DelayOf(sensors_.correction.laser_delay_s);
    // What is refused is counted, and named when the log is mapped.
    mapper_->Add(std::move(scan)).IgnoreError();
  }
  return absl::OkStatus();
}

absl::Status LiveMapper::TakeFrames() {
  if (sensors_.camera == nullptr) return absl::OkStatus();
  for (const core::RgbdFrame& frame : sensors_.camera->TakeFrames()) {
    Ask(frame);
    if (last_frame_.has_value() &&
        frame.stamp - *last_frame_ < FromSeconds(options_.frame_interval_s)) {
      continue;
    }
    const camera::RgbdCalibration calibration = sensors_.camera->Calibration();
    if (camera_ != calibration) {
      TL_RETURN_IF_ERROR(log_->Write(calibration));
      camera_ = calibration;
    }
    TL_ASSIGN_OR_RETURN(
        recording::LogFrame encoded,
        recording::EncodeLogFrame(frame, options_.jpeg_quality));
    TL_RETURN_IF_ERROR(log_->Write(encoded));
    if (options_.scene != nullptr) {
      encoded.stamp -= core::DelayOf(sensors_.correction.camera_delay_s);
      options_.scene->Add(std::move(encoded), calibration);
    }
    last_frame_ = frame.stamp;
    ++frames_;
  }
  return absl::OkStatus();
}

void LiveMapper::Ask(core::RgbdFrame frame) {
  if (options_.questions == nullptr || mapper_ == nullptr ||
      !mapper_->IsLost()) {
    return;
  }
  frame.stamp -= core::DelayOf(sensors_.correction.camera_delay_s);
  frame.frame.calibration = sensors_.camera->Calibration();
  options_.questions->Add(frame, *mapper_);
}

absl::Status LiveMapper::Poll() {
  for (core::BaseReading& reading : sensors_.odometry.TakeReadings()) {
    TL_RETURN_IF_ERROR(log_->Write(reading));
    core::Correct(sensors_.correction, reading);
    if (mapper_ != nullptr) mapper_->Add(reading).IgnoreError();
  }
  TL_RETURN_IF_ERROR(TakeScans());
  TL_RETURN_IF_ERROR(TakeFrames());
  if (options_.questions != nullptr && mapper_ != nullptr) {
    const auto seen =
        options_.questions->Step(*mapper_, sensors_.robot.base_from_camera);
    if (seen.has_value()) TL_RETURN_IF_ERROR(log_->Write(*seen));
  }
  if (options_.scene != nullptr && mapper_ != nullptr &&
      clock_->Now() >= next_follow_) {
    next_follow_ = clock_->Now() + kFollowEvery;
    options_.scene->Follow(mapper_->Trajectory(),
                           sensors_.robot.base_from_camera);
  }
  if (options_.picture_path.empty() || clock_->Now() < next_picture_) {
    return absl::OkStatus();
  }
  next_picture_ = clock_->Now() + FromSeconds(options_.picture_every_s);
  return Draw();
}

absl::Status LiveMapper::Draw() {
  if (mapper_ == nullptr) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::vector<mapping::FloorGrid> floors,
                      mapper_->Floors());
  if (floors.empty()) return absl::OkStatus();
  const std::optional<dataset::TimedPose> base = mapper_->MapFromBase();
  const double height_m =
      base.has_value() ? base->world_from_camera.translation.z : 0;
  const auto floor = std::min_element(
      floors.begin(), floors.end(),
      [height_m](const mapping::FloorGrid& a, const mapping::FloorGrid& b) {
        return std::abs(a.height_m - height_m) <
               std::abs(b.height_m - height_m);
      });
  TL_ASSIGN_OR_RETURN(const std::string png,
                      image::EncodePng(DrawLiveMap(*floor, base)));
  return base::WriteFileAtomically(options_.picture_path, png);
}

LiveMapStatus LiveMapper::Status() const {
  LiveMapStatus status;
  status.frames = frames_;
  status.log_bytes = log_->bytes_written();
  if (mapper_ != nullptr) {
    status.scans = mapper_->scans();
    status.map_from_base = mapper_->MapFromBase();
    status.is_lost = mapper_->IsLost();
  }
  Explain("laser", sensors_.laser.Health(), status.silent);
  Explain("base", sensors_.odometry.Health(), status.silent);
  if (sensors_.camera != nullptr) {
    Explain("camera", sensors_.camera->Health(), status.silent);
  }
  return status;
}

absl::Status LiveMapper::Finish() {
  TL_RETURN_IF_ERROR(log_->Flush());
  if (options_.scene != nullptr && mapper_ != nullptr) {
    options_.scene->End(mapper_->Trajectory(), sensors_.robot.base_from_camera);
  }
  return options_.picture_path.empty() ? absl::OkStatus() : Draw();
}

image::ColorImage DrawLiveMap(
    const mapping::FloorGrid& floor,
    const std::optional<dataset::TimedPose>& map_from_base) {
  constexpr std::array<uint8_t, 3> kRobot = {220, 30, 30};
  constexpr int kCross = 4;  // cells from its middle
  const core::OccupancyGrid& grid = floor.grid;
  image::ColorImage picture{
      .width = grid.width, .height = grid.height, .rgb = {}};
  picture.rgb.reserve(3 * grid.cells.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const core::Occupancy cell = grid.At({x, y});
      const uint8_t grey = cell == core::Occupancy::kFree       ? 255
                           : cell == core::Occupancy::kOccupied ? 0
                                                                : 160;
      picture.rgb.insert(picture.rgb.end(), 3, grey);
    }
  }
  if (!map_from_base.has_value()) return picture;
  const geometry::Vec3 place = map_from_base->world_from_camera.translation;
  const core::CellIndex middle = grid.CellOf({place.x, place.y});
  for (int i = -kCross; i <= kCross; ++i) {
    for (const core::CellIndex cell :
         {core::CellIndex{middle.x + i, middle.y},
          core::CellIndex{middle.x, middle.y + i}}) {
      if (!grid.Contains(cell)) continue;
      const size_t pixel = grid.IndexOf({cell.x, grid.height - 1 - cell.y});
      std::copy(kRobot.begin(), kRobot.end(),
                picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
    }
  }
  return picture;
}

}  // namespace treeline::map_app
