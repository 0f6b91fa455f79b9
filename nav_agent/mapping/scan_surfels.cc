#include "nav_agent/mapping/scan_surfels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace treeline::mapping {
namespace {

// Points on either side of the middle; so many even if they are far apart.
constexpr size_t kMaxSide = 5;
constexpr size_t kMinSide = 2;
constexpr size_t kMaxSurfels = std::numeric_limits<int16_t>::max();

int CellOf(double at_m) {
  return static_cast<int>(std::floor(at_m / ScanSurfels::kNear_m));
}

uint32_t KeyOf(int cell_x, int cell_y) {
  return (static_cast<uint32_t>(cell_x + 0x8000) << 16) |
         (static_cast<uint32_t>(cell_y + 0x8000) & 0xffff);
}

uint32_t HashOf(uint32_t key) {
  key ^= key >> 15;
  key *= 0x85ebca6bU;
  key ^= key >> 13;
  return key;
}

// The line through points `begin` to `end` - 1.
std::optional<Surfel> FitLine(const ScanOutline& scan, size_t begin, size_t end,
                              double max_off_m) {
  const auto count = static_cast<double>(end - begin);
  geometry::Vec2 mean;
  for (size_t i = begin; i < end; ++i) mean = mean + scan.points_m[i];
  mean = (1 / count) * mean;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (size_t i = begin; i < end; ++i) {
    const geometry::Vec2 d = scan.points_m[i] - mean;
    xx += d.x * d.x;
    xy += d.x * d.y;
    yy += d.y * d.y;
  }
  const double half = 0.5 * (xx - yy);
  const double root = std::hypot(half, xy);
  const double across2 = 0.5 * (xx + yy) - root;
  if (across2 > max_off_m * max_off_m * count) return std::nullopt;
  const double angle_rad = 0.5 * std::atan2(xy, half);  // along the line
  geometry::Vec2 normal = {-std::sin(angle_rad), std::cos(angle_rad)};
  if (geometry::Dot(normal, scan.seen_from - mean) < 0) normal = -1.0 * normal;
  return Surfel{static_cast<float>(mean.x), static_cast<float>(mean.y),
                static_cast<float>(normal.x), static_cast<float>(normal.y)};
}

}  // namespace

std::vector<Surfel> SurfelsOf(const ScanOutline& scan,
                              const ScanSurfelOptions& options) {
  std::vector<Surfel> surfels;
  const double reach2_m2 = options.reach_m * options.reach_m;
  const auto near = [&](size_t a, size_t b) {
    const geometry::Vec2 d = scan.points_m[a] - scan.points_m[b];
    return geometry::Dot(d, d) <= reach2_m2;
  };
  std::optional<size_t> last;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (i == 0 || scan.joined[i - 1] == 0) last.reset();
    if (last.has_value()) {
      const geometry::Vec2 d = scan.points_m[i] - scan.points_m[*last];
      if (geometry::Dot(d, d) < options.spacing_m * options.spacing_m) continue;
    }
    size_t begin = i;
    while (begin > 0 && i - begin < kMaxSide && scan.joined[begin - 1] != 0 &&
           (i - begin < kMinSide || near(begin - 1, i))) {
      --begin;
    }
    size_t end = i + 1;
    while (end < scan.size() && end - i <= kMaxSide &&
           scan.joined[end - 1] != 0 && (end - i <= kMinSide || near(end, i))) {
      ++end;
    }
    if (static_cast<int>(end - begin) < options.min_points) continue;
    const std::optional<Surfel> fitted =
        FitLine(scan, begin, end, options.max_off_m);
    if (!fitted.has_value()) continue;
    surfels.push_back(*fitted);
    last = i;
  }
  return surfels;
}

ScanSurfels::ScanSurfels(std::vector<Surfel> surfels)
    : surfels_(std::move(surfels)) {
  if (surfels_.size() > kMaxSurfels) surfels_.resize(kMaxSurfels);
  Index();
}

void ScanSurfels::Index() {
  size_t size = 16;
  while (size < 18 * surfels_.size()) size *= 2;
  slots_.resize(size);
  mask_ = static_cast<uint32_t>(size - 1);
  for (size_t i = 0; i < surfels_.size(); ++i) {
    const int cell_x = CellOf(surfels_[i].x);
    const int cell_y = CellOf(surfels_[i].y);
    for (int k = 0; k < 9; ++k) {
      Put(cell_x + k % 3 - 1, cell_y + k / 3 - 1, i);
    }
  }
}

void ScanSurfels::Put(int cell_x, int cell_y, size_t surfel) {
  const auto dx = static_cast<float>((cell_x + 0.5) * kNear_m);
  const auto dy = static_cast<float>((cell_y + 0.5) * kNear_m);
  const Surfel& s = surfels_[surfel];
  const float distance2_m2 = (s.x - dx) * (s.x - dx) + (s.y - dy) * (s.y - dy);
  const uint32_t key = KeyOf(cell_x, cell_y);
  uint32_t at = HashOf(key) & mask_;
  while (slots_[at].surfel >= 0 && slots_[at].cell != key) {
    at = (at + 1) & mask_;
  }
  Slot& slot = slots_[at];
  if (slot.surfel >= 0 && slot.distance2_m2 <= distance2_m2) return;
  slot = {.cell = key,
          .surfel = static_cast<int16_t>(surfel),
          .distance2_m2 = distance2_m2};
}

const Surfel* ScanSurfels::Near(geometry::Vec2 at_m) const {
  const uint32_t key = KeyOf(CellOf(at_m.x), CellOf(at_m.y));
  uint32_t at = HashOf(key) & mask_;
  while (slots_[at].surfel >= 0) {
    if (slots_[at].cell == key) {
      return &surfels_[static_cast<size_t>(slots_[at].surfel)];
    }
    at = (at + 1) & mask_;
  }
  return nullptr;
}

}  // namespace treeline::mapping
