#include "server/core/training/mean_shift.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace treeline::training {
namespace {

// Shifts start from at most so many points, evenly chosen; the others go to
// the mode nearest to them.
constexpr size_t kMaxStarts = 256;
constexpr int kMaxShifts = 30;

float SquaredDistance(const Label& a, const Label& b) {
  const float x = a.x - b.x;
  const float y = a.y - b.y;
  const float z = a.z - b.z;
  return x * x + y * y + z * z;
}

// Where the shifts from `start` end.
Label Shifted(std::span<const Label> points, Label start, float bandwidth2) {
  Label at = start;
  size_t inside_before = 0;
  for (int i = 0; i < kMaxShifts; ++i) {
    double x = 0, y = 0, z = 0;
    size_t inside = 0;
    for (const Label& p : points) {
      if (SquaredDistance(p, at) > bandwidth2) continue;
      x += static_cast<double>(p.x);
      y += static_cast<double>(p.y);
      z += static_cast<double>(p.z);
      ++inside;
    }
    if (inside == 0) break;
    const double n = static_cast<double>(inside);
    const Label next{static_cast<float>(x / n), static_cast<float>(y / n),
                     static_cast<float>(z / n)};
    const bool settled =
        inside == inside_before && SquaredDistance(next, at) == 0;
    inside_before = inside;
    at = next;
    if (settled) break;
  }
  return at;
}

size_t NearestOf(const std::vector<Label>& centers, const Label& point) {
  size_t nearest = 0;
  float least = std::numeric_limits<float>::infinity();
  for (size_t c = 0; c < centers.size(); ++c) {
    const float distance = SquaredDistance(centers[c], point);
    if (distance < least) {
      least = distance;
      nearest = c;
    }
  }
  return nearest;
}

}  // namespace

std::vector<std::vector<size_t>> MeanShiftModes(std::span<const Label> points,
                                                double bandwidth_m,
                                                size_t max_modes) {
  if (points.empty() || max_modes == 0) return {};
  const float bandwidth2 = static_cast<float>(bandwidth_m * bandwidth_m);
  const size_t starts = std::min(points.size(), kMaxStarts);
  std::vector<Label> centers;
  for (size_t s = 0; s < starts; ++s) {
    const Label end =
        Shifted(points, points[s * points.size() / starts], bandwidth2);
    if (std::ranges::none_of(centers, [&](const Label& c) {
          return SquaredDistance(c, end) < 0.25f * bandwidth2;
        })) {
      centers.push_back(end);
    }
  }
  std::vector<std::vector<size_t>> modes(centers.size());
  for (size_t i = 0; i < points.size(); ++i) {
    modes[NearestOf(centers, points[i])].push_back(i);
  }
  std::erase_if(modes, [](const auto& mode) { return mode.empty(); });
  std::stable_sort(
      modes.begin(), modes.end(),
      [](const auto& a, const auto& b) { return a.size() > b.size(); });
  if (modes.size() > max_modes) modes.resize(max_modes);
  return modes;
}

}  // namespace treeline::training
