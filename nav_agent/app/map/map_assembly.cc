#include "nav_agent/app/map/map_assembly.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/fusion/wheel_strip.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/level_files.h"

namespace treeline::map_app {
namespace {

// The first level's picture with the way that was taken, blue.
image::ColorImage PictureOfMap(const traversability::TraversableMap& levels,
                               double max_slope_rad,
                               std::span<const dataset::TimedPose> trajectory) {
  constexpr std::array<uint8_t, 3> kWay = {30, 80, 220};
  image::ColorImage picture =
      traversability::PictureOfLevel(levels, 0, max_slope_rad);
  const core::OccupancyGrid& grid = levels.levels[0].grid;
  for (const dataset::TimedPose& pose : trajectory) {
    const geometry::Vec3 place = pose.world_from_camera.translation;
    const core::CellIndex cell = grid.CellOf({place.x, place.y});
    if (!grid.Contains(cell)) continue;
    const auto row = static_cast<size_t>(grid.height - 1 - cell.y);
    const size_t pixel =
        row * static_cast<size_t>(grid.width) + static_cast<size_t>(cell.x);
    std::copy(kWay.begin(), kWay.end(),
              picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
  }
  return picture;
}

}  // namespace

std::string MapOptions::SceneName() const {
  if (!name.empty()) return name;
  const std::filesystem::path path =
      std::filesystem::absolute(folder).lexically_normal();
  return path.filename().empty() ? path.parent_path().filename().string()
                                 : path.filename().string();
}

absl::Status MapOptions::Validate() const {
  if (folder.empty()) {
    return absl::InvalidArgumentError("no folder is named for the map");
  }
  TL_RETURN_IF_ERROR(
      base::Annotate(map_bundle::CheckBundleName(SceneName()),
                     "the map's name; give another with --name"));
  TL_RETURN_IF_ERROR(fusion.Validate());
  TL_RETURN_IF_ERROR(traversability.Validate());
  TL_RETURN_IF_ERROR(base::CheckRange("keyframe_m", keyframe_m, 0, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("keyframe_rad", keyframe_rad, 0, 3));
  TL_RETURN_IF_ERROR(base::CheckRange("scan_m", scan_m, 0, 10));
  return base::CheckRange("scan_rad", scan_rad, 0, 3);
}

bool MotionGate::Passes(const geometry::Rigid3& map_from_sensor) {
  if (last_.has_value()) {
    const double distance_m =
        geometry::Norm(map_from_sensor.translation - last_->translation);
    const double turn_rad =
        geometry::AngleBetween_rad(map_from_sensor.rotation, last_->rotation);
    if (distance_m < distance_m_ && turn_rad < turn_rad_) return false;
  }
  last_ = map_from_sensor;
  return true;
}

MapAssembly::MapAssembly(const MapOptions& options,
                         fusion::OctomapBuilder octomap)
    : options_(options), octomap_(std::move(octomap)) {}

absl::StatusOr<std::unique_ptr<MapAssembly>> MapAssembly::Begin(
    const MapOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(fusion::OctomapBuilder octomap,
                      fusion::OctomapBuilder::Make(options.fusion));
  TL_RETURN_IF_ERROR(
      map_bundle::BeginMapBundle(options.folder, options.overwrite));
  return std::unique_ptr<MapAssembly>(
      new MapAssembly(options, std::move(octomap)));
}

absl::Status MapAssembly::SetCamera(
    const camera::RgbdCalibration& calibration) {
  calibration_ = calibration;
  if (keyframes_.has_value()) {
    return absl::FailedPreconditionError("there is a camera already");
  }
  TL_ASSIGN_OR_RETURN(
      keyframes_,
      map_bundle::KeyframeWriter::Create(
          options_.folder + "/" + map_bundle::kBundleKeyframes, calibration));
  return absl::OkStatus();
}

absl::Status MapAssembly::AddKeyframe(absl::string_view color,
                                      absl::string_view depth,
                                      double depth_unit_m,
                                      const geometry::Rigid3& map_from_camera) {
  if (!keyframes_.has_value()) {
    return absl::FailedPreconditionError("the camera is not known yet");
  }
  TL_ASSIGN_OR_RETURN(
      const image::DepthImage image,
      image::DecodeDepthPng(depth, depth_unit_m * calibration_.depth_scale));
  TL_RETURN_IF_ERROR(octomap_.InsertDepth(
      views_++, image, calibration_.depth,
      camera::PoseOfSensor(map_from_camera, calibration_.pose_sensor,
                           camera::RgbdSensor::kDepth, calibration_)));
  return keyframes_->Write(color, depth, depth_unit_m, map_from_camera);
}

absl::Status MapAssembly::AddPoints(
    std::span<const geometry::Vec3> points_in_laser,
    const geometry::Rigid3& map_from_laser) {
  return octomap_.InsertPoints(views_++, points_in_laser, map_from_laser);
}

int MapAssembly::keyframes() const {
  return keyframes_.has_value() ? keyframes_->count() : 0;
}

absl::StatusOr<MapSummary> MapAssembly::Finish(
    const MapProvenance& provenance) {
  int64_t moved_voxels = 0;
  if (!options_.keep_moved) {
    TL_ASSIGN_OR_RETURN(moved_voxels, octomap_.ForgetMoved());
  }
  TL_ASSIGN_OR_RETURN(octree::VoxelMap whole, octomap_.Map());
  int driven_holes = 0;
  if (provenance.half_width_m.has_value()) {
    std::vector<geometry::Rigid3> map_from_base;
    for (const dataset::TimedPose& pose : provenance.trajectory) {
      map_from_base.push_back(pose.world_from_camera);
    }
    driven_holes =
        fusion::FillWheelStrip(map_from_base, *provenance.half_width_m, whole);
  }
  // As whoever loads the bundle will read it: the box of what is known.
  TL_ASSIGN_OR_RETURN(const std::string octomap, octree::FormatBt(whole));
  TL_ASSIGN_OR_RETURN(const octree::VoxelMap voxels,
                      octree::ParseOctree(octomap, map_bundle::kBundleOctomap));
  const absl::StatusOr<traversability::TraversableMap> levels =
      traversability::ExtractTraversableMap(voxels, options_.traversability);
  if (!levels.ok()) {
    return absl::FailedPreconditionError(
        absl::StrCat("no map came of it: ", levels.status().message(), " (",
                     octomap_.views(), " views)"));
  }
  TL_ASSIGN_OR_RETURN(MapSummary summary,
                      Write(provenance, voxels, *levels, {}));
  summary.driven_holes = driven_holes;
  summary.moved_voxels = moved_voxels;
  return summary;
}

absl::StatusOr<MapSummary> MapAssembly::FinishPlanar(
    const MapProvenance& provenance, std::span<const core::OccupancyGrid> grids,
    std::span<const double> heights_m, double laser_height_m) {
  TL_ASSIGN_OR_RETURN(const traversability::TraversableMap levels,
                      map_bundle::PlanarLevels(grids, heights_m));
  TL_ASSIGN_OR_RETURN(const octree::VoxelMap voxels,
                      map_bundle::PlanarVoxels(levels, laser_height_m));
  return Write(provenance, voxels, levels,
               {heights_m.begin(), heights_m.end()});
}

absl::StatusOr<MapSummary> MapAssembly::Write(
    const MapProvenance& provenance, const octree::VoxelMap& voxels,
    const traversability::TraversableMap& levels,
    std::vector<double> planar_heights_m) {
  const std::string folder = options_.folder + "/";
  const double max_slope_rad = options_.traversability.max_slope_rad;
  TL_RETURN_IF_ERROR(
      octree::WriteOctree(voxels, folder + map_bundle::kBundleOctomap));
  TL_RETURN_IF_ERROR(traversability::WriteTraversableMap(
      levels, max_slope_rad, folder + map_bundle::kBundleLevels));
  TL_RETURN_IF_ERROR(map_bundle::WriteBundleTrajectory(options_.folder,
                                                       provenance.trajectory));
  if (!levels.levels.empty()) {
    TL_ASSIGN_OR_RETURN(const std::string png,
                        image::EncodePng(PictureOfMap(levels, max_slope_rad,
                                                      provenance.trajectory)));
    TL_RETURN_IF_ERROR(
        base::WriteFileAtomically(folder + map_bundle::kBundlePicture, png));
  }
  MapSummary summary{.folder = options_.folder,
                     .keyframes = keyframes(),
                     .levels = static_cast<int>(levels.levels.size()),
                     .joins = static_cast<int>(levels.joins.size()),
                     .free_cells = 0,
                     .occupied_voxels = voxels.CountOccupied(),
                     .free_voxels = voxels.CountFree()};
  for (const traversability::TraversableLevel& level : levels.levels) {
    summary.free_cells +=
        std::count(level.grid.cells.begin(), level.grid.cells.end(),
                   core::Occupancy::kFree);
  }
  TL_RETURN_IF_ERROR(map_bundle::FinishMapBundle(
      options_.folder, {.name = options_.SceneName(),
                        .source = provenance.source,
                        .method = provenance.method,
                        .trajectory_of = provenance.trajectory_of,
                        .poses = static_cast<int>(provenance.trajectory.size()),
                        .keyframes = summary.keyframes,
                        .levels = summary.levels,
                        .resolution_m = voxels.resolution_m(),
                        .planar_heights_m = std::move(planar_heights_m),
                        .traversability = options_.traversability}));
  return summary;
}

}  // namespace treeline::map_app
