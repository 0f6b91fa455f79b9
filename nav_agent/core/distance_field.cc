#include "nav_agent/core/distance_field.h"

#include <algorithm>
#include <cmath>

namespace treeline::core {
namespace {

// The lower envelope of the parabolas (x - i)^2 + f[i], sampled at whole x.
class Envelope {
 public:
  explicit Envelope(int length)
      : length_(length),
        roots_(static_cast<size_t>(length)),
        begins_(static_cast<size_t>(length)) {}

  void Sample(std::span<const int64_t> f, std::span<int64_t> out) {
    size_t count = 0;
    for (int i = 0; i < length_; ++i) {
      if (f[static_cast<size_t>(i)] >= kFar) continue;
      int64_t begin = 0;
      while (count > 0) {
        begin = TakesOverAt(roots_[count - 1], i, f);
        if (begin > begins_[count - 1]) break;
        --count;
      }
      if (count == 0) begin = 0;
      if (begin >= length_) continue;
      roots_[count] = i;
      begins_[count] = begin;
      ++count;
    }
    if (count == 0) {
      std::fill(out.begin(), out.end(), kFar);
      return;
    }
    size_t k = 0;
    for (int x = 0; x < length_; ++x) {
      while (k + 1 < count && begins_[k + 1] <= x) ++k;
      const int64_t d = x - roots_[k];
      out[static_cast<size_t>(x)] = d * d + f[static_cast<size_t>(roots_[k])];
    }
  }

  static constexpr int64_t kFar = int64_t{1} << 40;

 private:
  // The first whole x at which parabola b is not above a, for a < b.
  static int64_t TakesOverAt(int a, int b, std::span<const int64_t> f) {
    const int64_t ia = a;
    const int64_t ib = b;
    const int64_t numerator = (f[static_cast<size_t>(b)] + ib * ib) -
                              (f[static_cast<size_t>(a)] + ia * ia);
    const int64_t denominator = 2 * (ib - ia);
    // Rounded up; denominator > 0.
    const int64_t quotient = numerator / denominator;
    const bool rounds_up = numerator % denominator > 0;
    return std::max<int64_t>(0, quotient + (rounds_up ? 1 : 0));
  }

  int length_;
  std::vector<int> roots_;
  std::vector<int64_t> begins_;
};

}  // namespace

std::vector<int32_t> SquaredDistances(int width, int height,
                                      std::span<const uint8_t> is_obstacle) {
  const size_t columns = static_cast<size_t>(width);
  const size_t rows = static_cast<size_t>(height);
  std::vector<int64_t> values(columns * rows);
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = is_obstacle[i] != 0 ? 0 : Envelope::kFar;
  }
  std::vector<int64_t> in(std::max(columns, rows));
  std::vector<int64_t> out(in.size());
  Envelope across(width);
  for (size_t y = 0; y < rows; ++y) {
    const std::span<int64_t> row(values.data() + y * columns, columns);
    std::copy(row.begin(), row.end(), in.begin());
    across.Sample(std::span<const int64_t>(in).first(columns), row);
  }
  Envelope down(height);
  for (size_t x = 0; x < columns; ++x) {
    for (size_t y = 0; y < rows; ++y) in[y] = values[y * columns + x];
    down.Sample(std::span<const int64_t>(in).first(rows),
                std::span<int64_t>(out).first(rows));
    for (size_t y = 0; y < rows; ++y) values[y * columns + x] = out[y];
  }
  std::vector<int32_t> result(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    result[i] = values[i] >= Envelope::kFar ? kNoObstacle
                                            : static_cast<int32_t>(values[i]);
  }
  return result;
}

std::vector<float> DistanceToOccupied(const OccupancyGrid& grid, double max_m) {
  std::vector<uint8_t> is_obstacle(grid.cells.size());
  for (size_t i = 0; i < is_obstacle.size(); ++i) {
    is_obstacle[i] = grid.cells[i] == Occupancy::kOccupied ? 1 : 0;
  }
  const std::vector<int32_t> squared =
      SquaredDistances(grid.width, grid.height, is_obstacle);
  std::vector<float> distances(squared.size());
  for (size_t i = 0; i < squared.size(); ++i) {
    const double cells =
        squared[i] == kNoObstacle ? INFINITY : std::sqrt(squared[i]);
    distances[i] =
        static_cast<float>(std::min(max_m, cells * grid.resolution_m));
  }
  return distances;
}

}  // namespace treeline::core
