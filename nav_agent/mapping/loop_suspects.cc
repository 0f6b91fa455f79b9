// Loops that would bend the map: followed, tried and compared before they are
// believed. The part of LoopCloser that doubts.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "nav_agent/mapping/loop_closer.h"

namespace treeline::mapping {
namespace {

// Suspected loops that put the robot this near to each other are one.
constexpr double kSameSuspect_m = 0.3;
constexpr double kSameSuspect_rad = 0.1;
// Scans of different passes are compared with so many others, of every so many
// keyscans.
constexpr size_t kCompared = 4;
constexpr size_t kComparedEvery = 2;

}  // namespace

Contradictions LoopCloser::ContradictionsOf(
    int keyscan, const geometry::Rigid2& map_from_keyscan,
    const Chain& chain) const {
  Contradictions found;
  for (int i = chain.begin; i < chain.end; ++i) {
    found +=
        Between(keyscan, i,
                map_from_keyscan.Inverse() * poses_[static_cast<size_t>(i)]);
  }
  return found;
}

Contradictions LoopCloser::Between(int a, int b,
                                   const geometry::Rigid2& a_from_b) const {
  const auto slot_a = static_cast<size_t>(a);
  const auto slot_b = static_cast<size_t>(b);
  Contradictions found = seen_[slot_a].Contradicted(*scans_[slot_b], a_from_b);
  found += seen_[slot_b].Contradicted(*scans_[slot_a], a_from_b.Inverse());
  return found;
}

Contradictions LoopCloser::ContradictionsAmong() const {
  Contradictions found;
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i < poses_.size(); i += kComparedEvery) {
    near.clear();
    for (size_t k = 0; k < i; ++k) {
      if (way_m_[i] - way_m_[k] < MinLoop_m()) break;
      const double apart_m =
          geometry::Norm(poses_[i].translation - poses_[k].translation);
      if (apart_m > options_.overlap_m ||
          !SeesTheSame(static_cast<int>(i), static_cast<int>(k))) {
        continue;
      }
      near.emplace_back(apart_m, k);
    }
    const size_t count = std::min(near.size(), kCompared);
    std::partial_sort(near.begin(),
                      near.begin() + static_cast<ptrdiff_t>(count), near.end());
    for (size_t n = 0; n < count; ++n) {
      const size_t k = near[n].second;
      found += Between(static_cast<int>(i), static_cast<int>(k),
                       poses_[i].Inverse() * poses_[k]);
    }
  }
  return found;
}

double LoopCloser::Moved_m(const PoseConstraint& loop) const {
  const geometry::Rigid2 map_from_to =
      poses_[static_cast<size_t>(loop.from)] * loop.from_from_to;
  return geometry::Norm(map_from_to.translation -
                        poses_[static_cast<size_t>(loop.to)].translation);
}

geometry::Rigid2 LoopCloser::PlaceIf(const SuspectedLoop& suspect,
                                     int keyscan) const {
  const PoseConstraint& loop = suspect.links.back().constraint;
  return poses_[static_cast<size_t>(loop.from)] * loop.from_from_to *
         poses_[static_cast<size_t>(loop.to)].Inverse() *
         poses_[static_cast<size_t>(keyscan)];
}

void LoopCloser::Suspect(const Link& link) {
  const PoseConstraint& loop = link.constraint;
  const geometry::Rigid2 place_from_map =
      (poses_[static_cast<size_t>(loop.from)] * loop.from_from_to).Inverse();
  for (const SuspectedLoop& suspect : suspects_) {
    const geometry::Rigid2 apart = place_from_map * PlaceIf(suspect, loop.to);
    if (geometry::Norm(apart.translation) < kSameSuspect_m &&
        std::abs(apart.yaw_rad) < kSameSuspect_rad) {
      return;
    }
  }
  suspects_.push_back({.links = {link}});
  ++statistics_.suspected;
}

void LoopCloser::FollowSuspects(int keyscan) {
  for (SuspectedLoop& suspect : suspects_) {
    const geometry::Rigid2 place = PlaceIf(suspect, keyscan);
    const std::vector<Chain> chains =
        ChainsNear(keyscan, place.translation, {}, options_.recent, 1);
    if (chains.empty()) continue;
    const std::optional<Link> link =
        TryChain(keyscan, chains.front(), place, NearSearch());
    if (link.has_value()) {
      suspect.links.push_back(*link);
    } else if (IsContradicted(ContradictionsOf(keyscan, place, chains.front()),
                              ContradictionsOf(
                                  keyscan, poses_[static_cast<size_t>(keyscan)],
                                  chains.front()))) {
      // Where it fits as well elsewhere, or little is seen, it says nothing.
      ++suspect.against;
    }
  }
}

double LoopCloser::Followed_m(const SuspectedLoop& suspect) const {
  const int begin = suspect.links.front().constraint.to;
  return way_m_.back() - way_m_[static_cast<size_t>(begin)];
}

bool LoopCloser::IsConfirmed(const SuspectedLoop& suspect,
                             bool is_last_chance) const {
  const int found = static_cast<int>(suspect.links.size()) - 1;
  Contradictions there;
  Contradictions otherwise;
  for (const Link& link : suspect.links) {
    there += link.there;
    otherwise += link.otherwise;
  }
  if (found < suspect.against || IsContradicted(there, otherwise)) return false;
  const bool is_followed = Followed_m(suspect) >= options_.follow_m;
  return is_last_chance ? found > 0 || !is_followed
                        : found >= options_.min_followed && is_followed;
}

bool LoopCloser::BelieveSuspect(bool is_last_chance) {
  const SuspectedLoop* best = nullptr;
  for (const SuspectedLoop& suspect : suspects_) {
    if (!IsConfirmed(suspect, is_last_chance)) continue;
    if (best == nullptr || suspect.links.size() > best->links.size()) {
      best = &suspect;
    }
  }
  bool bends = false;
  if (best != nullptr) {
    const std::vector<Link> links = best->links;
    suspects_.clear();
    bends = TryBending(links);
  }
  statistics_.given_up += static_cast<int64_t>(
      std::erase_if(suspects_, [&](const SuspectedLoop& suspect) {
        return Followed_m(suspect) > options_.give_up_m;
      }));
  return bends;
}

bool LoopCloser::TryBending(const std::vector<Link>& links) {
  const std::vector<geometry::Rigid2> poses = poses_;
  const std::vector<double> heights_m = heights_m_;
  const std::vector<PoseConstraint> constraints = constraints_;
  const LoopCloserStatistics statistics = statistics_;
  const Contradictions before = ContradictionsAmong();
  for (const Link& link : links) Believe(link);
  Optimize();
  if (!IsContradicted(ContradictionsAmong(), before)) return true;
  statistics_ = statistics;
  ++statistics_.undone;
  poses_ = poses;
  heights_m_ = heights_m;
  constraints_ = constraints;
  IndexConstraints();
  return false;
}

}  // namespace treeline::mapping
