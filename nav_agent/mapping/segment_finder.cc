#include "nav_agent/mapping/segment_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav_agent/mapping/surface_grid.h"

namespace treeline::mapping {
namespace {

// Two suggestions this near to each other are one.
constexpr double kSamePlace_m = 0.4;
constexpr double kSamePlace_rad = 0.15;
// Of the map's keyscans near a place, so many are matched against, and so many
// asked what they looked through; fewer than the last say nothing.
constexpr size_t kReferences = 14;
constexpr size_t kAsked = 4;
constexpr size_t kMinReferences = 3;
constexpr double kTurnAside_m = 1.0;
constexpr size_t kTileReferences = 30;
// The share of surfaces that must be seen from the same side.
constexpr double kSameSide = 0.8;
// A turn counts as so much of the way (m per rad).
constexpr double kTurnAsWay_m = 0.3;
// The whole map: tiles about keyscans that are so far apart (m), on cells this
// many times as large, with every so many points of the query.
constexpr double kTile_m = 2.5;
constexpr double kCoarse = 3;
constexpr size_t kCoarseEvery = 6;
// A place that is given up.
constexpr int kGiveUpAfter = 4;
// What is not handed over beside the best of a search, by its response.
constexpr double kWorseThanBest = 0.15;

Keyscan At(const geometry::Rigid2& map_from_segment, double rise_m,
           const Keyscan& of_segment) {
  Keyscan moved = of_segment;
  moved.map_from_base = map_from_segment * of_segment.map_from_base;
  moved.height_m += rise_m;
  return moved;
}

std::vector<PlacedScan> Placed(std::span<const Keyscan> map,
                               const std::vector<size_t>& near) {
  std::vector<PlacedScan> placed;
  for (const size_t i : near) {
    placed.push_back(
        {.scan = map[i].scan.get(), .target_from_scan = map[i].map_from_base});
  }
  return placed;
}

// The first of those that are named.
std::vector<Keyscan> Asked(std::span<const Keyscan> map,
                           const std::vector<size_t>& near) {
  std::vector<Keyscan> asked;
  for (const size_t i : std::span(near).first(std::min(kAsked, near.size()))) {
    asked.push_back(map[i]);
  }
  return asked;
}

}  // namespace

bool SegmentFinderOptions::IsValid() const {
  return overlap_m > 0 && max_gap_m > 0 && first_search_m > 0 &&
         first_search_m <= 5 && search_m > 0 && search_m <= 5 &&
         min_response > 0 && min_found > 0 && min_found_alone >= min_found &&
         query_scans > 0 && max_places > 0 && whole_map_every_m > 0;
}

bool SegmentFinder::AreSame(const geometry::Rigid2& a,
                            const geometry::Rigid2& b) const {
  const geometry::Rigid2 apart =
      (a * segment_from_newest_).Inverse() * (b * segment_from_newest_);
  return geometry::Norm(apart.translation) < kSamePlace_m &&
         std::abs(geometry::NormalizedAngle_rad(apart.yaw_rad)) <
             kSamePlace_rad;
}

void SegmentFinder::Begin() {
  places_.clear();
  way_m_.clear();
  tiles_.clear();
  candidates_.clear();
  next_search_m_ = options_.whole_map_after_m;
  searches_done_ = 0;
  is_searching_ = false;
}

void SegmentFinder::Suggest(const geometry::Rigid2& map_from_segment,
                            double rise_m, SegmentWitness who) {
  for (Place& place : places_) {
    if (!AreSame(place.map_from_segment, map_from_segment)) continue;
    // Two that err apart say the same.
    place.who = std::max(place.who, who);
    return;
  }
  if (places_.size() >= options_.max_places) {
    // The one that the least speaks for gives way.
    const auto least = std::min_element(
        places_.begin(), places_.end(), [](const Place& a, const Place& b) {
          return a.found - a.against < b.found - b.against;
        });
    places_.erase(least);
  }
  Place place;
  place.map_from_segment = map_from_segment;
  place.rise_m = rise_m;
  place.who = who;
  places_.push_back(place);
}

void SegmentFinder::Measure(std::span<const Keyscan> segment) {
  for (size_t i = way_m_.size(); i < segment.size(); ++i) {
    if (i == 0) {
      way_m_.push_back(0);
      continue;
    }
    const geometry::Rigid2 motion =
        segment[i - 1].map_from_base.Inverse() * segment[i].map_from_base;
    way_m_.push_back(way_m_.back() + geometry::Norm(motion.translation) +
                     kTurnAsWay_m * std::abs(motion.yaw_rad));
  }
}

std::vector<size_t> SegmentFinder::Near(std::span<const Keyscan> map,
                                        const Keyscan& at_place,
                                        double turn_as_m,
                                        size_t at_most) const {
  std::vector<std::pair<double, size_t>> near;
  const ScanPlane plane = at_place.Plane();
  for (size_t i = 0; i < map.size(); ++i) {
    const double distance_m =
        geometry::Norm(map[i].map_from_base.translation - plane.at);
    if (distance_m > options_.overlap_m ||
        Gap_m(plane, map[i].Plane()) > options_.max_gap_m) {
      continue;
    }
    const double turn_rad = std::abs(geometry::NormalizedAngle_rad(
        map[i].map_from_base.yaw_rad - at_place.map_from_base.yaw_rad));
    near.emplace_back(distance_m + turn_as_m * turn_rad, i);
  }
  const size_t count = std::min(near.size(), at_most);
  std::partial_sort(near.begin(), near.begin() + static_cast<ptrdiff_t>(count),
                    near.end());
  std::vector<size_t> nearest;
  for (size_t n = 0; n < count; ++n) nearest.push_back(near[n].second);
  return nearest;
}

void SegmentFinder::Compare(std::span<const Keyscan> map,
                            std::span<const Keyscan> segment,
                            Place& place) const {
  const size_t index = place.compared++;
  const Keyscan at = At(place.map_from_segment, place.rise_m, segment[index]);
  const std::vector<size_t> near = Near(map, at, kTurnAside_m, kReferences);
  if (near.size() < kMinReferences || at.scan->empty()) return;
  const bool is_first = place.found == 0;
  const MatchSearch search = {
      .half_extent_m = is_first ? options_.first_search_m : options_.search_m,
      .half_angle_rad =
          is_first ? options_.first_search_rad : options_.search_rad};
  const SurfaceGrid grid = MakeSurfaceGrid(Placed(map, near), *at.scan,
                                           at.map_from_base, search, matcher_);
  const ScanMatch match =
      MatchScan(grid, *at.scan, at.map_from_base, search, matcher_);
  const Contradictions contradicted =
      ContradictionsWith(Asked(map, near), *at.scan, match.target_from_scan);
  if (contradicted.told < options_.min_told) return;
  ++place.told;
  const double share = contradicted.Share();
  if (match.response < options_.against_response ||
      share > options_.against_contradicted) {
    ++place.against;
    return;
  }
  if (match.response < options_.min_response || match.is_at_border ||
      share > options_.max_contradicted ||
      ShareOfSameSide(grid, *at.scan, match.target_from_scan) < kSameSide) {
    return;
  }
  if (place.found++ == 0) place.first_found_m = way_m_[index];
  place.last_found_m = way_m_[index];
  place.responses += match.response;
  place.map_from_segment =
      match.target_from_scan * segment[index].map_from_base.Inverse();
  // Both stand on the same ground.
  const Keyscan& nearest = map[near.front()];
  place.rise_m = nearest.height_m - segment[index].height_m +
                 ClimbBySlope_m(nearest.Plane(), at.Plane());
  place.link = {.map_from_segment = place.map_from_segment,
                .rise_m = place.rise_m,
                .map_keyscan = near.front(),
                .segment_keyscan = index,
                .covariance = match.covariance};
}

bool SegmentFinder::IsBelieved(const Place& place) const {
  const double way_m = place.last_found_m - place.first_found_m;
  if (place.who != SegmentWitness::kScans) {
    return place.found >= options_.min_found && way_m >= options_.min_way_m &&
           4 * place.against <= place.found;
  }
  return place.found >= options_.min_found_alone &&
         place.found >= options_.min_found_share_alone *
                            static_cast<double>(place.compared) &&
         way_m >= options_.min_way_alone_m && searches_done_ > 0 &&
         4 * (place.told - place.found) <= place.told &&
         8 * place.against <= place.found &&
         place.responses >= options_.min_response_alone * place.found;
}

bool SegmentFinder::HasRival(const Place& place) const {
  return std::any_of(places_.begin(), places_.end(), [&](const Place& other) {
    const double share = other.who < place.who ? options_.unseen_rival_share
                                               : options_.rival_share;
    return &other != &place && 4 * other.against <= other.found &&
           other.responses > share * place.responses &&
           !AreSame(other.map_from_segment, place.map_from_segment);
  });
}

std::optional<SegmentLink> SegmentFinder::Step(
    std::span<const Keyscan> map, std::span<const Keyscan> segment) {
  if (segment.empty()) return std::nullopt;
  Measure(segment);
  segment_from_newest_ = segment.back().map_from_base;
  bool is_new = false;
  for (Place& place : places_) {
    while (place.compared < segment.size()) {
      Compare(map, segment, place);
      is_new = true;
    }
  }
  std::erase_if(places_, [](const Place& place) {
    return place.against >= kGiveUpAfter && place.against > place.found;
  });
  for (const Place& place : places_) {
    if (!is_new || !IsBelieved(place) || HasRival(place)) continue;
    SegmentLink link = place.link;
    link.who = place.who;
    return link;
  }
  if (is_searching_) {
    SearchTile(map);
  } else if (way_m_.back() >= next_search_m_) {
    BeginSearch(map, segment);
  }
  return std::nullopt;
}

void SegmentFinder::BeginSearch(std::span<const Keyscan> map,
                                std::span<const Keyscan> segment) {
  next_search_m_ = way_m_.back() + options_.whole_map_every_m;
  const Keyscan& newest = segment.back();
  segment_from_query_ = newest.map_from_base;
  query_height_m_ = newest.height_m;
  query_ = {};
  const geometry::Rigid2 query_from_segment = segment_from_query_.Inverse();
  const size_t count =
      std::min(segment.size(), static_cast<size_t>(options_.query_scans));
  size_t k = 0;
  for (const Keyscan& keyscan : segment.last(count)) {
    if (Gap_m(newest.Plane(), keyscan.Plane()) > options_.max_gap_m) continue;
    const geometry::Rigid2 query_from_scan =
        query_from_segment * keyscan.map_from_base;
    for (const geometry::Vec2& point : keyscan.scan->points_m) {
      if (k++ % kCoarseEvery != 0) continue;
      query_.points_m.push_back(query_from_scan * point);
      query_.joined.push_back(0);
    }
  }
  tiles_.clear();
  for (size_t i = 0; i < map.size(); ++i) {
    const geometry::Vec3 here = map[i].Place();
    const bool is_far =
        std::all_of(tiles_.begin(), tiles_.end(), [&](size_t tile) {
          return geometry::Norm(map[tile].Place() - here) > kTile_m;
        });
    if (is_far) tiles_.push_back(i);
  }
  candidates_.clear();
  is_searching_ = !query_.empty();
}

void SegmentFinder::SearchTile(std::span<const Keyscan> map) {
  if (tiles_.empty()) return EndSearch();
  const Keyscan& center = map[tiles_.back()];
  tiles_.pop_back();
  const std::vector<size_t> near = Near(map, center, 0, kTileReferences);
  if (near.size() < kMinReferences) return;
  ScanMatcherOptions coarse = matcher_;
  coarse.cell_m *= kCoarse;
  coarse.sigma_m *= kCoarse;
  const MatchSearch search = {.half_extent_m = 0.6 * kTile_m,
                              .half_angle_rad = std::numbers::pi};
  const SurfaceGrid grid = MakeSurfaceGrid(
      Placed(map, near), query_, center.map_from_base, search, coarse);
  const ScanMatch match =
      MatchScan(grid, query_, center.map_from_base, search, coarse);
  if (match.response < options_.min_coarse_response) return;
  candidates_.push_back({.map_from_segment = match.target_from_scan *
                                             segment_from_query_.Inverse(),
                         .rise_m = center.height_m - query_height_m_,
                         .response = match.response});
}

void SegmentFinder::EndSearch() {
  is_searching_ = false;
  ++searches_done_;
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const Candidate& a, const Candidate& b) {
                     return a.response > b.response;
                   });
  size_t suggested = 0;
  for (const Candidate& candidate : candidates_) {
    if (candidate.response < candidates_.front().response - kWorseThanBest ||
        2 * suggested++ >= options_.max_places) {
      break;
    }
    Suggest(candidate.map_from_segment, candidate.rise_m,
            SegmentWitness::kScans);
  }
  candidates_.clear();
}

}  // namespace treeline::mapping
