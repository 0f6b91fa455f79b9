#include "nav_agent/mapless/mover_tracker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {
namespace {

// Beams end on one thing if their ends are no further apart than this, and this
// share of the range.
constexpr double kGap_m = 0.1;
constexpr double kGapOfRange = 0.03;
// So many beams make a thing; what is wider is a wall.
constexpr size_t kLeastBeams = 4;
constexpr double kWidest_m = 1.8;
constexpr double kLargestRadius_m = 0.9;
// Two things that touch make a dent: an end of a beam lies so much further off
// than the line between those so far on either side of it.
constexpr double kDentReach_m = 0.15;
constexpr double kDent_m = 0.04;
// Narrower ones of those are no things of their own, nor is what may not move:
// clutter has many dents, and others at each step.
constexpr double kLeastPart_m = 0.3;
// A circle fits if its points are so near to it.
constexpr double kCircle_m = 0.03;
// A thing is taken for the one that was expected within this.
constexpr double kReach_m = 0.5;
constexpr size_t kLeastFitted = 8;
// It moves from this speed on, and stands from that.
constexpr double kMoves_mps = 0.25;
constexpr double kStands_mps = 0.12;
// At most so many of its points may be where something has stood for so many
// scans, 0.6 s, and at least so many must be where nothing was.
constexpr uint32_t kOldScans = 24;
constexpr double kMostOld = 0.4;
constexpr double kLeastNew = 0.2;
// Its middle is this far from the line at most.
constexpr double kOffLine_m = 0.08;
constexpr double kErased_m = 0.1;

// How much further from where it was seen than the line from `a` to `b`.
double Behind_m(const GridBeam& beam, geometry::Vec2 a, geometry::Vec2 b) {
  const geometry::Vec2 along = b - a;
  const double length_m = geometry::Norm(along);
  if (length_m < 1e-9) return 0;
  const double side = geometry::Cross(along, beam.to - a) / length_m;
  return geometry::Cross(along, beam.from - a) > 0 ? -side : side;
}

// Where the deepest dent is: the index of the first beam behind it; nullopt:
// there is none.
std::optional<size_t> DeepestDent(std::span<const GridBeam> beams) {
  std::optional<size_t> deepest;
  double depth_m = kDent_m;
  size_t before = 0;
  size_t behind = 0;
  const auto is_near = [&](size_t i, size_t j) {
    return geometry::Norm(beams[j].to - beams[i].to) < kDentReach_m;
  };
  for (size_t i = 0; i < beams.size(); ++i) {
    while (before + 1 < i && !is_near(i, before + 1)) ++before;
    behind = std::max(behind, i);
    while (behind + 1 < beams.size() && is_near(i, behind)) ++behind;
    if (is_near(i, before) || is_near(i, behind)) continue;
    const double this_m =
        Behind_m(beams[i], beams[before].to, beams[behind].to);
    if (this_m > depth_m) {
      depth_m = this_m;
      deepest = i;
    }
  }
  return deepest;
}

// The middle of the circle through the points (Kasa's least squares), from
// their mean; nullopt: they lie on a line.
std::optional<geometry::Vec2> CircleThrough(std::span<const GridBeam> beams,
                                            geometry::Vec2 mean) {
  double xx = 0;
  double xy = 0;
  double yy = 0;
  double xz = 0;
  double yz = 0;
  for (const GridBeam& beam : beams) {
    const geometry::Vec2 p = beam.to - mean;
    const double z = p.x * p.x + p.y * p.y;
    xx += p.x * p.x;
    xy += p.x * p.y;
    yy += p.y * p.y;
    xz += p.x * z;
    yz += p.y * z;
  }
  const double determinant = xx * yy - xy * xy;
  if (determinant < 1e-9) return std::nullopt;
  return mean + (0.5 / determinant) *
                    geometry::Vec2{yy * xz - xy * yz, xx * yz - xy * xz};
}

}  // namespace

std::optional<MoverTracker::Thing> MoverTracker::ThingOf(
    std::span<const GridBeam> beams, size_t first, size_t count,
    const EvidenceGrid& map) {
  const std::span<const GridBeam> own = beams.subspan(first, count);
  const double wide_m = geometry::Norm(own.back().to - own.front().to);
  if (count < kLeastBeams || wide_m > kWidest_m) return std::nullopt;
  Thing thing;
  thing.first = first;
  thing.count = count;
  geometry::Vec2 mean;
  for (const GridBeam& beam : own) {
    mean = mean + (1.0 / static_cast<double>(count)) * beam.to;
    const core::CellIndex cell = map.CellOf(beam.to);
    thing.old_share += map.HasStood(cell, kOldScans) ? 1 : 0;
    thing.new_share += map.At(cell) == core::Occupancy::kFree ? 1 : 0;
  }
  thing.old_share /= static_cast<double>(count);
  thing.new_share /= static_cast<double>(count);
  thing.center = mean;
  thing.radius_m = wide_m / 2;
  const auto center = CircleThrough(own, mean);
  if (!center.has_value()) return thing;
  double radius_m = 0;
  for (const GridBeam& beam : own) {
    radius_m += geometry::Norm(beam.to - *center) / static_cast<double>(count);
  }
  double off_m = 0;
  for (const GridBeam& beam : own) {
    off_m =
        std::max(off_m, std::abs(geometry::Norm(beam.to - *center) - radius_m));
  }
  const geometry::Vec2 from = own[count / 2].from;
  const bool bulges =
      geometry::Norm(*center - from) > geometry::Norm(mean - from);
  if (off_m < kCircle_m && radius_m < kLargestRadius_m && bulges) {
    thing.center = *center;
    thing.radius_m = radius_m;
    thing.is_round = true;
  }
  return thing;
}

void MoverTracker::AddThings(std::span<const GridBeam> beams, size_t first,
                             size_t count, const EvidenceGrid& map,
                             std::vector<Thing>& things) {
  const size_t known = things.size();
  // Parts that are still to be looked at, the last one first.
  std::vector<std::pair<size_t, size_t>> parts = {{first, count}};
  while (!parts.empty()) {
    const auto [at, beams_of_it] = parts.back();
    parts.pop_back();
    const auto dent = DeepestDent(beams.subspan(at, beams_of_it));
    if (dent.has_value() && *dent > 0) {
      parts.emplace_back(at + *dent, beams_of_it - *dent);
      parts.emplace_back(at, *dent);
      continue;
    }
    if (beams_of_it == count) break;
    const auto thing = ThingOf(beams, at, beams_of_it, map);
    if (thing.has_value() && thing->is_round && thing->old_share < kMostOld &&
        thing->new_share > kLeastNew &&
        geometry::Norm(beams[at + beams_of_it - 1].to - beams[at].to) >
            kLeastPart_m) {
      things.push_back(*thing);
    }
  }
  if (things.size() > known) return;
  if (const auto thing = ThingOf(beams, first, count, map)) {
    things.push_back(*thing);
  }
}

std::vector<MoverTracker::Thing> MoverTracker::ThingsIn(
    std::span<const GridBeam> beams, const EvidenceGrid& map) {
  std::vector<Thing> things;
  size_t first = 0;
  for (size_t i = 1; i <= beams.size(); ++i) {
    if (i < beams.size()) {
      const double range_m = geometry::Norm(beams[i].to - beams[i].from);
      if (geometry::Norm(beams[i].to - beams[i - 1].to) <
          kGap_m + kGapOfRange * range_m) {
        continue;
      }
    }
    AddThings(beams, first, i - first, map, things);
    first = i;
  }
  return things;
}

void MoverTracker::Follow(Track& track, const Thing& thing,
                          base::MonotonicTime stamp, EvidenceGrid& map) {
  track.seen.push_back({stamp, thing.center});
  while (track.seen.size() > static_cast<size_t>(kFittedScans.value)) {
    track.seen.pop_front();
  }
  // The line through them, by least squares.
  const auto n = static_cast<double>(track.seen.size());
  double t_sum = 0;
  double tt_sum = 0;
  geometry::Vec2 sum;
  geometry::Vec2 t_weighted;
  for (const Sighting& sighting : track.seen) {
    const double t = base::SecondsBetween(stamp, sighting.stamp);
    t_sum += t;
    tt_sum += t * t;
    sum = sum + sighting.center;
    t_weighted = t_weighted + t * sighting.center;
  }
  const double spread = n * tt_sum - t_sum * t_sum;
  track.stamp = stamp;
  track.velocity_mps = spread > 1e-9
                           ? (1 / spread) * (n * t_weighted - t_sum * sum)
                           : geometry::Vec2();
  track.in_map = (1 / n) * (sum - t_sum * track.velocity_mps);
  // A part that is seen may be smaller.
  track.radius_m = std::max(0.9 * track.radius_m, thing.radius_m);
  double off_m = 0;
  for (const Sighting& sighting : track.seen) {
    const double t = base::SecondsBetween(stamp, sighting.stamp);
    off_m =
        std::max(off_m, geometry::Norm(track.in_map + t * track.velocity_mps -
                                       sighting.center));
  }
  const double speed_mps = geometry::Norm(track.velocity_mps);
  if (track.moves) {
    track.moves = speed_mps > kStands_mps;
    return;
  }
  track.moves = track.seen.size() >= kLeastFitted && speed_mps > kMoves_mps &&
                off_m < kOffLine_m && thing.old_share < kMostOld &&
                thing.new_share > kLeastNew;
  if (!track.moves) return;
  for (const Sighting& sighting : track.seen) {
    map.ForgetNew(sighting.center, track.radius_m + kErased_m, kOldScans);
  }
}

void MoverTracker::Add(base::MonotonicTime stamp, std::span<GridBeam> beams,
                       EvidenceGrid& map) {
  const std::vector<Thing> things = ThingsIn(beams, map);
  // Of what moves the nearest two belong to each other, then the nearest of the
  // others: what passes before another does not take its track. Then come those
  // that stand, one after the other.
  struct Pair {
    size_t turn;
    double apart_m;
    size_t track;
    size_t thing;
  };
  std::vector<Pair> pairs;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    const geometry::Vec2 expected =
        track.in_map +
        base::SecondsBetween(track.stamp, stamp) * track.velocity_mps;
    for (size_t j = 0; j < things.size(); ++j) {
      const double apart_m = geometry::Norm(things[j].center - expected);
      if (apart_m <= kReach_m)
        pairs.push_back({track.moves ? 0 : 1 + i, apart_m, i, j});
    }
  }
  std::ranges::stable_sort(pairs, {}, [](const Pair& pair) {
    return std::pair(pair.turn, pair.apart_m);
  });
  std::vector<bool> is_followed(tracks_.size(), false);
  std::vector<bool> is_known(things.size(), false);
  for (const Pair& pair : pairs) {
    if (is_followed[pair.track] || is_known[pair.thing]) continue;
    is_followed[pair.track] = true;
    is_known[pair.thing] = true;
    Track& track = tracks_[pair.track];
    const Thing& thing = things[pair.thing];
    Follow(track, thing, stamp, map);
    if (!track.moves) continue;
    for (GridBeam& beam : beams.subspan(thing.first, thing.count)) {
      beam.is_on_mover = true;
    }
  }
  std::erase_if(tracks_, [&](const Track& track) {
    const double unseen_s = base::SecondsBetween(track.stamp, stamp);
    return unseen_s > (track.moves ? kMoverMemory_s.value : 0.1);
  });
  for (size_t i = 0; i < things.size(); ++i) {
    if (is_known[i]) continue;
    const Thing& thing = things[i];
    Track& track = tracks_.emplace_back();
    track.stamp = stamp;
    track.in_map = thing.center;
    track.radius_m = thing.radius_m;
    track.seen.push_back({stamp, thing.center});
  }
}

std::vector<Mover> MoverTracker::MoversAt(base::MonotonicTime now) const {
  std::vector<Mover> movers;
  for (const Track& track : tracks_) {
    if (!track.moves) continue;
    movers.push_back(
        {.in_map = track.in_map +
                   base::SecondsBetween(track.stamp, now) * track.velocity_mps,
         .velocity_mps = track.velocity_mps,
         .radius_m = track.radius_m});
  }
  return movers;
}

}  // namespace treeline::mapless
