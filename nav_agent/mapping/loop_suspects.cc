#include "nav_agent/mapping/loop_suspects.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace treeline::mapping {
namespace {

// Suspected loops that put the robot this near to each other are one.
constexpr double kSameSuspect_m = 0.3;
constexpr double kSameSuspect_rad = 0.1;

// Where a loop puts its later keyscan.
geometry::Rigid2 PlaceOf(const LoopLink& link,
                         std::span<const geometry::Rigid2> poses) {
  return poses[static_cast<size_t>(link.constraint.from)] *
         link.constraint.from_from_to;
}

}  // namespace

bool LoopSuspectOptions::IsValid() const {
  return max_contradicted >= 0 && moved_m > 0 && min_followed >= 0 &&
         follow_m >= 0 && give_up_m > follow_m;
}

bool LoopSuspects::IsSuspect(const LoopLink& link,
                             std::span<const geometry::Rigid2> poses) const {
  const geometry::Rigid2& here = poses[static_cast<size_t>(link.constraint.to)];
  return link.wide && geometry::Norm(PlaceOf(link, poses).translation -
                                     here.translation) > options_.moved_m;
}

geometry::Rigid2 LoopSuspects::PlaceIf(
    const Suspect& suspect, int keyscan,
    std::span<const geometry::Rigid2> poses) {
  const LoopLink& link = suspect.links.back();
  return PlaceOf(link, poses) *
         poses[static_cast<size_t>(link.constraint.to)].Inverse() *
         poses[static_cast<size_t>(keyscan)];
}

bool LoopSuspects::Add(const LoopLink& link,
                       std::span<const geometry::Rigid2> poses) {
  const geometry::Rigid2 place_from_map = PlaceOf(link, poses).Inverse();
  for (const Suspect& suspect : suspects_) {
    const geometry::Rigid2 apart =
        place_from_map * PlaceIf(suspect, link.constraint.to, poses);
    if (geometry::Norm(apart.translation) < kSameSuspect_m &&
        std::abs(apart.yaw_rad) < kSameSuspect_rad) {
      return false;
    }
  }
  suspects_.push_back({.links = {link}});
  return true;
}

void LoopSuspects::Follow(
    int keyscan, std::span<const geometry::Rigid2> poses,
    const std::function<
        FollowedKeyscan(const geometry::Rigid2& map_from_keyscan)>& look) {
  for (Suspect& suspect : suspects_) {
    const FollowedKeyscan seen = look(PlaceIf(suspect, keyscan, poses));
    if (seen.found.has_value()) suspect.links.push_back(*seen.found);
    if (seen.is_contradicted) ++suspect.against;
  }
}

double LoopSuspects::Followed_m(const Suspect& suspect,
                                std::span<const double> way_m) {
  const int begin = suspect.links.front().constraint.to;
  return way_m.back() - way_m[static_cast<size_t>(begin)];
}

bool LoopSuspects::IsConfirmed(const Suspect& suspect,
                               std::span<const double> way_m,
                               bool is_last_chance) const {
  const int found = static_cast<int>(suspect.links.size()) - 1;
  Contradictions there;
  Contradictions otherwise;
  for (const LoopLink& link : suspect.links) {
    there += link.there;
    otherwise += link.otherwise;
  }
  if (found < suspect.against || options_.IsContradicted(there, otherwise)) {
    return false;
  }
  const bool is_followed = Followed_m(suspect, way_m) >= options_.follow_m;
  return is_last_chance ? found > 0 || !is_followed
                        : found >= options_.min_followed && is_followed;
}

std::vector<LoopLink> LoopSuspects::TakeConfirmed(std::span<const double> way_m,
                                                  bool is_last_chance) {
  Suspect* best = nullptr;
  for (Suspect& suspect : suspects_) {
    if (!IsConfirmed(suspect, way_m, is_last_chance)) continue;
    if (best == nullptr || suspect.links.size() > best->links.size()) {
      best = &suspect;
    }
  }
  if (best == nullptr) return {};
  std::vector<LoopLink> links = std::move(best->links);
  suspects_.clear();
  return links;
}

int LoopSuspects::GiveUp(std::span<const double> way_m) {
  return static_cast<int>(std::erase_if(suspects_, [&](const Suspect& suspect) {
    return Followed_m(suspect, way_m) > options_.give_up_m;
  }));
}

}  // namespace treeline::mapping
