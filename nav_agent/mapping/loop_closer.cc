#include "nav_agent/mapping/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <queue>
#include <utility>

#include "common/base/parallel_for.h"

namespace treeline::mapping {
namespace {

// Links this far from the graph's estimate (squared error) move it at once;
// others wait until there are some.
constexpr double kMovesGraph = 4.0;
constexpr int kMaxWaiting = 10;
// How well heights of the same place agree, and what tilts are off.
constexpr double kSameGround_m = 0.01;
constexpr double kGroundTilt_rad = 0.01;
// What odometry's climb is off: a bias of tilts that was not seen, and slip.
constexpr double kClimb_m_per_m = 0.005;
constexpr double kClimb_m_per_climb_m = 0.03;
constexpr double kMinClimb_m = 0.0005;
constexpr double kLargestDrift = 0.05;
// Coarse cells are this many times as large as fine ones.
constexpr double kCoarse = 2.5;
// Narrow searches are made for every so many keyscans on the way.
constexpr int kNarrowEvery = 3;
// Of a query of several keyscans, every so many points are enough there.
constexpr size_t kCoarseEvery = 3;
// The fine search about the best coarse cell, in its cells.
constexpr double kFineSearch_cells = 1.5;
// The share of surfaces that must be seen from the same side.
constexpr double kSameSide = 0.8;
// Scans of different passes are compared with so many others, of every so many
// keyscans.
constexpr int kCompared = 4;
constexpr int kComparedEvery = 2;

double LargestSigma_m(const Covariance3& c) {
  const double mean = 0.5 * (c[0] + c[4]);
  const double spread = std::hypot(0.5 * (c[0] - c[4]), c[1]);
  return std::sqrt(std::max(0.0, mean + spread));
}

// By odometry, whose errors have tails; else by what the keyscan is tied with.
PoseConstraint PriorOf(const std::optional<OdometryStep>& odometry,
                       const PoseConstraint& tie) {
  if (!odometry.has_value()) return tie;
  const double m2 = odometry->sigma.m * odometry->sigma.m;
  const double rad2 = odometry->sigma.rad * odometry->sigma.rad;
  return {.from = tie.from,
          .to = tie.to,
          .from_from_to = odometry->previous_from_this,
          .covariance = {m2, 0, 0, 0, m2, 0, 0, 0, rad2},
          .may_be_wrong = true};
}

}  // namespace

std::vector<LoopCloser::Reach> LoopCloser::ReachFrom(int keyscan) const {
  // Dijkstra (Olson, "Robust and Efficient Robotic Mapping", 2008): variances
  // add up along the way, and what is not known of yaw turns all that follows.
  std::vector<Reach> reach(poses_.size());
  std::vector<uint8_t> done(poses_.size(), 0);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  reach[static_cast<size_t>(keyscan)].variance_m2 = 0;
  open.emplace(0.0, keyscan);
  while (!open.empty()) {
    const int at = open.top().second;
    open.pop();
    if (done[static_cast<size_t>(at)] != 0) continue;
    done[static_cast<size_t>(at)] = 1;
    const Reach here = reach[static_cast<size_t>(at)];
    for (const int index : constraints_of_[static_cast<size_t>(at)]) {
      const PoseConstraint& c = constraints_[static_cast<size_t>(index)];
      const int next = c.from == at ? c.to : c.from;
      const double length_m = geometry::Norm(c.from_from_to.translation);
      const Reach there = {
          .variance_m2 = here.variance_m2 + c.covariance[0] + c.covariance[4] +
                         here.variance_rad2 * length_m * length_m,
          .variance_rad2 = here.variance_rad2 + c.covariance[8],
          .way_m = here.way_m + length_m};
      Reach& known = reach[static_cast<size_t>(next)];
      if (there.variance_m2 < known.variance_m2) {
        known = there;
        open.emplace(there.variance_m2, next);
      }
    }
  }
  return reach;
}

MatchSearch LoopCloser::SearchFor(const Reach& reach) const {
  // No drift is larger than this part of the way: without that, a corridor in
  // which nothing is known along it matches with its own beginning.
  const double max_m = kLargestDrift * reach.way_m;
  return {.half_extent_m =
              std::clamp(std::min(max_m, options_.search_sigmas *
                                             std::sqrt(reach.variance_m2)) +
                             options_.search_of_way * reach.way_m,
                         options_.min_search_m, options_.max_search_m),
          .half_angle_rad = std::clamp(
              options_.search_sigmas * std::sqrt(reach.variance_rad2) +
                  0.2 * options_.search_of_way * reach.way_m,
              options_.min_search_rad, options_.max_search_rad)};
}

MatchSearch LoopCloser::NearSearch() const {
  return SearchFor({.variance_m2 = 0});
}

ScanPlane LoopCloser::PlaneOf(int keyscan) const {
  const auto slot = static_cast<size_t>(keyscan);
  return {.at = poses_[slot].translation,
          .height_m = heights_m_[slot],
          .slope = TurnedBy(poses_[slot].yaw_rad, slopes_[slot])};
}

bool LoopCloser::SeesTheSame(int a, int b) const {
  if (!climbs_) return true;
  const double way_m =
      std::abs(way_m_[static_cast<size_t>(a)] - way_m_[static_cast<size_t>(b)]);
  const double max_m =
      std::min(options_.max_gap_m + options_.max_gap_m_per_m * way_m,
               options_.largest_gap_m);
  const ScanPlane plane_a = PlaneOf(a);
  const ScanPlane plane_b = PlaneOf(b);
  return Gap_m(plane_a, plane_b) <= max_m &&
         TiltBetween(plane_a, plane_b) <= options_.max_tilt;
}

std::optional<geometry::Vec2> LoopCloser::UntoldBetween(int a, int b) const {
  const ScanPlane plane_a = PlaneOf(a);
  const ScanPlane plane_b = PlaneOf(b);
  const double tilt = TiltBetween(plane_a, plane_b);
  if (Gap_m(plane_a, plane_b) > options_.max_gap_m || tilt == 0) {
    return std::nullopt;
  }
  return (1 / tilt) * (plane_b.slope - plane_a.slope);
}

std::vector<LoopCloser::Chain> LoopCloser::ChainsNear(
    int keyscan, geometry::Vec2 here, const std::vector<Reach>& reach,
    int recent, int max_chains) const {
  std::vector<Chain> chains;
  Chain chain;
  const auto finish = [&] {
    if (chain.end - chain.begin >= options_.min_chain) {
      // Of a long chain, the part about the nearest keyscan.
      const int half = options_.max_chain / 2;
      chain.begin = std::max(chain.begin, chain.nearest - half);
      chain.end = std::min(chain.end, chain.begin + options_.max_chain);
      chains.push_back(chain);
    }
    chain = {};
  };
  for (int i = 0; i + recent < keyscan; ++i) {
    const double distance_m =
        geometry::Norm(poses_[static_cast<size_t>(i)].translation - here);
    const double search_m =
        reach.empty() ? options_.min_search_m
                      : SearchFor(reach[static_cast<size_t>(i)]).half_extent_m;
    // The search's own margin does not count when it is the smallest one.
    const double radius_m =
        options_.overlap_m + search_m - options_.min_search_m;
    // A loop comes back from somewhere; what is a little behind on the way is
    // the front end's matter, and pulls along a corridor.
    const double way_m =
        way_m_[static_cast<size_t>(keyscan)] - way_m_[static_cast<size_t>(i)];
    if (distance_m > radius_m || way_m < MinLoop_m() ||
        !SeesTheSame(i, keyscan)) {
      if (chain.end > 0) finish();
      continue;
    }
    if (chain.end == 0) {
      chain = {.begin = i, .nearest = i, .distance_m = distance_m};
    }
    if (distance_m < chain.distance_m) {
      chain.nearest = i;
      chain.distance_m = distance_m;
    }
    chain.end = i + 1;
  }
  if (chain.end > 0) finish();
  std::stable_sort(chains.begin(), chains.end(),
                   [](const Chain& a, const Chain& b) {
                     return a.distance_m < b.distance_m;
                   });
  if (static_cast<int>(chains.size()) > max_chains) {
    chains.resize(static_cast<size_t>(max_chains));
  }
  return chains;
}

std::vector<PlacedScan> LoopCloser::Placed(const Chain& chain) const {
  std::vector<PlacedScan> placed;
  for (int i = chain.begin; i < chain.end; ++i) {
    const auto slot = static_cast<size_t>(i);
    placed.push_back(
        {.scan = scans_[slot].get(), .target_from_scan = poses_[slot]});
  }
  return placed;
}

ScanOutline LoopCloser::QueryScan(int keyscan, int count) const {
  const geometry::Rigid2 this_from_map =
      poses_[static_cast<size_t>(keyscan)].Inverse();
  ScanOutline query;
  for (int i = std::max(0, keyscan - count + 1); i <= keyscan; ++i) {
    if (!SeesTheSame(i, keyscan)) continue;
    const auto slot = static_cast<size_t>(i);
    const geometry::Rigid2 this_from_other = this_from_map * poses_[slot];
    const ScanOutline& scan = *scans_[slot];
    for (size_t k = 0; k < scan.size(); ++k) {
      query.points_m.push_back(this_from_other * scan.points_m[k]);
      query.joined.push_back(scan.joined[k]);
    }
  }
  return query;
}

std::optional<LoopLink> LoopCloser::Verified(int keyscan, const Chain& chain,
                                             const ScanMatch& match,
                                             bool wide) const {
  const double needed =
      wide ? options_.min_wide_response : options_.min_response;
  if (match.response < needed || match.is_at_border ||
      LargestSigma_m(match.covariance) > options_.max_sigma_m ||
      std::sqrt(match.covariance[8]) > options_.max_sigma_rad) {
    return std::nullopt;
  }
  // The place found may be nearer to another keyscan of the chain.
  int nearest = chain.nearest;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (int i = chain.begin; i < chain.end; ++i) {
    const double distance_m =
        geometry::Norm(poses_[static_cast<size_t>(i)].translation -
                       match.target_from_scan.translation);
    if (distance_m < nearest_m) {
      nearest = i;
      nearest_m = distance_m;
    }
  }
  const geometry::Rigid2& map_from_nearest =
      poses_[static_cast<size_t>(nearest)];
  LoopLink link = {
      .constraint = {.from = nearest,
                     .to = keyscan,
                     .from_from_to =
                         map_from_nearest.Inverse() * match.target_from_scan,
                     .covariance =
                         Turned(match.covariance, -map_from_nearest.yaw_rad),
                     .may_be_wrong = true},
      .wide = wide,
      .there = ContradictionsOf(keyscan, match.target_from_scan, chain),
      .otherwise = ContradictionsOf(
          keyscan, poses_[static_cast<size_t>(keyscan)], chain)};
  if (options_.suspects.IsContradicted(link.there, link.otherwise)) {
    return std::nullopt;
  }
  SetClimb(match.target_from_scan, &link.constraint);
  return link;
}

void LoopCloser::SetClimb(const geometry::Rigid2& map_from_to,
                          PoseConstraint* constraint) const {
  const ScanPlane from = PlaneOf(constraint->from);
  ScanPlane to = from;
  to.at = map_from_to.translation;
  to.slope = TurnedBy(map_from_to.yaw_rad,
                      slopes_[static_cast<size_t>(constraint->to)]);
  const double length_m = geometry::Norm(to.at - from.at);
  if (!climbs_ || length_m > options_.same_ground_m) return;
  constraint->climb_m = ClimbBySlope_m(from, to);
  // A ramp may begin or end between the two.
  constraint->climb_sigma_m = kSameGround_m + kGroundTilt_rad * length_m +
                              0.5 * TiltBetween(from, to) * length_m;
}

std::optional<LoopLink> LoopCloser::TryChain(
    int keyscan, const Chain& chain, const geometry::Rigid2& map_from_expected,
    MatchSearch search) const {
  const auto slot = static_cast<size_t>(keyscan);
  const std::vector<PlacedScan> references = Placed(chain);
  const bool wide = search.half_extent_m > options_.wide_m;
  ScanOutline several;
  if (wide) several = QueryScan(keyscan, options_.query_scans);
  const ScanOutline& query = wide ? several : *scans_[slot];
  if (query.empty()) return std::nullopt;
  geometry::Rigid2 guess = map_from_expected;
  if (wide) {
    ScanMatcherOptions coarse = matcher_;
    coarse.cell_m *= kCoarse;
    coarse.sigma_m *= kCoarse;
    const ScanOutline thinned = Thinned(query, kCoarseEvery);
    const SurfaceGrid grid =
        MakeSurfaceGrid(references, thinned, guess, search, coarse);
    const ScanMatch match = MatchScan(grid, thinned, guess, search, coarse);
    // Along a corridor all places respond: none of them is found.
    if (match.response < options_.min_coarse_response ||
        LargestSigma_m(match.covariance) > options_.max_sigma_m) {
      return std::nullopt;
    }
    guess = match.target_from_scan;
    search = {.half_extent_m = kFineSearch_cells * coarse.cell_m,
              .half_angle_rad = 0.03};
  }
  const SurfaceGrid grid =
      MakeSurfaceGrid(references, query, guess, search, matcher_);
  const ScanMatch match = MatchScan(grid, query, guess, search, matcher_);
  if (ShareOfSameSide(grid, query, match.target_from_scan) < kSameSide) {
    return std::nullopt;
  }
  if (IsAmbiguous(references, query, poses_[slot], match)) return std::nullopt;
  return Verified(keyscan, chain, match, wide);
}

bool LoopCloser::IsAmbiguous(std::span<const PlacedScan> references,
                             const ScanOutline& query,
                             const geometry::Rigid2& map_from_expected,
                             const ScanMatch& match) const {
  const double moved_m = geometry::Norm(match.target_from_scan.translation -
                                        map_from_expected.translation);
  if (moved_m < options_.wide_m) return false;
  const MatchSearch near = {.half_extent_m = 0.5 * options_.wide_m,
                            .half_angle_rad = options_.min_search_rad};
  const ScanOutline thinned = Thinned(query, kCoarseEvery);
  const SurfaceGrid grid =
      MakeSurfaceGrid(references, thinned, map_from_expected, near, matcher_);
  const ScanMatch there =
      MatchScan(grid, thinned, map_from_expected, near, matcher_);
  return there.response > match.response - options_.min_distinction;
}

bool LoopCloser::Add(const NewKeyscan& added) {
  const int keyscan = static_cast<int>(scans_.size());
  scans_.push_back(added.scan);
  seen_.emplace_back(*added.scan);
  slopes_.push_back(added.slope);
  constraints_of_.emplace_back();
  if (keyscan == 0) {
    poses_.emplace_back();
    heights_m_.push_back(0);
    way_m_.push_back(0);
    return false;
  }
  const double length_m = geometry::Norm(added.previous_from_this.translation);
  climbs_ = climbs_ || added.climb_m != 0 || added.slope != geometry::Vec2{};
  const int previous = added.tied_to.value_or(keyscan - 1);
  const auto slot = static_cast<size_t>(previous);
  poses_.push_back(poses_[slot] * added.previous_from_this);
  heights_m_.push_back(heights_m_[slot] + added.climb_m);
  // Nobody knows the way of a robot that was carried: all that was before may
  // be met again.
  way_m_.push_back(way_m_.back() +
                   (added.tied_to.has_value() ? MinLoop_m() : length_m));
  Tie({.from = previous,
       .to = keyscan,
       .from_from_to = added.previous_from_this,
       .covariance = added.covariance,
       .climb_m = added.climb_m,
       .climb_sigma_m = kMinClimb_m + kClimb_m_per_m * length_m +
                        kClimb_m_per_climb_m * std::abs(added.climb_m)});
  priors_.push_back(PriorOf(added.odometry, constraints_.back()));
  if (!options_.enabled || keyscan <= options_.recent) return false;
  const std::vector<Reach> reach = ReachFrom(keyscan);
  const std::vector<Chain> chains =
      ChainsNear(keyscan, poses_.back().translation, reach, options_.recent,
                 options_.max_chains);
  std::vector<std::optional<LoopLink>> links(chains.size());
  base::ParallelFor(static_cast<int64_t>(chains.size()), options_.threads,
                    [&](int64_t i) {
                      const Chain& chain = chains[static_cast<size_t>(i)];
                      const MatchSearch search =
                          SearchFor(reach[static_cast<size_t>(chain.nearest)]);
                      // What is known well already can wait until all is tied
                      // once more.
                      if (search.half_extent_m <= options_.wide_m &&
                          keyscan % kNarrowEvery != 0) {
                        return;
                      }
                      links[static_cast<size_t>(i)] =
                          TryChain(keyscan, chain, poses_.back(), search);
                    });
  statistics_.tried += static_cast<int64_t>(chains.size());
  FollowSuspects(keyscan);
  const bool bends = BelieveSuspect(false);
  bool moves = false;
  for (const std::optional<LoopLink>& link : links) {
    if (!link.has_value()) continue;
    if (suspects_.IsSuspect(*link, poses_)) {
      statistics_.suspected += suspects_.Add(*link, poses_) ? 1 : 0;
      continue;
    }
    moves = moves || SquaredError(link->constraint, poses_) > kMovesGraph;
    Believe(*link);
  }
  if (waiting_ == 0 || (!moves && waiting_ < kMaxWaiting)) return bends;
  Optimize();
  return true;
}

std::vector<KeyscanPlace> LoopCloser::Places() const {
  std::vector<KeyscanPlace> places;
  places.reserve(poses_.size());
  for (size_t i = 0; i < poses_.size(); ++i) {
    places.push_back({.map_from_base = poses_[i], .height_m = heights_m_[i]});
  }
  return places;
}

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
  return ContradictionsBetween(*scans_[slot_a], seen_[slot_a], *scans_[slot_b],
                               seen_[slot_b], a_from_b);
}

Contradictions LoopCloser::ContradictionsAmong() const {
  Contradictions found;
  for (const ScanPair& pair : PairsOfOtherPasses(
           Way(), options_.overlap_m, MinLoop_m(), kComparedEvery, kCompared)) {
    found += Between(pair.a, pair.b,
                     poses_[static_cast<size_t>(pair.a)].Inverse() *
                         poses_[static_cast<size_t>(pair.b)]);
  }
  return found;
}

void LoopCloser::FollowSuspects(int keyscan) {
  suspects_.Follow(
      keyscan, poses_,
      [this, keyscan](const geometry::Rigid2& place) -> FollowedKeyscan {
        const std::vector<Chain> chains =
            ChainsNear(keyscan, place.translation, {}, options_.recent, 1);
        if (chains.empty()) return {};
        const Chain& chain = chains.front();
        FollowedKeyscan seen = {
            .found = TryChain(keyscan, chain, place, NearSearch())};
        // Where it fits as well elsewhere, or little is seen, it says nothing.
        seen.is_contradicted =
            !seen.found.has_value() &&
            options_.suspects.IsContradicted(
                ContradictionsOf(keyscan, place, chain),
                ContradictionsOf(keyscan, poses_[static_cast<size_t>(keyscan)],
                                 chain));
        return seen;
      });
}

bool LoopCloser::BelieveSuspect(bool is_last_chance) {
  const std::vector<LoopLink> links =
      suspects_.TakeConfirmed(way_m_, is_last_chance);
  const bool bends = !links.empty() && TryBending(links);
  statistics_.given_up += suspects_.GiveUp(way_m_);
  return bends;
}

bool LoopCloser::TryBending(const std::vector<LoopLink>& links) {
  const std::vector<geometry::Rigid2> poses = poses_;
  const std::vector<double> heights_m = heights_m_;
  const std::vector<PoseConstraint> constraints = constraints_;
  const LoopCloserStatistics statistics = statistics_;
  const int waiting = waiting_;
  const Contradictions before = ContradictionsAmong();
  for (const LoopLink& link : links) Believe(link);
  Optimize();
  if (!options_.suspects.IsContradicted(ContradictionsAmong(), before)) {
    return true;
  }
  statistics_ = statistics;
  ++statistics_.undone;
  waiting_ = waiting;
  poses_ = poses;
  heights_m_ = heights_m;
  constraints_ = constraints;
  IndexConstraints();
  return false;
}

void LoopCloser::Optimize() {
  waiting_ = 0;
  ++statistics_.optimizations;
  std::vector<geometry::Rigid2> poses = poses_;
  // What fails here leaves the poses as they were, which are of use.
  if (!OptimizePoseGraph(constraints_, graph_, &poses).ok()) return;
  poses_ = std::move(poses);
  // On level ground all of them are 0 and stay so.
  if (climbs_) {
    OptimizeHeights(constraints_, graph_, &heights_m_).IgnoreError();
  }
  const size_t before = constraints_.size();
  std::erase_if(constraints_, [this](const PoseConstraint& c) {
    return c.may_be_wrong &&
           SquaredError(c, poses_) > options_.max_squared_error;
  });
  if (constraints_.size() == before) return;
  statistics_.dropped += static_cast<int64_t>(before - constraints_.size());
  IndexConstraints();
}

void LoopCloser::Believe(const LoopLink& link) {
  ++statistics_.accepted;
  statistics_.wide_accepted += link.wide ? 1 : 0;
  Tie(link.constraint);
  ++waiting_;
}

void LoopCloser::Tie(const PoseConstraint& constraint) {
  const int index = static_cast<int>(constraints_.size());
  constraints_.push_back(constraint);
  constraints_of_[static_cast<size_t>(constraint.from)].push_back(index);
  constraints_of_[static_cast<size_t>(constraint.to)].push_back(index);
}

void LoopCloser::IndexConstraints() {
  for (std::vector<int>& of : constraints_of_) of.clear();
  for (size_t i = 0; i < constraints_.size(); ++i) {
    const PoseConstraint& c = constraints_[i];
    constraints_of_[static_cast<size_t>(c.from)].push_back(static_cast<int>(i));
    constraints_of_[static_cast<size_t>(c.to)].push_back(static_cast<int>(i));
  }
}

void LoopCloser::Polish(int rounds) {
  if (!options_.enabled) return;
  if (waiting_ > 0) Optimize();
  BelieveSuspect(true);
  for (int round = 0; round < rounds; ++round) Relink();
  LayUponEachOther();
}

ScanWay LoopCloser::Way() const {
  return {
      .map_from_scans = poses_,
      .way_m = way_m_,
      .may_be_compared = [this](int a, int b) { return SeesTheSame(a, b); },
      .untold_between = [this](int a, int b) { return UntoldBetween(a, b); }};
}

void LoopCloser::LayUponEachOther() {
  std::vector<ScanSurfels> surfels;
  for (const std::shared_ptr<const ScanOutline>& scan : scans_) {
    surfels.emplace_back(SurfelsOf(*scan, options_.bundle.surfels));
  }
  AdjustBundle(surfels, PairsThatOverlap(Way(), options_.bundle.overlap_m),
               priors_, options_.bundle, &poses_);
}

void LoopCloser::Relink() {
  std::vector<std::vector<LoopLink>> links(scans_.size());
  base::ParallelFor(
      static_cast<int64_t>(scans_.size()), options_.threads, [&](int64_t i) {
        const int keyscan = static_cast<int>(i);
        const geometry::Rigid2& here = poses_[static_cast<size_t>(i)];
        const std::vector<Chain> chains =
            ChainsNear(keyscan, here.translation, {}, options_.polish_recent,
                       options_.polish_chains);
        for (const Chain& chain : chains) {
          const std::optional<LoopLink> link =
              TryChain(keyscan, chain, here, NearSearch());
          if (link.has_value()) links[static_cast<size_t>(i)].push_back(*link);
        }
      });
  std::erase_if(constraints_,
                [](const PoseConstraint& c) { return c.may_be_wrong; });
  for (const std::vector<LoopLink>& of_keyscan : links) {
    for (const LoopLink& link : of_keyscan) {
      constraints_.push_back(link.constraint);
    }
  }
  IndexConstraints();
  Optimize();
}

}  // namespace treeline::mapping
