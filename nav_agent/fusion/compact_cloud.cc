#include "nav_agent/fusion/compact_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline {
namespace {

// Coordinates of clouds up to 16 m are in half millimetres.
constexpr double kFinestUnit_m = 0.0005;
constexpr double kLargestCoordinate = 32767;

// Three standard deviations of a structured-light sensor (Nguyen et al. 2012),
// a little more near by.
constexpr double kAgreementBase_m = 0.01;
constexpr double kAgreementSquare_per_m = 0.004;

// The mean of the pixels of a cell that agree; depth 0: there is none.
struct Cell {
  float x = 0;
  float y = 0;
  float z = 0;
};

// A grid of cells, rows from the top.
struct CellImage {
  int width = 0;
  int height = 0;
  std::vector<Cell> cells;
};

double UnitFor(double range_m) {
  return std::max(kFinestUnit_m, range_m / kLargestCoordinate);
}

CompactPoint Compact(Vec3 point, double unit_m) {
  const auto round = [unit_m](double value_m) {
    return static_cast<int16_t>(std::lround(
        std::clamp(value_m / unit_m, -kLargestCoordinate, kLargestCoordinate)));
  };
  return {round(point.x), round(point.y), round(point.z)};
}

int PixelStep(const Camera& camera, const FusionOptions& options) {
  if (options.pixel_step > 0) return options.pixel_step;
  const double step =
      0.6 * options.resolution_m * MeanFocal_px(camera) / options.max_depth_m;
  return static_cast<int>(std::clamp(step, 1.0, 16.0));
}

// Cells of step x step pixels; what is left at the right and lower border is
// left out.
class CellReader {
 public:
  CellReader(const DepthImage& depth, int step, double min_depth_m)
      : depth_(depth),
        step_(step),
        lowest_(static_cast<uint16_t>(
            std::clamp(std::ceil(min_depth_m / depth.unit_m), 1.0, 65535.0))) {}

  // What agrees in the cell whose first pixel is (x0, y0): the means of depth
  // (m) and of the pixels' places.
  struct Mean {
    double z_m = 0;
    Pixel pixel;
  };
  std::optional<Mean> Read(int x0, int y0) const {
    // A middle pixel may be lost or be the outlier itself; then the next.
    const int low = (step_ - 1) / 2;
    const int high = step_ / 2;
    const std::array<std::array<int, 2>, 4> seeds = {
        {{low, low}, {high, high}, {high, low}, {low, high}}};
    for (const auto& [dx, dy] : seeds) {
      const uint16_t seed = At(x0 + dx, y0 + dy);
      if (!IsUsable(seed)) continue;
      if (const auto mean = MeanAround(x0, y0, seed)) return mean;
    }
    return std::nullopt;
  }

 private:
  uint16_t At(int x, int y) const {
    return depth_
        .values[static_cast<size_t>(y) * static_cast<size_t>(depth_.width) +
                static_cast<size_t>(x)];
  }
  bool IsUsable(uint16_t value) const {
    return value >= lowest_ && value != 65535;
  }

  std::optional<Mean> MeanAround(int x0, int y0, uint16_t seed) const {
    const double seed_m = seed * depth_.unit_m;
    const double tolerance_m =
        kAgreementBase_m + kAgreementSquare_per_m * seed_m * seed_m;
    const int tolerance = static_cast<int>(tolerance_m / depth_.unit_m);
    int measured = 0;
    int agreeing = 0;
    int64_t sum = 0;
    int sum_x = 0;
    int sum_y = 0;
    for (int y = 0; y < step_; ++y) {
      for (int x = 0; x < step_; ++x) {
        const uint16_t value = At(x0 + x, y0 + y);
        const int usable = IsUsable(value) ? 1 : 0;
        const int agrees =
            std::abs(int{value} - int{seed}) <= tolerance ? usable : 0;
        measured += usable;
        agreeing += agrees;
        sum += agrees * int{value};
        sum_x += agrees * x;
        sum_y += agrees * y;
      }
    }
    if (4 * agreeing < step_ * step_ || 2 * agreeing < measured) {
      return std::nullopt;
    }
    return Mean{.z_m = static_cast<double>(sum) * depth_.unit_m / agreeing,
                .pixel = {x0 + static_cast<double>(sum_x) / agreeing,
                          y0 + static_cast<double>(sum_y) / agreeing}};
  }

  const DepthImage& depth_;
  int step_;
  uint16_t lowest_;
};

CellImage ReadCells(const DepthImage& depth, const Camera& camera,
                    const FusionOptions& options) {
  const int step = PixelStep(camera, options);
  CellImage image{
      .width = depth.width / step, .height = depth.height / step, .cells = {}};
  image.cells.resize(static_cast<size_t>(image.width) *
                     static_cast<size_t>(image.height));
  const CellReader reader(depth, step, options.min_depth_m);
  size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++i) {
      const auto mean = reader.Read(x * step, y * step);
      if (!mean) continue;
      const std::optional<Pixel> ray =
          camera.has_distortion()
              ? camera.Unproject(mean->pixel)
              : Pixel{(mean->pixel.x - camera.cx()) / camera.fx(),
                      (mean->pixel.y - camera.cy()) / camera.fy()};
      if (!ray) continue;
      image.cells[i] = {static_cast<float>(ray->x * mean->z_m),
                        static_cast<float>(ray->y * mean->z_m),
                        static_cast<float>(mean->z_m)};
    }
  }
  return image;
}

// The mean distance of cell (x, y) from its nearest `neighbors` of the eight
// around it, divided by its depth; infinite with fewer than two around it.
float NeighborDistance(const CellImage& image, int x, int y, int neighbors) {
  const auto at = [&image](int cell_x, int cell_y) -> const Cell& {
    return image
        .cells[static_cast<size_t>(cell_y) * static_cast<size_t>(image.width) +
               static_cast<size_t>(cell_x)];
  };
  const Cell& cell = at(x, y);
  std::array<float, 8> squares{};
  int found = 0;
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, image.height - 1);
       ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, image.width - 1);
         ++nx) {
      const Cell& other = at(nx, ny);
      if (other.z == 0 || (nx == x && ny == y)) continue;
      const float dx = other.x - cell.x;
      const float dy = other.y - cell.y;
      const float dz = other.z - cell.z;
      const float square = dx * dx + dy * dy + dz * dz;
      // Sorted in, as far as it is among the nearest.
      int place = std::min(found, neighbors);
      while (place > 0 && squares[static_cast<size_t>(place - 1)] > square) {
        if (place < neighbors) {
          squares[static_cast<size_t>(place)] =
              squares[static_cast<size_t>(place - 1)];
        }
        --place;
      }
      if (place < neighbors) squares[static_cast<size_t>(place)] = square;
      ++found;
    }
  }
  if (found < 2) return HUGE_VALF;
  const int count = std::min(found, neighbors);
  float sum = 0;
  for (int i = 0; i < count; ++i) {
    sum += std::sqrt(squares[static_cast<size_t>(i)]);
  }
  return sum / (static_cast<float>(count) * cell.z);
}

void RemoveOutliers(CellImage& image, const FusionOptions& options) {
  std::vector<float> distances(image.cells.size(), -1);
  double sum = 0;
  double sum_of_squares = 0;
  int64_t count = 0;
  size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++i) {
      if (image.cells[i].z == 0) continue;
      const float distance =
          NeighborDistance(image, x, y, options.outlier_neighbors);
      distances[i] = distance;
      if (!std::isfinite(distance)) continue;
      sum += distance;
      sum_of_squares += double{distance} * distance;
      ++count;
    }
  }
  const auto n = static_cast<double>(std::max<int64_t>(count, 1));
  const double mean = sum / n;
  const double deviation =
      std::sqrt(std::max(0.0, sum_of_squares / n - mean * mean));
  const double limit = mean + options.outlier_deviations * deviation;
  for (size_t cell = 0; cell < distances.size(); ++cell) {
    if (distances[cell] > limit) image.cells[cell] = {};
  }
}

}  // namespace

absl::StatusOr<CompactCloud> MakeDepthCloud(const DepthImage& depth,
                                            const Camera& camera,
                                            const FusionOptions& options) {
  if (depth.width != camera.width() || depth.height != camera.height() ||
      depth.values.size() != static_cast<size_t>(depth.width) *
                                 static_cast<size_t>(depth.height)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a depth image of ", depth.width, " x ", depth.height, " pixels with ",
        depth.values.size(), " values, but a camera of ", camera.width(), " x ",
        camera.height()));
  }
  TL_RETURN_IF_ERROR(CheckRange("the depth's unit_m", depth.unit_m, 1e-5, 0.1));
  CellImage image = ReadCells(depth, camera, options);
  if (options.outlier_neighbors > 0) RemoveOutliers(image, options);

  // Wide lenses see what is further to the side than ahead.
  const double reach_x = std::max(camera.cx(), camera.width() - camera.cx());
  const double reach_y = std::max(camera.cy(), camera.height() - camera.cy());
  CompactCloud cloud;
  cloud.unit_m =
      UnitFor(options.max_depth_m *
              std::max({1.0, reach_x / camera.fx(), reach_y / camera.fy()}));
  std::vector<CompactPoint> beyond;
  for (const Cell& cell : image.cells) {
    if (cell.z == 0) continue;
    const Vec3 point{cell.x, cell.y, cell.z};
    if (cell.z <= options.max_depth_m) {
      cloud.points.push_back(Compact(point, cloud.unit_m));
    } else {
      beyond.push_back(
          Compact(options.max_depth_m / point.z * point, cloud.unit_m));
    }
  }
  cloud.hits = cloud.points.size();
  cloud.points.insert(cloud.points.end(), beyond.begin(), beyond.end());
  cloud.points.shrink_to_fit();
  return cloud;
}

CompactCloud MakePointCloud(std::span<const Vec3> points_in_sensor,
                            const FusionOptions& options) {
  CompactCloud cloud;
  cloud.unit_m = UnitFor(options.max_point_range_m);
  std::vector<CompactPoint> beyond;
  for (const Vec3 point : points_in_sensor) {
    const double range_m = Norm(point);
    if (!std::isfinite(range_m)) continue;
    if (range_m <= options.max_point_range_m) {
      cloud.points.push_back(Compact(point, cloud.unit_m));
    } else {
      beyond.push_back(
          Compact(options.max_point_range_m / range_m * point, cloud.unit_m));
    }
  }
  cloud.hits = cloud.points.size();
  cloud.points.insert(cloud.points.end(), beyond.begin(), beyond.end());
  cloud.points.shrink_to_fit();
  return cloud;
}

}  // namespace treeline
