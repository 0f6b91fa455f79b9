#include "nav_agent/fusion/compact_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::fusion {
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

  const Cell& At(int x, int y) const {
    return cells[static_cast<size_t>(y) * static_cast<size_t>(width) +
                 static_cast<size_t>(x)];
  }
};

float SquaredDistance(const Cell& a, const Cell& b) {
  const float dx = a.x - b.x;
  const float dy = a.y - b.y;
  const float dz = a.z - b.z;
  return dx * dx + dy * dy + dz * dz;
}

double UnitFor(double range_m) {
  return std::max(kFinestUnit_m, range_m / kLargestCoordinate);
}

double Agreement_m(double depth_m) {
  return kAgreementBase_m + kAgreementSquare_per_m * depth_m * depth_m;
}

CompactPoint Compact(geometry::Vec3 point, double unit_m) {
  const auto round = [unit_m](double value_m) {
    return static_cast<int16_t>(std::lround(
        std::clamp(value_m / unit_m, -kLargestCoordinate, kLargestCoordinate)));
  };
  return {round(point.x), round(point.y), round(point.z)};
}

int PixelStep(const camera::Camera& camera, const FusionOptions& options) {
  if (options.pixel_step > 0) return options.pixel_step;
  const double step = 0.6 * options.resolution_m *
                      camera::MeanFocal_px(camera) / options.max_depth_m;
  return static_cast<int>(std::clamp(step, 1.0, 16.0));
}

// Cells of step x step pixels; what is left at the right and lower border is
// left out.
class CellReader {
 public:
  CellReader(const image::DepthImage& depth, int step, double min_depth_m)
      : depth_(depth),
        step_(step),
        lowest_(static_cast<uint16_t>(
            std::clamp(std::ceil(min_depth_m / depth.unit_m), 1.0, 65535.0))) {}

  // What agrees in the cell whose first pixel is (x0, y0): the means of depth
  // (m) and of the pixels' places.
  struct Mean {
    double z_m = 0;
    camera::Pixel pixel;
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
    const int tolerance =
        static_cast<int>(Agreement_m(seed * depth_.unit_m) / depth_.unit_m);
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

  const image::DepthImage& depth_;
  int step_;
  uint16_t lowest_;
};

// The cell whose first pixel is (x0, y0); depth 0: none.
Cell ReadCell(const CellReader& reader, const camera::Camera& camera, int x0,
              int y0) {
  const auto mean = reader.Read(x0, y0);
  if (!mean) return {};
  const std::optional<camera::Pixel> ray =
      camera.has_distortion()
          ? camera.Unproject(mean->pixel)
          : camera::Pixel{(mean->pixel.x - camera.cx()) / camera.fx(),
                          (mean->pixel.y - camera.cy()) / camera.fy()};
  if (!ray) return {};
  return {static_cast<float>(ray->x * mean->z_m),
          static_cast<float>(ray->y * mean->z_m),
          static_cast<float>(mean->z_m)};
}

CellImage ReadCells(const image::DepthImage& depth,
                    const camera::Camera& camera, int step,
                    double min_depth_m) {
  CellImage image{
      .width = depth.width / step, .height = depth.height / step, .cells = {}};
  image.cells.reserve(static_cast<size_t>(image.width) *
                      static_cast<size_t>(image.height));
  const CellReader reader(depth, step, min_depth_m);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      image.cells.push_back(ReadCell(reader, camera, x * step, y * step));
    }
  }
  return image;
}

// The mean distance of cell (x, y) from its nearest `neighbors` of the eight
// around it, divided by its depth; infinite with fewer than two around it.
float NeighborDistance(const CellImage& image, int x, int y, int neighbors) {
  const Cell& cell = image.At(x, y);
  std::array<float, 8> squares{};
  int found = 0;
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, image.height - 1);
       ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, image.width - 1);
         ++nx) {
      const Cell& other = image.At(nx, ny);
      if (other.z == 0 || (nx == x && ny == y)) continue;
      const float square = SquaredDistance(cell, other);
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
    // What is nearer than a voxel says the same as its neighbours do.
    const double voxel = options.resolution_m / double{image.cells[cell].z};
    if (distances[cell] > std::max(limit, voxel)) image.cells[cell] = {};
  }
}

// Whether cell (x, y) and one of the four beside it, on the same surface, are
// further apart than a voxel: a surface seen at a grazing angle.
bool IsCoarse(const CellImage& image, int x, int y, double resolution_m) {
  constexpr std::array<std::array<int, 2>, 4> kBeside = {
      {{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  const Cell& cell = image.At(x, y);
  const auto connected = static_cast<float>(3 * Agreement_m(double{cell.z}));
  for (const auto& [dx, dy] : kBeside) {
    if (x + dx < 0 || x + dx >= image.width || y + dy < 0 ||
        y + dy >= image.height) {
      continue;
    }
    const Cell& beside = image.At(x + dx, y + dy);
    if (std::abs(cell.z - beside.z) < connected &&
        SquaredDistance(cell, beside) > resolution_m * resolution_m) {
      return true;
    }
  }
  return false;
}

// Points within the range first, then those beyond it.
class CloudBuilder {
 public:
  CloudBuilder(double unit_m, double max_depth_m) : max_depth_m_(max_depth_m) {
    cloud_.unit_m = unit_m;
  }

  void Add(const Cell& cell) {
    if (cell.z == 0) return;
    const geometry::Vec3 point{cell.x, cell.y, cell.z};
    // At the rim of a lens that sees nearly everything.
    const double side = std::max(std::abs(point.x), std::abs(point.y));
    if (side * std::min(1.0, max_depth_m_ / point.z) >
        cloud_.unit_m * kLargestCoordinate) {
      return;
    }
    if (cell.z <= max_depth_m_) {
      cloud_.points.push_back(Compact(point, cloud_.unit_m));
    } else {
      beyond_.push_back(Compact(max_depth_m_ / point.z * point, cloud_.unit_m));
    }
  }

  CompactCloud Build() && {
    cloud_.hits = cloud_.points.size();
    cloud_.points.insert(cloud_.points.end(), beyond_.begin(), beyond_.end());
    cloud_.points.shrink_to_fit();
    return std::move(cloud_);
  }

 private:
  double max_depth_m_;
  CompactCloud cloud_;
  std::vector<CompactPoint> beyond_;
};

// Wide lenses see what is further to the side than ahead.
double ReachOf(const camera::Camera& camera, double max_depth_m) {
  const double reach_x = std::max(camera.cx(), camera.width() - camera.cx());
  const double reach_y = std::max(camera.cy(), camera.height() - camera.cy());
  return max_depth_m *
         std::max({1.0, reach_x / camera.fx(), reach_y / camera.fy()});
}

}  // namespace

absl::StatusOr<CompactCloud> MakeDepthCloud(const image::DepthImage& depth,
                                            const camera::Camera& camera,
                                            const FusionOptions& options) {
  if (depth.width != camera.width() || depth.height != camera.height() ||
      depth.values.size() != static_cast<size_t>(depth.width) *
                                 static_cast<size_t>(depth.height)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a depth image of ", depth.width, " x ", depth.height, " pixels with ",
        depth.values.size(), " values, but a camera of ", camera.width(), " x ",
        camera.height()));
  }
  TL_RETURN_IF_ERROR(
      base::CheckRange("the depth's unit_m", depth.unit_m, 1e-5, 0.1));
  const int step = PixelStep(camera, options);
  CellImage image = ReadCells(depth, camera, step, options.min_depth_m);
  if (options.outlier_neighbors > 0) RemoveOutliers(image, options);

  CloudBuilder builder(UnitFor(ReachOf(camera, options.max_depth_m)),
                       options.max_depth_m);
  const int half = step / 2;
  const CellReader quarters(depth, std::max(half, 1), options.min_depth_m);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Cell& cell = image.At(x, y);
      if (cell.z == 0) continue;
      if (half == 0 || !IsCoarse(image, x, y, options.resolution_m)) {
        builder.Add(cell);
        continue;
      }
      for (const int dy : {0, step - half}) {
        for (const int dx : {0, step - half}) {
          builder.Add(ReadCell(quarters, camera, x * step + dx, y * step + dy));
        }
      }
    }
  }
  return std::move(builder).Build();
}

CompactCloud MakePointCloud(std::span<const geometry::Vec3> points_in_sensor,
                            const FusionOptions& options) {
  CompactCloud cloud;
  cloud.unit_m = UnitFor(options.max_point_range_m);
  std::vector<CompactPoint> beyond;
  for (const geometry::Vec3 point : points_in_sensor) {
    const double range_m = geometry::Norm(point);
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

}  // namespace treeline::fusion
