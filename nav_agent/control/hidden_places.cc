#include "nav_agent/control/hidden_places.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

namespace treeline::control {
namespace {

constexpr uint32_t Bit(int who) { return uint32_t{1} << who; }

}  // namespace

HiddenPlaces::HiddenPlaces(const HiddenPlacesOptions& options)
    : options_(options),
      window_(
          CostmapWindow(options.size_m, options.size_m, options.resolution_m)
              .CenteredAt({0, 0})),
      may_be_(window_.cells(), 0) {}

void HiddenPlaces::Clear() {
  std::ranges::fill(may_be_, 0);
  taken_ = 0;
  to_grow_m_ = 0;
}

std::optional<int> HiddenPlaces::Take() {
  const int who = std::countr_one(taken_);
  if (who >= 32) return std::nullopt;
  taken_ |= Bit(who);
  return who;
}

void HiddenPlaces::Give(int who) {
  for (uint32_t& may_be : may_be_) may_be &= ~Bit(who);
  taken_ &= ~Bit(who);
}

void HiddenPlaces::Put(int who, geometry::Vec2 in_map, double radius_m) {
  for (int y = 0; y < window_.height(); ++y) {
    for (int x = 0; x < window_.width(); ++x) {
      uint32_t& may_be = may_be_[window_.IndexOf(x, y)];
      may_be &= ~Bit(who);
      if (geometry::Norm(window_.CenterInMap(x, y) - in_map) < radius_m) {
        may_be |= Bit(who);
      }
    }
  }
}

void HiddenPlaces::MoveTo(geometry::Vec2 at) {
  const CostmapWindow before = window_;
  window_ = window_.CenteredAt(at);
  if (window_.IsSamePlaceAs(before)) return;
  const auto off_x = static_cast<int>(window_.cell_x() - before.cell_x());
  const auto off_y = static_cast<int>(window_.cell_y() - before.cell_y());
  const std::vector<uint32_t> old =
      std::exchange(may_be_, std::vector<uint32_t>(window_.cells(), 0));
  for (int y = 0; y < window_.height(); ++y) {
    for (int x = 0; x < window_.width(); ++x) {
      if (before.IsInside(x + off_x, y + off_y)) {
        may_be_[window_.IndexOf(x, y)] =
            old[before.IndexOf(x + off_x, y + off_y)];
      }
    }
  }
}

// By a cell, along the axes alone or to all eight neighbours: by turns, so
// that a set grows nearly round.
void HiddenPlaces::Grow(bool is_diagonal, const IsSolid& is_solid) {
  const std::vector<uint32_t> old = may_be_;
  for (int y = 0; y < window_.height(); ++y) {
    for (int x = 0; x < window_.width(); ++x) {
      uint32_t all = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!window_.IsInside(x + dx, y + dy)) continue;
          if (dx != 0 && dy != 0 && !is_diagonal) continue;
          all |= old[window_.IndexOf(x + dx, y + dy)];
        }
      }
      uint32_t& may_be = may_be_[window_.IndexOf(x, y)];
      if (all == may_be) continue;
      if (is_solid == nullptr || !is_solid(window_.CenterInMap(x, y))) {
        may_be = all;
      }
    }
  }
}

void HiddenPlaces::Spread(geometry::Vec2 at, double interval_s,
                          const IsSolid& is_solid) {
  MoveTo(at);
  if (taken_ == 0) return;
  // Only the robot moves of what is solid.
  if (is_solid != nullptr) {
    for (int y = 0; y < window_.height(); ++y) {
      for (int x = 0; x < window_.width(); ++x) {
        uint32_t& may_be = may_be_[window_.IndexOf(x, y)];
        if (may_be != 0 && is_solid(window_.CenterInMap(x, y))) may_be = 0;
      }
    }
  }
  to_grow_m_ += options_.spread_mps * interval_s;
  while (to_grow_m_ >= window_.resolution_m()) {
    to_grow_m_ -= window_.resolution_m();
    grows_diagonally_ = !grows_diagonally_;
    Grow(grows_diagonally_, is_solid);
  }
}

void HiddenPlaces::LookThrough(std::span<const TrackedScan> looks) {
  const double behind_m = 0.5 * window_.resolution_m();
  for (int y = 0; y < window_.height(); ++y) {
    for (int x = 0; x < window_.width(); ++x) {
      uint32_t& may_be = may_be_[window_.IndexOf(x, y)];
      if (may_be == 0) continue;
      const geometry::Vec2 center = window_.CenterInMap(x, y);
      const bool is_seen_through =
          std::ranges::any_of(looks, [&](const TrackedScan& look) {
            const std::optional<BeamTowards> beam = BeamTo(look, center);
            return beam.has_value() && beam->range_m > beam->away_m + behind_m;
          });
      if (is_seen_through) may_be = 0;
    }
  }
}

double HiddenPlaces::Area_m2(int who) const {
  const auto cells = std::ranges::count_if(
      may_be_, [&](uint32_t may_be) { return (may_be & Bit(who)) != 0; });
  return static_cast<double>(cells) * window_.resolution_m() *
         window_.resolution_m();
}

bool HiddenPlaces::MayBeNear(int who, geometry::Vec2 in_map,
                             double radius_m) const {
  const core::CellIndex middle = window_.CellOf(in_map);
  const int reach = static_cast<int>(radius_m / window_.resolution_m()) + 1;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      if (window_.IsInside(x, y) &&
          (may_be_[window_.IndexOf(x, y)] & Bit(who)) != 0 &&
          geometry::Norm(window_.CenterInMap(x, y) - in_map) < radius_m) {
        return true;
      }
    }
  }
  return false;
}

std::vector<geometry::Vec2> HiddenPlaces::PlacesOf(uint32_t who) const {
  std::vector<geometry::Vec2> places;
  for (int y = 0; y < window_.height(); ++y) {
    for (int x = 0; x < window_.width(); ++x) {
      if ((may_be_[window_.IndexOf(x, y)] & who) != 0) {
        places.push_back(window_.CenterInMap(x, y));
      }
    }
  }
  return places;
}

}  // namespace treeline::control
