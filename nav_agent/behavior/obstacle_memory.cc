#include "nav_agent/behavior/obstacle_memory.h"

#include <algorithm>
#include <cmath>

#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

enum class Beam { kBeside, kPasses, kEndsIn };

Beam Judge(const planning::Blockage& blockage, geometry::Vec2 laser,
           geometry::Vec2 end) {
  const geometry::Vec2 way = end - laser;
  const double length_m = geometry::Norm(way);
  if (length_m < 1e-6) return Beam::kBeside;
  const geometry::Vec2 to_center = blockage.center - laser;
  const double along_m = geometry::Dot(to_center, way) / length_m;
  const double beside_m = std::abs(geometry::Cross(way, to_center)) / length_m;
  const double radius_m = std::max(blockage.radius_m, kMinBlockageRadius_m);
  if (geometry::Norm(end - blockage.center) <= radius_m) return Beam::kEndsIn;
  if (beside_m > kBlockageMiddle * radius_m || along_m <= 0)
    return Beam::kBeside;
  return length_m > along_m + radius_m ? Beam::kPasses : Beam::kBeside;
}

}  // namespace

void ObstacleMemory::Add(const planning::Blockage& blockage,
                         base::MonotonicTime now) {
  planning::Blockage added = blockage;
  added.radius_m = std::min(kMaxBlockageRadius_m.value, blockage.radius_m);
  for (Known& known : known_) {
    planning::Blockage& old = known.blockage;
    if (old.level != added.level ||
        geometry::Norm(old.center - added.center) > kSameBlockage_m) {
      continue;
    }
    old.radius_m = std::max(old.radius_m, added.radius_m);
    // The same, seen twice at once, was not met again.
    if (base::SecondsBetween(known.since, now) > kBlockageMetAgain_s) {
      known.lasts_s = std::min(2 * known.lasts_s, limits_.longest_blockage_s);
    } else if (known.since != now) {
      // A way that was to lead around it did not: it is larger than that.
      old.radius_m = std::min(old.radius_m + kBlockageGrowth_m,
                              kMaxBlockageRadius_m.value);
    }
    known.since = now;
    known.seen_free = 0;
    return;
  }
  known_.push_back(
      {.blockage = added, .since = now, .lasts_s = limits_.blockage_s});
}

int ObstacleMemory::Fade(base::MonotonicTime now) {
  return static_cast<int>(std::erase_if(known_, [now](const Known& known) {
    return base::SecondsBetween(known.since, now) > known.lasts_s;
  }));
}

int ObstacleMemory::SeeThrough(
    int level, geometry::Vec2 laser, const std::vector<geometry::Vec2>& ends,
    const std::function<bool(const planning::Blockage&)>& is_seen) {
  for (Known& known : known_) {
    const planning::Blockage& blockage = known.blockage;
    if (blockage.level != level ||
        geometry::Norm(blockage.center - laser) > kMaxSeeThrough_m) {
      continue;
    }
    int passes = 0;
    int ends_in = 0;
    for (const geometry::Vec2& end : ends) {
      const Beam beam = Judge(blockage, laser, end);
      passes += beam == Beam::kPasses ? 1 : 0;
      ends_in += beam == Beam::kEndsIn ? 1 : 0;
    }
    if (ends_in > 0 || (passes >= kSeeThroughBeams && is_seen(blockage))) {
      known.seen_free = 0;
    } else if (passes >= kSeeThroughBeams) {
      ++known.seen_free;
    }
  }
  return static_cast<int>(std::erase_if(known_, [](const Known& known) {
    return known.seen_free >= kSeeThroughScans;
  }));
}

std::vector<planning::Blockage> ObstacleMemory::All() const {
  std::vector<planning::Blockage> all;
  all.reserve(known_.size());
  for (const Known& known : known_) all.push_back(known.blockage);
  return all;
}

}  // namespace treeline::behavior
