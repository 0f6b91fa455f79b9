#include "nav_agent/app/calibrate/camera_views.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/recording/agent_log.h"
#include "nav_agent/rgbd_slam/rgbd_slam.h"
#include "nav_agent/ros_log/convert_log.h"

namespace treeline::calibrate_app {
namespace {

constexpr int kHeightStep = 10;

// What is known of the camera, and its pictures one after the other.
class Follower {
 public:
  explicit Follower(const calibration::Drive& drive) : drive_(drive) {}

  absl::Status Take(const recording::LogEntry& entry) {
    if (const auto* known = std::get_if<camera::RgbdCalibration>(&entry)) {
      if (slam_ == nullptr) calibration_ = *known;
      return absl::OkStatus();
    }
    const auto* frame = std::get_if<recording::LogFrame>(&entry);
    if (frame == nullptr || frame->depth.empty() || !calibration_) {
      return absl::OkStatus();
    }
    if (slam_ == nullptr) {
      rgbd_slam::RgbdSlamOptions options;
      options.closes_loops = false;
      options.final_iterations = 0;
      TL_ASSIGN_OR_RETURN(slam_,
                          rgbd_slam::RgbdSlam::Create(options, *calibration_));
    }
    // Pictures that are broken, or not newer, are as if they were lost.
    const auto decoded = recording::DecodeLogFrame(*frame);
    if (!decoded.ok()) return absl::OkStatus();
    const auto tracked = slam_->AddFrame(
        decoded->frame, frame->stamp.time_since_epoch().count());
    if (!tracked.ok()) return absl::OkStatus();
    ++found_.frames;
    const auto time_s = drive_.TimeOf_s(frame->stamp);
    if (tracked->tracking == rgbd_slam::RgbdTracking::kTracked &&
        tracked->map_from_camera && time_s) {
      found_.views.push_back({*time_s, *tracked->map_from_camera});
    }
    return absl::OkStatus();
  }

  CameraViews& found() { return found_; }

 private:
  const calibration::Drive& drive_;
  std::optional<camera::RgbdCalibration> calibration_;
  std::unique_ptr<rgbd_slam::RgbdSlam> slam_;
  CameraViews found_;
};

}  // namespace

absl::StatusOr<CameraViews> ViewsOfLog(const std::string& log,
                                       const ros_log::BagLogOptions& bag,
                                       const calibration::Drive& drive,
                                       const std::stop_token& stop) {
  Follower follower(drive);
  TL_RETURN_IF_ERROR(
      ros_log::ReadAnyLog(log, bag, [&](const recording::LogEntry& entry) {
        if (stop.stop_requested()) {
          return absl::CancelledError("interrupted");
        }
        return follower.Take(entry);
      }).status());
  if (follower.found().frames == 0) {
    return absl::FailedPreconditionError(absl::StrCat(
        log, ": no pictures with depth and the calibration of their camera"));
  }
  return std::move(follower.found());
}

absl::StatusOr<std::vector<double>> HeightsOfLog(
    const std::string& log, const ros_log::BagLogOptions& bag,
    const geometry::Rotation3& base_from_camera) {
  std::vector<double> heights_m;
  std::optional<camera::RgbdCalibration> calibration;
  int frames = 0;
  const auto take = [&](const recording::LogEntry& entry) {
    if (const auto* known = std::get_if<camera::RgbdCalibration>(&entry)) {
      calibration = *known;
    }
    const auto* frame = std::get_if<recording::LogFrame>(&entry);
    if (frame == nullptr || frame->depth.empty() || !calibration ||
        frames++ % kHeightStep != 0) {
      return absl::OkStatus();
    }
    const auto decoded = recording::DecodeLogFrame(*frame);
    if (!decoded.ok() || !decoded->frame.depth) return absl::OkStatus();
    const auto below_m = calibration::FloorBelow_m(
        *decoded->frame.depth, *calibration, base_from_camera);
    if (below_m) heights_m.push_back(*below_m);
    return absl::OkStatus();
  };
  TL_RETURN_IF_ERROR(ros_log::ReadAnyLog(log, bag, take).status());
  return heights_m;
}

}  // namespace treeline::calibrate_app
