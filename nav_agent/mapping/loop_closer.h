// The back end of laser SLAM: finds loops, and keeps the pose graph.
#ifndef NAV_AGENT_MAPPING_LOOP_CLOSER_H_
#define NAV_AGENT_MAPPING_LOOP_CLOSER_H_

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/loop_closer_options.h"
#include "nav_agent/mapping/loop_suspects.h"
#include "nav_agent/mapping/odometry_doubt.h"
#include "nav_agent/mapping/pose_graph.h"
#include "nav_agent/mapping/scan_agreement.h"
#include "nav_agent/mapping/scan_bundle.h"
#include "nav_agent/mapping/scan_matcher.h"
#include "nav_agent/mapping/scan_neighbours.h"
#include "nav_agent/mapping/scan_outline.h"
#include "nav_agent/mapping/scan_plane.h"

namespace treeline::mapping {

// What odometry alone says of previous_from_this, and one standard deviation of
// its errors.
struct OdometryStep {
  geometry::Rigid2 previous_from_this;
  OdometryDoubt::Sigma sigma;
};

// What the front end hands over for one keyscan.
struct NewKeyscan {
  std::shared_ptr<const ScanOutline> scan;
  // The keyscan that it is tied to instead of the one before: the robot was
  // carried from there to here.
  std::optional<int> tied_to = {};
  // Where it is relative to the one before (ignored for the first), or to that
  // one, and how much higher (m).
  geometry::Rigid2 previous_from_this;
  Covariance3 covariance{};
  // nullopt: nobody knows better than that.
  std::optional<OdometryStep> odometry = {};
  double climb_m = 0;
  // How steeply the ground climbs there along the base's x and y, seen from
  // above (m per m).
  geometry::Vec2 slope;
};

struct KeyscanPlace {
  geometry::Rigid2 map_from_base;
  double height_m = 0;
};

struct LoopCloserStatistics {
  int64_t tried = 0;
  int64_t accepted = 0;
  int64_t wide_accepted = 0;
  int64_t dropped = 0;
  // Loops that were followed, and those of them that were given up.
  int64_t suspected = 0;
  int64_t given_up = 0;
  // Times that such loops, tried, laid other scans upon what was seen through.
  int64_t undone = 0;
  int64_t optimizations = 0;
};

// Not thread-safe: one thread adds and asks.
class LoopCloser {
 public:
  LoopCloser(const LoopCloserOptions& options,
             const ScanMatcherOptions& matcher, const PoseGraphOptions& graph)
      : options_(options),
        matcher_(matcher),
        graph_(graph),
        suspects_(options.suspects) {}

  // Returns whether places have changed.
  bool Add(const NewKeyscan& keyscan);

  // Ties every keyscan to its neighbours once more, now that all is known, and
  // optimises: where loops were closed late, earlier passes were not compared
  // with each other. `rounds` times; then all are laid upon each other.
  void Polish(int rounds);

  std::vector<KeyscanPlace> Places() const;
  const LoopCloserStatistics& statistics() const { return statistics_; }
  std::span<const PoseConstraint> constraints() const { return constraints_; }

 private:
  // How well a keyscan is known relative to the one asked about, along the way
  // through the graph on which it is known best.
  struct Reach {
    double variance_m2 = std::numeric_limits<double>::infinity();
    double variance_rad2 = 0;
    double way_m = 0;
  };
  struct Chain {
    int begin = 0;
    int end = 0;  // one past the last
    int nearest = 0;
    double distance_m = 0;
  };
  std::vector<Reach> ReachFrom(int keyscan) const;
  // reach empty: places are taken as they are.
  std::vector<Chain> ChainsNear(int keyscan, geometry::Vec2 here,
                                const std::vector<Reach>& reach, int recent,
                                int max_chains) const;
  MatchSearch SearchFor(const Reach& reach) const;
  MatchSearch NearSearch() const;
  // A loop is at least this long.
  double MinLoop_m() const { return 3 * options_.overlap_m; }
  // The keyscan among those of a chain, near to where it is expected.
  std::optional<LoopLink> TryChain(int keyscan, const Chain& chain,
                                   const geometry::Rigid2& map_from_expected,
                                   MatchSearch search) const;
  std::optional<LoopLink> Verified(int keyscan, const Chain& chain,
                                   const ScanMatch& match, bool wide) const;
  // Whether the place where the graph has the robot fits about as well as one
  // that was found far from it.
  bool IsAmbiguous(std::span<const PlacedScan> references,
                   const ScanOutline& query,
                   const geometry::Rigid2& map_from_expected,
                   const ScanMatch& match) const;
  ScanOutline QueryScan(int keyscan, int count) const;
  std::vector<PlacedScan> Placed(const Chain& chain) const;
  // Between the keyscan at a place and those of a chain, both ways.
  Contradictions ContradictionsOf(int keyscan,
                                  const geometry::Rigid2& map_from_keyscan,
                                  const Chain& chain) const;
  ScanPlane PlaneOf(int keyscan) const;
  bool SeesTheSame(int a, int b) const;
  std::optional<geometry::Vec2> UntoldBetween(int a, int b) const;
  // How much higher `to` is than `from`, by the ground that both stand on.
  void SetClimb(const geometry::Rigid2& map_from_to,
                PoseConstraint* constraint) const;
  Contradictions Between(int a, int b, const geometry::Rigid2& a_from_b) const;
  // Between keyscans of different passes that are near to each other.
  Contradictions ContradictionsAmong() const;
  // Looks for a new keyscan where suspected loops put it.
  void FollowSuspects(int keyscan);
  // Takes the suspect that was found most often, if it is confirmed, and gives
  // up others. Whether places have changed.
  bool BelieveSuspect(bool is_last_chance);
  // Optimises with these loops, unless other scans then stand in each other's
  // way; whether it was done.
  bool TryBending(const std::vector<LoopLink>& links);
  void Believe(const LoopLink& link);
  void Optimize();
  void Tie(const PoseConstraint& constraint);
  void IndexConstraints();
  void Relink();
  // If it fails, the graph's poses stay, which are of use.
  void LayUponEachOther();
  ScanWay Way() const;

  const LoopCloserOptions options_;
  const ScanMatcherOptions matcher_;
  const PoseGraphOptions graph_;
  std::vector<std::shared_ptr<const ScanOutline>> scans_;
  std::vector<SeenSpace> seen_;
  std::vector<geometry::Rigid2> poses_;
  std::vector<double> heights_m_;
  std::vector<geometry::Vec2> slopes_;  // of the ground, in the base's axes
  std::vector<double> way_m_;           // travelled until keyscan i
  bool climbs_ = false;                 // whether anything is not level
  std::vector<PoseConstraint> constraints_;
  std::vector<std::vector<int>> constraints_of_;  // a keyscan
  // What is known of each keyscan but by matching it.
  std::vector<PoseConstraint> priors_;
  LoopSuspects suspects_;
  int waiting_ = 0;  // links that were not optimised yet
  LoopCloserStatistics statistics_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LOOP_CLOSER_H_
