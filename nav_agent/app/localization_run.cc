#include "nav_agent/app/localization_run.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "common/base/status_macros.h"
#include "nav_agent/core/distance_field.h"
#include "nav_agent/localization/scan_points.h"
#include "nlohmann/json.hpp"

namespace treeline {
namespace {

constexpr double kSure = 0.9;
constexpr double kSureWithin_m = 0.5;
// About where somebody says that the robot is.
constexpr PoseCovariance2 kInitialCovariance = {0.25, 0, 0, 0,   0.25,
                                                0,    0, 0, 0.07};

double ProcessorTime_ms() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_nsec);
}

double Agreement(const OccupancyGrid& map, const std::vector<float>& distances,
                 const ScanPoints& points, const Rigid2& map_from_base) {
  if (points.size() == 0) return 0;
  int near = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const CellIndex cell =
        map.CellOf(map_from_base * Vec2{points.x_m[i], points.y_m[i]});
    if (map.Contains(cell) && distances[map.IndexOf(cell)] <= kAgreement_m) {
      ++near;
    }
  }
  return static_cast<double>(near) / static_cast<double>(points.size());
}

bool IsSure(const PlanarEstimate& estimate) {
  return estimate.share >= kSure &&
         std::sqrt(estimate.covariance[0] + estimate.covariance[4]) <
             kSureWithin_m;
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const size_t rank =
      std::min(values.size() - 1,
               static_cast<size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(),
                   values.begin() + static_cast<std::ptrdiff_t>(rank),
                   values.end());
  return values[rank];
}

// Where the estimates became sure for good; the number of scans if never.
size_t FirstSure(const LocalizationResult& result) {
  size_t first = result.scans.size();
  while (first > 0 && IsSure(result.scans[first - 1].estimate)) --first;
  return first;
}

void Summarize(const LaserLog& log, const std::vector<double>& updates_ms,
               LocalizationResult& result) {
  const size_t first = FirstSure(result);
  double driven_m = 0;
  for (size_t i = 0; i < first && i + 1 < log.scans.size(); ++i) {
    driven_m += Norm(log.scans[i + 1].odom_from_base.translation -
                     log.scans[i].odom_from_base.translation);
  }
  const bool is_sure = first < result.scans.size();
  if (is_sure) result.converged_after_m = driven_m;
  const size_t begin = is_sure ? first : 0;
  for (size_t i = begin; i < result.scans.size(); ++i) {
    result.agreement += result.scans[i].agreement /
                        static_cast<double>(result.scans.size() - begin);
  }
  result.median_update_ms = Quantile(updates_ms, 0.5);
  result.p99_update_ms = Quantile(updates_ms, 0.99);
}

void Dot(ColorImage& image, int x, int y, std::array<uint8_t, 3> color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  for (size_t c = 0; c < 3; ++c) {
    image.rgb[3 * (static_cast<size_t>(y) * static_cast<size_t>(image.width) +
                   static_cast<size_t>(x)) +
              c] = color[c];
  }
}

}  // namespace

absl::StatusOr<LocalizationResult> LocalizeLog(
    const OccupancyGrid& map, const LaserLog& log,
    const LocalizationRunOptions& options, const std::function<void()>& done,
    const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(Amcl amcl, Amcl::Create(map, options.amcl, options.seed));
  if (options.initial_map_from_base.has_value()) {
    TL_RETURN_IF_ERROR(
        amcl.SetPose(*options.initial_map_from_base, kInitialCovariance));
  } else {
    amcl.SetAnywhere();
  }
  const std::vector<float> distances = DistanceToOccupied(map, 1);
  LocalizationResult result;
  std::vector<double> updates_ms;
  for (const RecordedScan& recorded : log.scans) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    LaserScan scan;
    scan.ranges_m = recorded.ranges_m;
    TL_ASSIGN_OR_RETURN(
        const ScanPoints points,
        PointsOf(scan, log.laser, log.base_from_laser, options.amcl.max_beams));
    const double before_ms = ProcessorTime_ms();
    TL_ASSIGN_OR_RETURN(const std::optional<PlanarEstimate> estimate,
                        amcl.Update(recorded.odom_from_base, points));
    updates_ms.push_back(ProcessorTime_ms() - before_ms);
    TL_ASSIGN_OR_RETURN(
        const ScanPoints all,
        PointsOf(scan, log.laser, log.base_from_laser, log.laser.beams));
    result.scans.push_back(
        {.stamp = recorded.stamp,
         .estimate = *estimate,
         .agreement = Agreement(map, distances, all, estimate->map_from_base)});
    if (done) done();
  }
  Summarize(log, updates_ms, result);
  return result;
}

std::string LocalizationJson(const LocalizationResult& result) {
  nlohmann::ordered_json json;
  json["scans"] = result.scans.size();
  json["converged_after_m"] =
      result.converged_after_m.has_value()
          ? nlohmann::ordered_json(*result.converged_after_m)
          : nlohmann::ordered_json(nullptr);
  json["agreement"] = result.agreement;
  json["median_update_ms"] = result.median_update_ms;
  json["p99_update_ms"] = result.p99_update_ms;
  nlohmann::ordered_json poses = nlohmann::ordered_json::array();
  for (const LocalizedScan& scan : result.scans) {
    const PlanarEstimate& estimate = scan.estimate;
    poses.push_back({{"stamp", FormatRecordingTime(scan.stamp)},
                     {"x_m", estimate.map_from_base.translation.x},
                     {"y_m", estimate.map_from_base.translation.y},
                     {"yaw_rad", estimate.map_from_base.yaw_rad},
                     {"covariance", estimate.covariance},
                     {"share", estimate.share},
                     {"fit", estimate.fit},
                     {"particles", estimate.particles},
                     {"agreement", scan.agreement}});
  }
  json["poses"] = std::move(poses);
  return json.dump(1) + "\n";
}

ColorImage DrawLocalization(const OccupancyGrid& map, const LaserLog& log,
                            const LocalizationResult& result) {
  ColorImage image{.width = map.width, .height = map.height, .rgb = {}};
  image.rgb.resize(3 * map.cells.size());
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const Occupancy value = map.At({x, y});
      const uint8_t grey = value == Occupancy::kFree       ? 255
                           : value == Occupancy::kOccupied ? 0
                                                           : 190;
      Dot(image, x, map.height - 1 - y, {grey, grey, grey});
    }
  }
  const auto mark = [&](Vec2 point, std::array<uint8_t, 3> color) {
    const CellIndex cell = map.CellOf(point);
    Dot(image, cell.x, map.height - 1 - cell.y, color);
  };
  const size_t first = FirstSure(result);
  for (size_t i = 0; i < result.scans.size(); ++i) {
    mark(result.scans[i].estimate.map_from_base.translation,
         i < first ? std::array<uint8_t, 3>{150, 150, 160}
                   : std::array<uint8_t, 3>{30, 80, 220});
  }
  if (result.scans.empty()) return image;
  LaserScan last;
  last.ranges_m = log.scans.back().ranges_m;
  const absl::StatusOr<ScanPoints> points =
      PointsOf(last, log.laser, log.base_from_laser, log.laser.beams);
  if (!points.ok()) return image;
  for (size_t i = 0; i < points->size(); ++i) {
    mark(result.scans.back().estimate.map_from_base *
             Vec2{points->x_m[i], points->y_m[i]},
         {220, 40, 30});
  }
  return image;
}

}  // namespace treeline
