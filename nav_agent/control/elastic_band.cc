#include "nav_agent/control/elastic_band.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"

namespace treeline::control {
namespace {

// Nearer neighbours have no direction (m).
constexpr double kCoincide_m = 1e-6;
// A bubble with less room is held to touch (m).
constexpr double kTouch_m = 0.0;

geometry::Vec2 Unit(geometry::Vec2 v) {
  const double length = geometry::Norm(v);
  return length < kCoincide_m ? geometry::Vec2{} : (1 / length) * v;
}

geometry::Vec2 At(const BandBubble& bubble) {
  return bubble.map_from_base.translation;
}

BandBubble Between(const BandBubble& a, const BandBubble& b) {
  BandBubble middle;
  middle.map_from_base.translation = 0.5 * (At(a) + At(b));
  const geometry::Vec2 way = At(b) - At(a);
  middle.map_from_base.yaw_rad = geometry::Norm(way) < kCoincide_m
                                     ? a.map_from_base.yaw_rad
                                     : std::atan2(way.y, way.x);
  return middle;
}

}  // namespace

absl::Status ElasticBandOptions::Validate() const {
  if (!(influence_m > 0 && repulsion >= 0 && gain > 0 && max_move_m > 0 &&
        min_spacing_m > 0 && max_spacing_m >= 2 * min_spacing_m &&
        turn_m_per_rad >= 0 && iterations >= 0 && max_bubbles >= 2)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the elastic band's forces and lengths must be positive, and "
        "max_spacing_m at least twice min_spacing_m"));
  }
  return absl::OkStatus();
}

void ElasticBand::Set(const std::vector<geometry::Rigid2>& map_from_base) {
  bubbles_.clear();
  for (const geometry::Rigid2& pose : map_from_base) {
    bubbles_.push_back({.map_from_base = pose});
  }
  SetHeadings();
}

void ElasticBand::Append(const geometry::Rigid2& map_from_base) {
  bubbles_.push_back({.map_from_base = map_from_base});
}

double ElasticBand::BeginAt(const geometry::Rigid2& map_from_base) {
  if (bubbles_.empty()) {
    bubbles_.push_back({.map_from_base = map_from_base});
    return 0;
  }
  // The nearest piece within the next metre; what is before it is behind.
  const geometry::Vec2 at = map_from_base.translation;
  double best_m = geometry::Norm(At(bubbles_[0]) - at);
  size_t first_ahead = bubbles_.size() > 1 ? 1 : 0;
  double along_m = 0;
  for (size_t i = 1; i < bubbles_.size() && along_m < kPathAhead_m; ++i) {
    const geometry::Vec2 begin = At(bubbles_[i - 1]);
    const geometry::Vec2 way = At(bubbles_[i]) - begin;
    const double square = geometry::Dot(way, way);
    const double part =
        square < 1e-12
            ? 0
            : std::clamp(geometry::Dot(at - begin, way) / square, 0.0, 1.0);
    const double off_m = geometry::Norm(begin + part * way - at);
    if (off_m <= best_m) {
      best_m = off_m;
      first_ahead = part >= 1 && i + 1 < bubbles_.size() ? i + 1 : i;
    }
    along_m += std::sqrt(square);
  }
  // One that the robot is all but at is behind it, unless it is the last.
  while (first_ahead + 1 < bubbles_.size() &&
         geometry::Norm(At(bubbles_[first_ahead]) - at) <
             0.5 * options_.min_spacing_m) {
    ++first_ahead;
  }
  bubbles_.erase(bubbles_.begin(),
                 bubbles_.begin() + static_cast<std::ptrdiff_t>(first_ahead));
  bubbles_.insert(bubbles_.begin(), {.map_from_base = map_from_base});
  return best_m;
}

void ElasticBand::SetHeadings() {
  for (size_t i = 1; i + 1 < bubbles_.size(); ++i) {
    const geometry::Vec2 way = At(bubbles_[i + 1]) - At(bubbles_[i - 1]);
    if (geometry::Norm(way) < kCoincide_m) continue;
    bubbles_[i].map_from_base.yaw_rad = std::atan2(way.y, way.x);
  }
}

void ElasticBand::Measure(const BandSpace& space, BandBubble& bubble) const {
  bubble.radius_m =
      space.FreeDistance_m(bubble.map_from_base, options_.influence_m);
}

geometry::Vec2 ElasticBand::ForceOn(size_t i, const BandSpace& space) const {
  const BandBubble& bubble = bubbles_[i];
  const geometry::Vec2 to_before = At(bubbles_[i - 1]) - At(bubble);
  const geometry::Vec2 to_after = At(bubbles_[i + 1]) - At(bubble);
  geometry::Vec2 force = Unit(to_before) + Unit(to_after);
  if (bubble.radius_m < options_.influence_m) {
    const auto radius_at = [&](double dx, double dy) {
      geometry::Rigid2 pose = bubble.map_from_base;
      pose.translation = pose.translation + geometry::Vec2{dx, dy};
      return space.FreeDistance_m(pose, options_.influence_m);
    };
    geometry::Vec2 gradient = {
        (radius_at(kGradientStep_m, 0) - radius_at(-kGradientStep_m, 0)) /
            (2 * kGradientStep_m),
        (radius_at(0, kGradientStep_m) - radius_at(0, -kGradientStep_m)) /
            (2 * kGradientStep_m)};
    // Within something the footprint's distance says little.
    if (bubble.radius_m <= kTouch_m &&
        geometry::Norm(gradient) < kFlatGradient) {
      gradient = space.Away(At(bubble));
    }
    const double length = geometry::Norm(gradient);
    if (length > 1) gradient = (1 / length) * gradient;
    force = force + options_.repulsion *
                        (options_.influence_m - bubble.radius_m) * gradient;
  }
  const geometry::Vec2 along = Unit(At(bubbles_[i + 1]) - At(bubbles_[i - 1]));
  return force - geometry::Dot(force, along) * along;
}

void ElasticBand::MoveBubbles(const BandSpace& space) {
  for (size_t i = 1; i + 1 < bubbles_.size(); ++i) {
    const geometry::Vec2 force = ForceOn(i, space);
    // One in something is moved as if it had this much room.
    geometry::Vec2 move = options_.gain *
                          std::max(kManoeuvreRoom_m, bubbles_[i].radius_m) *
                          force;
    const double length_m = geometry::Norm(move);
    if (length_m < 1e-5) continue;
    if (length_m > options_.max_move_m) {
      move = (options_.max_move_m / length_m) * move;
    }
    BandBubble moved = bubbles_[i];
    moved.map_from_base.translation = At(moved) + move;
    Measure(space, moved);
    // Never into something; one that is in something may only get out.
    if (moved.radius_m > kTouch_m || moved.radius_m > bubbles_[i].radius_m) {
      bubbles_[i] = moved;
    }
  }
}

double ElasticBand::WayBetween_m(const BandBubble& a,
                                 const BandBubble& b) const {
  return geometry::Norm(At(b) - At(a));
}

bool ElasticBand::HangTogether(const BandBubble& a, const BandBubble& b,
                               const BandSpace& space) const {
  const double way_m = WayBetween_m(a, b);
  const double turn_m = options_.turn_m_per_rad *
                        std::abs(geometry::NormalizedAngle_rad(
                            b.map_from_base.yaw_rad - a.map_from_base.yaw_rad));
  if (way_m + turn_m < a.radius_m + b.radius_m) return true;
  // In narrow places bubbles are small: what lies between is looked at.
  if (way_m > options_.max_spacing_m) return false;
  const int parts =
      static_cast<int>(std::ceil(way_m / (0.5 * options_.min_spacing_m)));
  geometry::Rigid2 between = Between(a, b).map_from_base;
  for (int part = 1; part < parts; ++part) {
    between.translation =
        At(a) + (static_cast<double>(part) / parts) * (At(b) - At(a));
    if (space.FreeDistance_m(between, options_.influence_m) <= kTouch_m) {
      return false;
    }
  }
  return true;
}

void ElasticBand::FillAndThin(const BandSpace& space) {
  std::vector<BandBubble> filled;
  filled.reserve(bubbles_.size() + 8);
  const auto most = static_cast<size_t>(options_.max_bubbles);
  for (size_t i = 0; i < bubbles_.size(); ++i) {
    if (!filled.empty()) {
      // Where neighbours no longer overlap, one goes between.
      const BandBubble& last = filled.back();
      const double way_m = WayBetween_m(last, bubbles_[i]);
      const double room_m =
          std::clamp(kOverlapShare * (last.radius_m + bubbles_[i].radius_m),
                     2 * options_.min_spacing_m, options_.max_spacing_m);
      const size_t taken = filled.size() + bubbles_.size() - i;
      if (way_m > room_m && taken < most) {
        const int pieces = std::min(static_cast<int>(std::ceil(way_m / room_m)),
                                    static_cast<int>(most - taken) + 1);
        const geometry::Vec2 begin = At(last);
        BandBubble between = Between(last, bubbles_[i]);
        for (int piece = 1; piece < pieces; ++piece) {
          between.map_from_base.translation =
              begin +
              (static_cast<double>(piece) / pieces) * (At(bubbles_[i]) - begin);
          Measure(space, between);
          filled.push_back(between);
        }
      }
      // One whose neighbours overlap is not needed.
      const bool is_inner = i + 1 < bubbles_.size();
      if (is_inner) {
        const double over_m = WayBetween_m(filled.back(), bubbles_[i + 1]);
        const double limit_m = std::clamp(
            kOverlapShare * (filled.back().radius_m + bubbles_[i + 1].radius_m),
            2 * options_.min_spacing_m, options_.max_spacing_m);
        if (over_m < kOverlapShare * limit_m) continue;
      }
    }
    filled.push_back(bubbles_[i]);
  }
  bubbles_ = std::move(filled);
}

void ElasticBand::Relax(const BandSpace& space) {
  if (bubbles_.size() < 2) {
    for (BandBubble& bubble : bubbles_) Measure(space, bubble);
    return;
  }
  for (int iteration = 0; iteration < options_.iterations; ++iteration) {
    SetHeadings();
    for (BandBubble& bubble : bubbles_) Measure(space, bubble);
    FillAndThin(space);
    SetHeadings();
    MoveBubbles(space);
  }
  SetHeadings();
  for (BandBubble& bubble : bubbles_) Measure(space, bubble);
}

std::optional<size_t> ElasticBand::FirstBreak(const BandSpace& space) const {
  double along_m = 0;
  for (size_t i = 1; i < bubbles_.size(); ++i) {
    along_m += WayBetween_m(bubbles_[i - 1], bubbles_[i]);
    // Where the robot stands too near to something, it may get away.
    if (bubbles_[0].radius_m <= kTouch_m && along_m < kLeaving_m &&
        bubbles_[i].radius_m >= bubbles_[i - 1].radius_m - kMaxApproach_m) {
      continue;
    }
    if (bubbles_[i].radius_m <= kTouch_m ||
        !HangTogether(bubbles_[i - 1], bubbles_[i], space)) {
      return i;
    }
  }
  return std::nullopt;
}

}  // namespace treeline::control
