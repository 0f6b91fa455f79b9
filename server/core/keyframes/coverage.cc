#include "server/core/keyframes/coverage.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "common/base/parallel_for.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"
#include "server/core/keyframes/parameters.h"
#include "server/core/keyframes/scene_axes.h"
#include "server/core/keyframes/view_support.h"

namespace treeline::keyframes {
namespace {

using geometry::Vec3;

constexpr double kMinCell_m = 0.1;
constexpr double kCellStep_m = 0.05;

// A line of sight of a training camera, in the plan.
struct SightLine {
  Vec3 from;
  Vec3 to;
};

std::vector<SightLine> SightLines(const KeyframeMap& map,
                                  const geometry::Mat3& plan_from_world) {
  std::vector<SightLine> lines;
  for (size_t k = 0; k < map.size(); ++k) {
    const Vec3 from = plan_from_world * map.world_from_camera(k).translation;
    for (const KeyframePoint& point : SomePoints(map, k, kSightLines)) {
      const auto& [x, y, z] = point.position_in_world;
      lines.push_back({from, plan_from_world * Vec3{x, y, z}});
    }
  }
  return lines;
}

// Heights and tilt of the training cameras.
void MeasureCameras(const KeyframeMap& map,
                    const geometry::Mat3& plan_from_world,
                    const std::vector<SightLine>& lines,
                    CoverageMap& coverage) {
  std::vector<double> heights_m;
  std::vector<double> tilts_rad;
  for (size_t k = 0; k < map.size(); ++k) {
    const geometry::Rigid3& pose = map.world_from_camera(k);
    heights_m.push_back((plan_from_world * pose.translation).z);
    const Vec3 axis = plan_from_world * (pose.rotation * Vec3{0, 0, 1});
    tilts_rad.push_back(std::asin(std::clamp(axis.z, -1.0, 1.0)));
  }
  std::vector<double> point_heights_m;
  for (const SightLine& line : lines) point_heights_m.push_back(line.to.z);
  coverage.height_m = base::Quantile(std::move(heights_m), 0.5);
  coverage.tilt_rad = base::Quantile(std::move(tilts_rad), 0.5);
  coverage.ground_m = base::Quantile(std::move(point_heights_m), kGroundPart);
}

// Around cameras and most of what they saw.
void LayGrid(const std::vector<SightLine>& lines,
             const CoverageOptions& options, CoverageMap& coverage) {
  const auto range = [&](double Vec3::*axis) {
    std::vector<double> ends;
    double low = lines[0].from.*axis;
    double high = low;
    for (const SightLine& line : lines) {
      ends.push_back(line.to.*axis);
      low = std::min(low, line.from.*axis);
      high = std::max(high, line.from.*axis);
    }
    return std::array{
        std::min(low - kCameraReach_m, base::Quantile(ends, kOutlinePart)),
        std::max(high + kCameraReach_m,
                 base::Quantile(ends, 1 - kOutlinePart))};
  };
  const auto [min_x, max_x] = range(&Vec3::x);
  const auto [min_y, max_y] = range(&Vec3::y);
  const double wanted_m =
      std::sqrt((max_x - min_x) * (max_y - min_y) / options.places);
  coverage.cell_m = std::clamp(kCellStep_m * std::ceil(wanted_m / kCellStep_m),
                               kMinCell_m, options.max_cell_m);
  coverage.min_x_m = coverage.cell_m * std::floor(min_x / coverage.cell_m);
  coverage.min_y_m = coverage.cell_m * std::floor(min_y / coverage.cell_m);
  const auto cells = [&](double length_m) {
    return 1 + static_cast<int>(length_m / coverage.cell_m);
  };
  coverage.columns = cells(max_x - coverage.min_x_m);
  coverage.rows = cells(max_y - coverage.min_y_m);
  coverage.places.resize(static_cast<size_t>(coverage.columns) *
                         static_cast<size_t>(coverage.rows));
}

Vec3 PlaceInPlan(const CoverageMap& coverage, size_t i) {
  const auto columns = static_cast<size_t>(coverage.columns);
  return {coverage.min_x_m +
              (static_cast<double>(i % columns) + 0.5) * coverage.cell_m,
          coverage.min_y_m +
              (static_cast<double>(i / columns) + 0.5) * coverage.cell_m,
          coverage.height_m};
}

// Those near a camera, and those that lines of sight pass at about the cameras'
// height.
void FindOpenPlaces(const std::vector<SightLine>& lines,
                    const std::vector<Vec3>& cameras, CoverageMap& coverage) {
  std::vector<int> passed(coverage.places.size());
  for (const SightLine& line : lines) {
    const Vec3 way = line.to - line.from;
    const double free_m = geometry::Norm(way) - kSurfaceMargin_m;
    const int steps = static_cast<int>(2 * free_m / coverage.cell_m);
    size_t last = coverage.places.size();
    for (int i = 0; i <= steps; ++i) {
      const Vec3 at =
          line.from + (0.5 * i * coverage.cell_m / geometry::Norm(way)) * way;
      if (std::abs(at.z - coverage.height_m) > kPlaceHeight_m) continue;
      const double column = (at.x - coverage.min_x_m) / coverage.cell_m;
      const double row = (at.y - coverage.min_y_m) / coverage.cell_m;
      if (column < 0 || row < 0 || column >= coverage.columns ||
          row >= coverage.rows) {
        continue;
      }
      const size_t place =
          static_cast<size_t>(row) * static_cast<size_t>(coverage.columns) +
          static_cast<size_t>(column);
      if (place != last) ++passed[place];
      last = place;
    }
  }
  for (size_t i = 0; i < passed.size(); ++i) {
    const Vec3 place = PlaceInPlan(coverage, i);
    coverage.places[i].is_open =
        passed[i] >= kMinSightLines ||
        std::ranges::any_of(cameras, [&](Vec3 camera) {
          return std::hypot(camera.x - place.x, camera.y - place.y) <
                 kCameraReach_m;
        });
  }
}

// Of a camera with the plan's z up in its picture.
geometry::Rotation3 PlanFromCamera(double heading_rad, double tilt_rad) {
  const Vec3 forward{std::cos(tilt_rad) * std::cos(heading_rad),
                     std::cos(tilt_rad) * std::sin(heading_rad),
                     std::sin(tilt_rad)};
  const Vec3 right{std::sin(heading_rad), -std::cos(heading_rad), 0};
  const Vec3 down = geometry::Cross(forward, right);
  return geometry::Rotation3::FromMatrix(
      geometry::Mat3{{right.x, down.x, forward.x, right.y, down.y, forward.y,
                      right.z, down.z, forward.z}});
}

}  // namespace

absl::Status CoverageOptions::Validate() const {
  if (headings < 4 || headings > 32) {
    return absl::InvalidArgumentError("headings must be in [4, 32]");
  }
  if (places < 16 || places > 1000000) {
    return absl::InvalidArgumentError("places must be in [16, 1000000]");
  }
  if (!(max_cell_m >= kMinCell_m) || !(max_cell_m <= 10)) {
    return absl::InvalidArgumentError("max_cell_m must be in [0.1, 10]");
  }
  return absl::OkStatus();
}

Coverage CoverageOf(double support) {
  if (support >= kGoodSupport) return Coverage::kGood;
  return support >= kWeakSupport ? Coverage::kWeak : Coverage::kNone;
}

double CoverageMap::Heading_rad(int h) const {
  return 2 * std::numbers::pi * h / headings;
}

absl::StatusOr<CoverageMap> PredictCoverage(const KeyframeMap& map,
                                            const camera::Camera& camera,
                                            const CoverageOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  CoverageMap coverage;
  coverage.headings = options.headings;
  coverage.plan_from_world = PlanFromWorld(map);
  const geometry::Mat3 matrix = coverage.plan_from_world.Matrix();
  const std::vector<SightLine> lines = SightLines(map, matrix);
  if (lines.empty()) {
    return absl::FailedPreconditionError(
        "the model has no keyframes, which coverage is predicted from; train "
        "it with `--method universal` from a recording that has depth");
  }
  MeasureCameras(map, matrix, lines, coverage);
  LayGrid(lines, options, coverage);
  std::vector<Vec3> cameras;
  for (size_t k = 0; k < map.size(); ++k) {
    cameras.push_back(matrix * map.world_from_camera(k).translation);
  }
  FindOpenPlaces(lines, cameras, coverage);
  const ViewSupport support(map, coverage.plan_from_world);
  std::vector<std::vector<ViewSupport::SeenDirection>> pictures;
  for (int h = 0; h < options.headings; ++h) {
    pictures.push_back(DirectionsInPicture(
        camera, PlanFromCamera(coverage.Heading_rad(h), coverage.tilt_rad)));
  }
  base::ParallelFor(
      static_cast<int64_t>(coverage.places.size()), options.threads,
      [&](int64_t i) {
        CoveragePlace& place = coverage.places[static_cast<size_t>(i)];
        if (!place.is_open) return;
        const ViewSupport::Panorama panorama =
            support.PanoramaAt(PlaceInPlan(coverage, static_cast<size_t>(i)));
        for (size_t h = 0; h < pictures.size(); ++h) {
          const Coverage found = CoverageOf(SupportOf(panorama, pictures[h]));
          if (found == Coverage::kGood) place.good |= 1u << h;
          if (found == Coverage::kWeak) place.weak |= 1u << h;
        }
      });
  return coverage;
}

CoverageSummary Summarize(const CoverageMap& coverage) {
  int open = 0;
  int good = 0;
  int weak = 0;
  int any = 0;
  int all = 0;
  for (const CoveragePlace& place : coverage.places) {
    if (!place.is_open) continue;
    ++open;
    const int here = std::popcount(place.good);
    good += here;
    weak += std::popcount(place.weak);
    any += here > 0 ? 1 : 0;
    all += here == coverage.headings ? 1 : 0;
  }
  if (open == 0) return {};
  const auto share = [](int part, int of) {
    return static_cast<double>(part) / of;
  };
  return {.open_m2 = open * coverage.cell_m * coverage.cell_m,
          .good_share = share(good, open * coverage.headings),
          .weak_share = share(weak, open * coverage.headings),
          .any_heading_share = share(any, open),
          .all_headings_share = share(all, open)};
}

}  // namespace treeline::keyframes
