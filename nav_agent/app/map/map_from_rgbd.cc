#include "nav_agent/app/map/map_from_rgbd.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::map_app {
namespace {

// For the search of the floor: from some frames, not too far away.
constexpr int kFramesLookedAt = 60;
constexpr int kPixelStep = 12;
constexpr double kFarthest_m = 5;

// Surface points and the mean of where pictures say that up is, both in the
// frame of SLAM.
struct Surroundings {
  std::vector<geometry::Vec3> points;
  geometry::Vec3 up;
};

void AddDepth(const image::DepthImage& depth, const camera::Camera& camera,
              const geometry::Rigid3& slam_from_depth,
              std::vector<geometry::Vec3>& points) {
  for (int y = kPixelStep / 2; y < depth.height; y += kPixelStep) {
    for (int x = kPixelStep / 2; x < depth.width; x += kPixelStep) {
      const uint16_t value = depth.values[static_cast<size_t>(y) *
                                              static_cast<size_t>(depth.width) +
                                          static_cast<size_t>(x)];
      const double z_m = value * depth.unit_m;
      if (!image::IsMeasured(value) || z_m > kFarthest_m) continue;
      const auto ray = camera.Unproject(
          {.x = static_cast<double>(x), .y = static_cast<double>(y)});
      if (!ray.has_value()) continue;
      points.push_back(slam_from_depth *
                       geometry::Vec3{z_m * ray->x, z_m * ray->y, z_m});
    }
  }
}

class RgbdMapper {
 public:
  RgbdMapper(const dataset::Dataset& dataset, const MapRgbdOptions& options)
      : dataset_(dataset),
        options_(options),
        calibration_(options.slam.calibration.value_or(dataset.calibration())) {
  }

  absl::StatusOr<MapRgbdResult> Run() {
    TL_ASSIGN_OR_RETURN(assembly_, MapAssembly::Begin(options_.map));
    TL_RETURN_IF_ERROR(assembly_->SetCamera(calibration_));
    TL_RETURN_IF_ERROR(Track());
    TL_RETURN_IF_ERROR(Level());
    TL_RETURN_IF_ERROR(Fuse());
    MapProvenance provenance{.source = dataset_.uri(),
                             .method = "RGB-D SLAM",
                             .trajectory_of = "camera",
                             .trajectory = result_.map_from_camera};
    TL_ASSIGN_OR_RETURN(result_.summary, assembly_->Finish(provenance));
    return std::move(result_);
  }

 private:
  void Report(const char* phase, int done) const {
    if (!options_.progress) return;
    options_.progress(phase, static_cast<double>(done) / dataset_.size());
  }

  absl::Status Track() {
    rgbd_slam::RunRgbdSlamOptions slam = options_.slam;
    slam.stop = options_.stop;
    slam.progress = [this](int done) { Report("RGB-D SLAM", done); };
    TL_ASSIGN_OR_RETURN(result_.slam, rgbd_slam::RunRgbdSlam(dataset_, slam));
    for (const auto& pose : result_.slam.map_from_cameras) {
      if (pose.has_value()) return absl::OkStatus();
    }
    return absl::FailedPreconditionError(
        "no frame could be placed: the camera saw too little that it could "
        "follow. Is there depth, texture, and not too much motion between "
        "frames?");
  }

  // Of the depth camera, in the frame of SLAM.
  geometry::Rigid3 DepthPose(const geometry::Rigid3& slam_from_camera) const {
    return camera::PoseOfSensor(slam_from_camera, calibration_.pose_sensor,
                                camera::RgbdSensor::kDepth, calibration_);
  }

  absl::StatusOr<image::DepthImage> ReadDepth(int frame) const {
    TL_ASSIGN_OR_RETURN(const std::string bytes,
                        base::ReadFile(dataset_.frame(frame).depth_path));
    return image::DecodeDepthPng(
        bytes, dataset_.depth_unit_m() * calibration_.depth_scale);
  }

  // Turns the map upright.
  absl::Status Level() {
    Surroundings seen;
    const int step = std::max(1, dataset_.size() / kFramesLookedAt);
    for (int i = 0; i < dataset_.size(); ++i) {
      const auto& pose = result_.slam.map_from_cameras[static_cast<size_t>(i)];
      if (!pose.has_value()) continue;
      seen.up = seen.up + pose->rotation * geometry::Vec3{0, -1, 0};
      if (i % step != 0) continue;
      TL_ASSIGN_OR_RETURN(const image::DepthImage depth, ReadDepth(i));
      AddDepth(depth, calibration_.depth, DepthPose(*pose), seen.points);
    }
    result_.upright =
        map_bundle::FindUpright(seen.points, seen.up, options_.map.seed);
    return absl::OkStatus();
  }

  absl::Status Fuse() {
    MotionGate gate(options_.map.keyframe_m, options_.map.keyframe_rad);
    for (int i = 0; i < dataset_.size(); ++i) {
      if (options_.stop.stop_requested()) {
        return absl::CancelledError("interrupted");
      }
      Report("fusing", i + 1);
      const auto& pose = result_.slam.map_from_cameras[static_cast<size_t>(i)];
      if (!pose.has_value()) continue;
      const geometry::Rigid3 map_from_camera =
          result_.upright.level_from_map * *pose;
      result_.map_from_camera.push_back(
          {result_.slam.times[static_cast<size_t>(i)], map_from_camera});
      if (!gate.Passes(map_from_camera)) continue;
      const dataset::DatasetFrame& frame = dataset_.frame(i);
      TL_ASSIGN_OR_RETURN(const std::string color,
                          base::ReadFile(frame.color_path));
      TL_ASSIGN_OR_RETURN(const std::string depth,
                          base::ReadFile(frame.depth_path));
      const absl::Status added = assembly_->AddKeyframe(
          color, depth, dataset_.depth_unit_m(), map_from_camera);
      if (!added.ok()) return base::Annotate(added, frame.stem);
    }
    return absl::OkStatus();
  }

  const dataset::Dataset& dataset_;
  const MapRgbdOptions& options_;
  const camera::RgbdCalibration calibration_;
  std::unique_ptr<MapAssembly> assembly_;
  MapRgbdResult result_;
};

}  // namespace

absl::StatusOr<MapRgbdResult> MapRgbd(const dataset::Dataset& dataset,
                                      const MapRgbdOptions& options) {
  return RgbdMapper(dataset, options).Run();
}

}  // namespace treeline::map_app
