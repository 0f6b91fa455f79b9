#include "nav_agent/mapping/scan_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace treeline::mapping {
namespace {

// Pieces of surface long enough, and alike enough in direction, to tell which
// side of them is seen; how many there must be.
constexpr double kTellingPiece_m = 0.1;
constexpr double kAlong = 0.8;
constexpr int kTellingPieces = 5;

// Directions without a return between others are seen as far as the nearer
// neighbour if there are at most so many: beams are up to a degree apart.
constexpr int kMaxGap = 3;

double DirectionsPerRad(int directions) {
  return directions / (2 * std::numbers::pi);
}

}  // namespace

double ShareOfSameSide(const SurfaceGrid& grid, const ScanOutline& query,
                       const geometry::Rigid2& target_from_query) {
  int same = 0;
  int told = 0;
  size_t begin = 0;
  for (size_t i = 0; i < query.size(); ++i) {
    if (i > begin && query.joined[i - 1] == 0) begin = i;
    const geometry::Vec2 along = query.points_m[i] - query.points_m[begin];
    const double length_m = geometry::Norm(along);
    if (length_m < kTellingPiece_m) continue;
    const geometry::Vec2 middle = query.points_m[begin] + 0.5 * along;
    begin = i;
    const SurfaceGrid::Piece* piece =
        grid.NearestPiece(target_from_query * middle);
    if (piece == nullptr) continue;
    const geometry::Vec2 across = piece->end - piece->begin;
    if (geometry::Norm(across) < kTellingPiece_m) continue;
    const geometry::Vec2 turned =
        geometry::Rigid2{.translation = {},
                         .yaw_rad = target_from_query.yaw_rad} *
        along;
    const double cosine =
        geometry::Dot(turned, across) / (length_m * geometry::Norm(across));
    if (std::abs(cosine) < kAlong) continue;
    ++told;
    same += cosine > 0 ? 1 : 0;
  }
  return told < kTellingPieces ? 0 : static_cast<double>(same) / told;
}

SeenSpace::SeenSpace(const ScanOutline& scan) : seen_from_(scan.seen_from) {
  SetSeen(scan);
  FillGaps();
  SetClear();
}

void SeenSpace::SetSeen(const ScanOutline& scan) {
  const double per_rad = DirectionsPerRad(kDirections);
  const auto see = [this](int direction, double range_m) {
    const int slot = ((direction % kDirections) + kDirections) % kDirections;
    float& seen_m = seen_m_[static_cast<size_t>(slot)];
    const auto range = static_cast<float>(range_m);
    seen_m = seen_m > 0 ? std::min(seen_m, range) : range;
  };
  for (size_t i = 0; i < scan.size(); ++i) {
    const geometry::Vec2 a = scan.points_m[i] - seen_from_;
    const double begin = (std::atan2(a.y, a.x) + std::numbers::pi) * per_rad;
    see(static_cast<int>(std::floor(begin)), geometry::Norm(a));
    if (i + 1 == scan.size() || scan.joined[i] == 0) continue;
    // What lies between the directions of two joined points is their surface.
    const geometry::Vec2 b = scan.points_m[i + 1] - seen_from_;
    const double turn_rad =
        std::atan2(geometry::Cross(a, b), geometry::Dot(a, b));
    const double end = begin + turn_rad * per_rad;
    const geometry::Vec2 along = b - a;
    const int first = static_cast<int>(std::ceil(std::min(begin, end)));
    const int last = static_cast<int>(std::floor(std::max(begin, end))) - 1;
    for (int direction = first; direction <= last; ++direction) {
      const double angle_rad = (direction + 0.5) / per_rad - std::numbers::pi;
      const geometry::Vec2 ray = {std::cos(angle_rad), std::sin(angle_rad)};
      const double across = geometry::Cross(ray, along);
      if (std::abs(across) < 1e-12) continue;
      see(direction, geometry::Cross(a, along) / across);
    }
  }
}

void SeenSpace::FillGaps() {
  int last = -1;
  for (int direction = 0; direction < kDirections; ++direction) {
    const float here_m = seen_m_[static_cast<size_t>(direction)];
    if (!(here_m > 0)) continue;
    const int missing = direction - last - 1;
    if (last >= 0 && missing > 0 && missing <= kMaxGap) {
      const float nearer_m =
          std::min(here_m, seen_m_[static_cast<size_t>(last)]);
      std::fill(seen_m_.begin() + last + 1, seen_m_.begin() + direction,
                nearer_m);
    }
    last = direction;
  }
}

void SeenSpace::SetClear() {
  for (size_t i = 0; i < seen_m_.size(); ++i) {
    clear_m_[i] = std::max(0.0F, seen_m_[i] - static_cast<float>(kClear_m));
  }
  const double per_rad = DirectionsPerRad(kDirections);
  for (int direction = 0; direction < kDirections; ++direction) {
    const double seen_m = seen_m_[static_cast<size_t>(direction)];
    if (!(seen_m > 0)) continue;
    const double half_rad = std::asin(std::min(1.0, kClear_m / seen_m));
    const int half = static_cast<int>(std::ceil(half_rad * per_rad));
    const auto clear_m = static_cast<float>(std::max(0.0, seen_m - kClear_m));
    for (int other = direction - half; other <= direction + half; ++other) {
      const int slot = ((other % kDirections) + kDirections) % kDirections;
      float& known_m = clear_m_[static_cast<size_t>(slot)];
      known_m = std::min(known_m, clear_m);
    }
  }
}

Contradictions SeenSpace::Contradicted(
    const ScanOutline& other, const geometry::Rigid2& this_from_other) const {
  const double per_rad = DirectionsPerRad(kDirections);
  const double c = std::cos(this_from_other.yaw_rad);
  const double s = std::sin(this_from_other.yaw_rad);
  const geometry::Vec2 offset = this_from_other.translation - seen_from_;
  Contradictions found;
  for (const geometry::Vec2& p : other.points_m) {
    const geometry::Vec2 at = {offset.x + c * p.x - s * p.y,
                               offset.y + s * p.x + c * p.y};
    const double range_m = std::sqrt(geometry::Dot(at, at));
    if (range_m > kFarthest_m) continue;
    const int direction = std::clamp(
        static_cast<int>((std::atan2(at.y, at.x) + std::numbers::pi) * per_rad),
        0, kDirections - 1);
    const auto slot = static_cast<size_t>(direction);
    if (range_m > seen_m_[slot] + kClear_m || !(seen_m_[slot] > 0)) continue;
    ++found.told;
    found.contradicted += range_m < clear_m_[slot] ? 1 : 0;
  }
  return found;
}

Contradictions ContradictionsBetween(const ScanOutline& a,
                                     const SeenSpace& seen_by_a,
                                     const ScanOutline& b,
                                     const SeenSpace& seen_by_b,
                                     const geometry::Rigid2& a_from_b) {
  Contradictions found = seen_by_a.Contradicted(b, a_from_b);
  found += seen_by_b.Contradicted(a, a_from_b.Inverse());
  return found;
}

}  // namespace treeline::mapping
