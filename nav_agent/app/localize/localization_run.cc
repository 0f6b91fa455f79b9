#include "nav_agent/app/localize/localization_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/processor_time.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"
#include "common/geometry/kabsch.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/localization/scan_points.h"
#include "nlohmann/json.hpp"

namespace treeline::localize_app {
namespace {

constexpr double kSure = 0.9;
constexpr double kSureWithin_m = 0.5;
constexpr double kSameLevel_m = 0.5;
// About where somebody says that the robot is.
constexpr localization::PoseCovariance2 kInitialCovariance = {
    0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.07};

// Of all beams, and in one field for all.
double Agreement(const localization::LikelihoodField& field,
                 const localization::ScanPoints& points,
                 const localization::PlanarEstimate& estimate) {
  if (points.size() == 0) return 0;
  std::vector<float> logs(points.size());
  field.LogLikelihoods(points, estimate.map_from_base, logs,
                       estimate.place.height_m);
  const float near = field.LogAt(kAgreement_m);
  return static_cast<double>(std::ranges::count_if(
             logs, [near](float log) { return log >= near; })) /
         static_cast<double>(points.size());
}

// The ends of a scan's beams, as the map's kind wants them.
absl::StatusOr<localization::ScanPoints> PointsFor(
    const LocalizationMap& map, const RecordedDrive& drive,
    const DriveScan& recorded, const LocalizationRunOptions& options,
    int max_points) {
  core::LaserScan scan;
  scan.ranges_m = recorded.ranges_m;
  const bool use_tilt = options.use_tilt && drive.has_tilt;
  TL_ASSIGN_OR_RETURN(
      localization::ScanPoints points,
      localization::PointsInSpace(
          scan, drive.laser, drive.base_from_laser,
          use_tilt ? recorded.level_from_base : geometry::Rotation3(),
          max_points));
  if (map.levels != nullptr || !use_tilt) return points;
  localization::ScanPoints kept;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points.z_m[i] >= options.lowest_point_m &&
        points.z_m[i] <= options.highest_point_m) {
      kept.Add(points, i);
    }
  }
  return kept;
}

absl::StatusOr<localization::Amcl> BeginAmcl(
    const LocalizationMap& map, const LocalizationRunOptions& options) {
  if (map.levels == nullptr && map.grids.size() != 1) {
    return absl::InvalidArgumentError("localization needs one map, or levels");
  }
  TL_ASSIGN_OR_RETURN(
      localization::Amcl amcl,
      map.levels == nullptr
          ? localization::Amcl::Create(map.grids[0], options.amcl, options.seed)
          : localization::Amcl::CreateOnLevels(map.levels, options.amcl,
                                               options.seed));
  if (!options.initial_map_from_base.has_value()) {
    amcl.StartGlobalLocalization();
  } else if (options.initial_height_m.has_value() && map.levels != nullptr) {
    TL_RETURN_IF_ERROR(amcl.SetPoseOnLevel(*options.initial_map_from_base,
                                           *options.initial_height_m,
                                           kInitialCovariance));
  } else {
    TL_RETURN_IF_ERROR(
        amcl.SetPose(*options.initial_map_from_base, kInitialCovariance));
  }
  return amcl;
}

void CompareWithTruth(const geometry::Rigid3& world_from_base,
                      LocalizedScan& scan) {
  const geometry::Rigid2& pose = scan.estimate.map_from_base;
  const geometry::Rigid2 truth = geometry::PlanarPose(world_from_base);
  scan.error_m = geometry::Norm(pose.translation - truth.translation);
  scan.error_rad =
      std::abs(geometry::NormalizedAngle_rad(pose.yaw_rad - truth.yaw_rad));
  scan.height_error_m =
      std::abs(scan.estimate.place.height_m - world_from_base.translation.z);
}

bool IsSure(const localization::PlanarEstimate& estimate) {
  return estimate.share >= kSure && !estimate.in_doubt &&
         std::sqrt(estimate.covariance[0] + estimate.covariance[4]) <
             kSureWithin_m;
}

// Where the estimates became sure for good; the number of scans if never.
size_t FirstSure(const LocalizationResult& result) {
  size_t first = result.scans.size();
  while (first > 0 && IsSure(result.scans[first - 1].estimate)) --first;
  return first;
}

double Driven_m(const RecordedDrive& drive, size_t scans) {
  double driven_m = 0;
  for (size_t i = 0; i < scans && i + 1 < drive.scans.size(); ++i) {
    driven_m += geometry::Norm(drive.scans[i + 1].odom_from_base.translation -
                               drive.scans[i].odom_from_base.translation);
  }
  return driven_m;
}

ErrorFigures FiguresOf(const std::vector<double>& errors) {
  ErrorFigures figures;
  if (errors.empty()) return figures;
  for (const double error : errors) figures.rmse += error * error;
  figures.rmse = std::sqrt(figures.rmse / static_cast<double>(errors.size()));
  figures.p95 = base::Quantile(errors, 0.95);
  figures.max = *std::ranges::max_element(errors);
  return figures;
}

// Distances of estimates from the truth after the best alignment in the plane.
std::optional<ErrorFigures> AlignedErrors(
    const RecordedDrive& drive, const std::vector<LocalizedScan>& scans,
    size_t begin) {
  std::vector<std::pair<geometry::Vec3, geometry::Vec3>>
      places;  // true, estimated
  geometry::Kabsch alignment;
  for (size_t i = begin; i < scans.size(); ++i) {
    if (!drive.scans[i].world_from_base.has_value()) continue;
    const geometry::Vec3 truth = drive.scans[i].world_from_base->translation;
    const geometry::Vec2 estimate = scans[i].estimate.map_from_base.translation;
    places.push_back({{truth.x, truth.y, 0}, {estimate.x, estimate.y, 0}});
    // Points above them keep the alignment upright.
    for (const double z_m : {0.0, 1.0}) {
      alignment.Add({truth.x, truth.y, z_m}, {estimate.x, estimate.y, z_m});
    }
  }
  const std::optional<geometry::Rigid3> world_from_map = alignment.Solve();
  if (!world_from_map.has_value()) return std::nullopt;
  std::vector<double> errors_m;
  for (const auto& [truth, estimate] : places) {
    errors_m.push_back(geometry::Norm(*world_from_map * estimate - truth));
  }
  return FiguresOf(errors_m);
}

std::optional<LocalizationErrors> ErrorsOf(
    const RecordedDrive& drive, const std::vector<LocalizedScan>& scans,
    size_t begin) {
  std::vector<double> positions_m;
  std::vector<double> headings_rad;
  size_t right = 0;
  for (size_t i = begin; i < scans.size(); ++i) {
    if (!scans[i].error_m.has_value()) continue;
    positions_m.push_back(*scans[i].error_m);
    headings_rad.push_back(scans[i].error_rad);
    right += scans[i].height_error_m < kSameLevel_m ? 1 : 0;
  }
  if (positions_m.empty()) return std::nullopt;
  return LocalizationErrors{
      .scans = positions_m.size(),
      .position_m = FiguresOf(positions_m),
      .aligned_m = AlignedErrors(drive, scans, begin),
      .heading_rad = FiguresOf(headings_rad),
      .right_level =
          static_cast<double>(right) / static_cast<double>(positions_m.size())};
}

void Summarize(const RecordedDrive& drive,
               const std::vector<double>& updates_ms,
               LocalizationResult& result) {
  const size_t first = FirstSure(result);
  const bool is_sure = first < result.scans.size();
  if (is_sure) result.converged_after_m = Driven_m(drive, first);
  const auto once = std::ranges::find_if(
      result.scans,
      [](const LocalizedScan& scan) { return IsSure(scan.estimate); });
  if (once != result.scans.end()) {
    result.first_sure_after_m =
        Driven_m(drive, static_cast<size_t>(once - result.scans.begin()));
  }
  const size_t begin = is_sure ? first : 0;
  for (size_t i = begin; i < result.scans.size(); ++i) {
    result.agreement += result.scans[i].agreement /
                        static_cast<double>(result.scans.size() - begin);
  }
  if (is_sure) result.errors = ErrorsOf(drive, result.scans, first);
  result.median_update_ms = base::Quantile(updates_ms, 0.5);
  result.p99_update_ms = base::Quantile(updates_ms, 0.99);
}

nlohmann::ordered_json JsonOf(const ErrorFigures& figures) {
  return {{"rmse", figures.rmse}, {"p95", figures.p95}, {"max", figures.max}};
}

nlohmann::ordered_json JsonOf(
    const std::vector<localization::PossiblePlace>& places) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const localization::PossiblePlace& place : places) {
    json.push_back({{"x_m", place.pose.map_from_base.translation.x},
                    {"y_m", place.pose.map_from_base.translation.y},
                    {"yaw_rad", place.pose.map_from_base.yaw_rad},
                    {"level", place.pose.place.level},
                    {"height_m", place.pose.place.height_m},
                    {"share", place.share}});
  }
  return json;
}

void Dot(image::ColorImage& image, int x, int y, std::array<uint8_t, 3> color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  for (size_t c = 0; c < 3; ++c) {
    image.rgb[3 * (static_cast<size_t>(y) * static_cast<size_t>(image.width) +
                   static_cast<size_t>(x)) +
              c] = color[c];
  }
}

}  // namespace

absl::StatusOr<LocalizationResult> LocalizeDrive(
    const LocalizationMap& map, const RecordedDrive& drive,
    const LocalizationRunOptions& options, const std::function<void()>& done,
    const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(localization::Amcl amcl, BeginAmcl(map, options));
  localization::LikelihoodField flat = localization::LikelihoodField::Empty();
  if (map.levels == nullptr) {
    TL_ASSIGN_OR_RETURN(flat, localization::LikelihoodField::Create(
                                  map.grids[0], options.amcl.field));
  }
  const localization::LikelihoodField& field =
      map.levels == nullptr ? flat : map.levels->field();
  LocalizationResult result;
  std::vector<double> updates_ms;
  for (const DriveScan& recorded : drive.scans) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    TL_ASSIGN_OR_RETURN(
        const localization::ScanPoints points,
        PointsFor(map, drive, recorded, options, options.amcl.max_beams));
    const double before_ms = base::ThreadProcessorTime_ms();
    TL_ASSIGN_OR_RETURN(
        const std::optional<localization::PlanarEstimate> estimate,
        amcl.Update(recorded.odom_from_base, points));
    updates_ms.push_back(base::ThreadProcessorTime_ms() - before_ms);
    TL_ASSIGN_OR_RETURN(
        const localization::ScanPoints all,
        PointsFor(map, drive, recorded, options, drive.laser.beams));
    LocalizedScan scan = {.stamp = recorded.stamp,
                          .estimate = *estimate,
                          .agreement = Agreement(field, all, *estimate),
                          .error_m = std::nullopt};
    if (recorded.world_from_base.has_value()) {
      CompareWithTruth(*recorded.world_from_base, scan);
    }
    result.scans.push_back(std::move(scan));
    if (done) done();
  }
  Summarize(drive, updates_ms, result);
  return result;
}

std::string LocalizationJson(const LocalizationResult& result) {
  nlohmann::ordered_json json;
  json["scans"] = result.scans.size();
  json["converged_after_m"] =
      result.converged_after_m.has_value()
          ? nlohmann::ordered_json(*result.converged_after_m)
          : nlohmann::ordered_json(nullptr);
  json["first_sure_after_m"] =
      result.first_sure_after_m.has_value()
          ? nlohmann::ordered_json(*result.first_sure_after_m)
          : nlohmann::ordered_json(nullptr);
  json["agreement"] = result.agreement;
  if (result.errors.has_value()) {
    json["errors"] = {{"scans", result.errors->scans},
                      {"position_m", JsonOf(result.errors->position_m)},
                      {"aligned_m", result.errors->aligned_m.has_value()
                                        ? JsonOf(*result.errors->aligned_m)
                                        : nlohmann::ordered_json()},
                      {"heading_rad", JsonOf(result.errors->heading_rad)},
                      {"right_level", result.errors->right_level}};
  }
  json["median_update_ms"] = result.median_update_ms;
  json["p99_update_ms"] = result.p99_update_ms;
  nlohmann::ordered_json poses = nlohmann::ordered_json::array();
  for (const LocalizedScan& scan : result.scans) {
    const localization::PlanarEstimate& estimate = scan.estimate;
    nlohmann::ordered_json pose = {
        {"stamp", recording::FormatRecordingTime(scan.stamp)},
        {"x_m", estimate.map_from_base.translation.x},
        {"y_m", estimate.map_from_base.translation.y},
        {"yaw_rad", estimate.map_from_base.yaw_rad},
        {"covariance", estimate.covariance},
        {"share", estimate.share},
        {"fit", estimate.fit},
        {"particles", estimate.particles},
        {"agreement", scan.agreement},
        {"searching", estimate.is_searching},
        {"level", estimate.place.level},
        {"height_m", estimate.place.height_m},
        {"in_doubt", estimate.in_doubt},
        {"place_share", estimate.place_share},
        {"other_places", JsonOf(estimate.other_places)}};
    if (scan.error_m.has_value()) {
      pose["error_m"] = *scan.error_m;
      pose["error_rad"] = scan.error_rad;
    }
    poses.push_back(std::move(pose));
  }
  json["poses"] = std::move(poses);
  return json.dump(1) + "\n";
}

image::ColorImage DrawLocalization(const LocalizationMap& map,
                                   const RecordedDrive& drive,
                                   const LocalizationResult& result) {
  const int level =
      result.scans.empty() ? 0 : result.scans.back().estimate.place.level;
  const core::OccupancyGrid& grid = map.grids[static_cast<size_t>(level)];
  image::ColorImage image{
      .width = grid.width, .height = grid.height, .rgb = {}};
  image.rgb.resize(3 * grid.cells.size());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const core::Occupancy value = grid.At({x, y});
      const uint8_t grey = value == core::Occupancy::kFree       ? 255
                           : value == core::Occupancy::kOccupied ? 0
                                                                 : 190;
      Dot(image, x, grid.height - 1 - y, {grey, grey, grey});
    }
  }
  const auto mark = [&](geometry::Vec2 point, std::array<uint8_t, 3> color) {
    const core::CellIndex cell = grid.CellOf(point);
    Dot(image, cell.x, grid.height - 1 - cell.y, color);
  };
  const size_t first = FirstSure(result);
  for (size_t i = 0; i < result.scans.size(); ++i) {
    if (result.scans[i].estimate.place.level != level) continue;
    mark(result.scans[i].estimate.map_from_base.translation,
         i < first ? std::array<uint8_t, 3>{150, 150, 160}
                   : std::array<uint8_t, 3>{30, 80, 220});
  }
  if (result.scans.empty()) return image;
  const absl::StatusOr<localization::ScanPoints> points =
      PointsFor(map, drive, drive.scans.back(), {}, drive.laser.beams);
  if (!points.ok()) return image;
  for (size_t i = 0; i < points->size(); ++i) {
    mark(result.scans.back().estimate.map_from_base *
             geometry::Vec2{points->x_m[i], points->y_m[i]},
         {220, 40, 30});
  }
  return image;
}

}  // namespace treeline::localize_app
