// Where in the map a stretch of the way is that hangs on nothing: a robot was
// carried off while it mapped, and has driven on since then.
#ifndef NAV_AGENT_MAPPING_SEGMENT_FINDER_H_
#define NAV_AGENT_MAPPING_SEGMENT_FINDER_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "nav_agent/mapping/keyscan.h"
#include "nav_agent/mapping/scan_matcher.h"

namespace treeline::mapping {

struct SegmentFinderOptions {
  // Keyscans of the map within this of a place see the same things (m).
  double overlap_m = 4.0;
  double max_gap_m = 0.3;
  // The search about a place that somebody has suggested, and about one where
  // scans were found already.
  double first_search_m = 0.5;
  double first_search_rad = 0.2;
  double search_m = 0.2;
  double search_rad = 0.08;
  // A keyscan is found there if it responds so well and is contradicted by so
  // little; it speaks against the place if it is contradicted by more, or
  // hardly responds.
  double min_response = 0.6;
  double max_contradicted = 0.15;
  double against_contradicted = 0.25;
  double against_response = 0.4;
  int min_told = 100;
  // A place that was seen, or where the robot thought it was, is believed once
  // so many keyscans were found over so much of the way (m), and at most one
  // for four speaks against it ...
  int min_found = 4;
  double min_way_m = 1.0;
  // ... one that scans alone suggest, after so many over so much more, where
  // they respond so well on average; three in four must be found and at most
  // one in eight speak against it; and if the whole map was searched.
  int min_found_alone = 10;
  double min_way_alone_m = 3.5;
  double min_response_alone = 0.85;
  // And this share of all of the segment's keyscans: the longer it is, the more
  // places have been tried, and the more of them fit for a while.
  double min_found_share_alone = 0.25;
  // No other place may be found about as well: by this share of what its
  // keyscans respond, together; by more, if nobody but scans says so, and of
  // this place somebody does.
  double rival_share = 0.85;
  double unseen_rival_share = 1.05;
  // The whole map is searched when the segment is so long, and again after so
  // much more of it (m).
  double whole_map_after_m = 1.5;
  double whole_map_every_m = 2.0;
  double min_coarse_response = 0.5;
  int query_scans = 8;
  size_t max_places = 8;

  bool IsValid() const;
};

// Who says first where a segment hangs on the map; scans have to confirm it.
enum class SegmentWitness : uint8_t {
  kScans,   // they fit there, among all places of the map
  kBelief,  // the robot thought so: it may all have been people before it
  kServer   // it has seen it there
};

// How a segment hangs on the map.
struct SegmentLink {
  geometry::Rigid2 map_from_segment;
  double rise_m = 0;  // of heights in the map over those in the segment
  // Of the map's keyscan that is the nearest, and of the segment's that was
  // found last: indices in what Step was given.
  size_t map_keyscan = 0;
  size_t segment_keyscan = 0;
  Covariance3 covariance{};  // of that keyscan's place, in the map's axes
  SegmentWitness who = SegmentWitness::kScans;
};

// Deterministic; not thread-safe.
class SegmentFinder {
 public:
  SegmentFinder(const SegmentFinderOptions& options,
                const ScanMatcherOptions& matcher)
      : options_(options), matcher_(matcher) {}

  // A new segment: nothing is known of it.
  void Begin();
  // It may hang so, as `who` says.
  void Suggest(const geometry::Rigid2& map_from_segment, double rise_m,
               SegmentWitness who);
  // Compares what has come since the last step, and searches a part of the
  // map. The segment only grows; the map may be moved a little.
  std::optional<SegmentLink> Step(std::span<const Keyscan> map,
                                  std::span<const Keyscan> segment);

  // Places that are followed.
  size_t places() const { return places_.size(); }

 private:
  struct Place {
    geometry::Rigid2 map_from_segment;
    double rise_m = 0;
    SegmentWitness who = SegmentWitness::kScans;
    size_t compared = 0;  // keyscans of the segment
    int told = 0;         // of them, those that the map knows something about
    int found = 0;
    int against = 0;
    double responses = 0;
    double first_found_m = 0;  // along the segment
    double last_found_m = 0;
    SegmentLink link;
  };
  struct Candidate {
    geometry::Rigid2 map_from_segment;
    double rise_m = 0;
    double response = 0;
  };

  void Measure(std::span<const Keyscan> segment);
  // The map's keyscans near to a place, the nearest first; a turn against it
  // counts as so much of the distance (m per rad), since lasers do not see what
  // is behind them.
  std::vector<size_t> Near(std::span<const Keyscan> map,
                           const Keyscan& at_place, double turn_as_m,
                           size_t at_most) const;
  void Compare(std::span<const Keyscan> map, std::span<const Keyscan> segment,
               Place& place) const;
  bool IsBelieved(const Place& place) const;
  bool HasRival(const Place& place) const;
  // Whether both put the segment's newest keyscan in the same place.
  bool AreSame(const geometry::Rigid2& a, const geometry::Rigid2& b) const;
  // ---- the whole map, a tile at a time ----
  void BeginSearch(std::span<const Keyscan> map,
                   std::span<const Keyscan> segment);
  void SearchTile(std::span<const Keyscan> map);
  void EndSearch();

  SegmentFinderOptions options_;
  ScanMatcherOptions matcher_;
  std::vector<Place> places_;
  geometry::Rigid2 segment_from_newest_;
  std::vector<double> way_m_;  // along the segment, of its keyscans
  // The search that goes on: its query in the segment's frame, about the place
  // of its newest keyscan.
  ScanOutline query_;
  geometry::Rigid2 segment_from_query_;
  double query_height_m_ = 0;
  std::vector<size_t> tiles_;  // keyscans of the map, the last is next
  std::vector<Candidate> candidates_;
  double next_search_m_ = 0;
  int searches_done_ = 0;
  bool is_searching_ = false;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SEGMENT_FINDER_H_
