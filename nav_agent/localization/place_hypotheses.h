// Whether only one place of a map explains what was seen: the places that do,
// followed and compared over scans from different viewpoints.
#ifndef NAV_AGENT_LOCALIZATION_PLACE_HYPOTHESES_H_
#define NAV_AGENT_LOCALIZATION_PLACE_HYPOTHESES_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/global_pose_search.h"
#include "nav_agent/localization/laser_level_map.h"
#include "nav_agent/localization/likelihood_field.h"
#include "nav_agent/localization/odometry_motion.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

struct PlaceHypothesesOptions {
  // Scans count from viewpoints this far, or turned so, from the one before:
  // those between tell the same.
  double viewpoint_m = kViewpoint_m;
  double viewpoint_rad = kViewpoint_rad;
  // So many are remembered, the newest.
  size_t viewpoints = kViewpoints;
  // The mean log likelihoods of a scan's beams at two places may differ by so
  // much while neither place explains the scan better: maps are not exact.
  double tolerance = kPlaceTolerance;
  // The most that one viewpoint says (log of the odds), and what must come
  // together, over all, for a place to be excluded.
  double max_evidence = kViewpointEvidence;
  double exclude = kExcludePlace;
  // A search hands over what fits worse than its best by at most this (mean log
  // likelihood of a beam): its grid is coarse.
  double search_within = kSearchWithin;
  // So many searches over the whole map, each with a scan of its own, must have
  // ended before a robot may be sure.
  int searches = kSureSearches;
  // Places that are followed at once; if more fit, nobody is sure.
  size_t candidates = kPlaceCandidates;
  // Poses that are tried in one Step.
  size_t slice = kSearchSlice;
};

// What poses are judged by; the same in every step. levels: null on a flat map.
struct PlaceMap {
  const LikelihoodField* field = nullptr;
  // Where a search tries (OnePlaceOfEachSquare).
  std::shared_ptr<const std::vector<FreePlace>> places;
  const LaserLevelMap* levels = nullptr;
};

// Where a flat map has free ground, or some within a square of the search's
// grid.
class GroundSquares {
 public:
  GroundSquares() = default;
  explicit GroundSquares(const std::vector<FreePlace>& places);
  bool Has(geometry::Vec2 point) const;
  bool is_empty() const { return is_free_.empty(); }

 private:
  int64_t left_ = 0;
  int64_t bottom_ = 0;
  int64_t width_ = 0;
  int64_t height_ = 0;
  std::vector<bool> is_free_;
};

// A place other than the believed one that explains what was seen.
struct PossiblePlace {
  core::LevelPose pose;
  // Of all places that do, the believed one among them, in (0, 1).
  double share = 0;
};

// While a robot is in doubt. The whole map is searched with a scan, a slice a
// step; every place that fits about as well as the believed one is followed
// along the odometry, back over the viewpoints that are remembered and on with
// each new one, at each of them within the odometry's error where the scan fits
// best. A place is excluded when the believed one explains clearly more of the
// scans from several viewpoints. The doubt ends when all others are, and the
// search has been made often enough.
//
// Memory: candidates times viewpoints numbers, however large the map. On equal
// calls the same; not thread-safe.
class PlaceHypotheses {
 public:
  // odometry: what moves between two viewpoints may be off.
  explicit PlaceHypotheses(const PlaceHypothesesOptions& options = {},
                           const OdometryNoise& odometry = {});

  // Nothing is known: all is forgotten, and doubt begins.
  void BeginDoubt();
  // Somebody knows better.
  void EndDoubt();
  bool in_doubt() const { return in_doubt_; }

  // A scan, without what is ground, and where the wheels were; it becomes a
  // viewpoint if it is far enough from the last.
  void AddScan(const geometry::Rigid2& odom_from_base,
               const ScanPoints& points);

  // Goes on by one slice. believed: where the robot is thought to be at
  // odom_from_base; nullopt: nobody knows, so that place is believed which
  // explains most. The doubt does not end then.
  void Step(const PlaceMap& map, const geometry::Rigid2& odom_from_base,
            const std::optional<core::LevelPose>& believed);

  // The share of the believed place among all that explain what was seen; at
  // most one half while another one explains as much. 1 without doubt; 0 in
  // doubt until it has been compared.
  double share() const { return share_; }
  // The others, the likeliest first, at odom_from_base.
  std::vector<PossiblePlace> Others(const geometry::Rigid2& odom_from_base,
                                    size_t at_most) const;
  // Places that are followed, the believed one among them: at most twice as
  // many as candidates, and one.
  size_t size() const { return hypotheses_.size(); }
  // The place that explains most, at odom_from_base; nullopt until a search of
  // the whole map has ended and what it found is compared over enough
  // viewpoints for a search.
  std::optional<core::LevelPose> Best(
      const geometry::Rigid2& odom_from_base) const;
  // A place that explains clearly more than the believed one, at
  // odom_from_base: that one is wrong.
  std::optional<core::LevelPose> Better(
      const geometry::Rigid2& odom_from_base) const;

 private:
  struct Viewpoint {
    geometry::Rigid2 odom_from_base;
    ScanPoints points;
  };
  // Where a scan fits best about a pose. score: the mean log likelihood of a
  // beam, less what the odometry had to be bent.
  struct Fit {
    core::LevelPose pose;
    float score = 0;
  };
  // A place, followed over the viewpoints from `first` on.
  struct Hypothesis {
    int64_t first = 0;
    std::deque<Fit> fits;

    int64_t last() const {
      return first + static_cast<int64_t>(fits.size()) - 1;
    }
    const Fit& At(int64_t viewpoint) const {
      return fits[static_cast<size_t>(viewpoint - first)];
    }
    bool Has(int64_t viewpoint) const {
      return viewpoint >= first && viewpoint <= last();
    }
  };

  int64_t newest() const {
    return oldest_ + static_cast<int64_t>(viewpoints_.size()) - 1;
  }
  const Viewpoint& At(int64_t viewpoint) const {
    return viewpoints_[static_cast<size_t>(viewpoint - oldest_)];
  }
  // ---- following ----
  // Within about so much (standard deviations) of a pose.
  Fit Fitted(const PlaceMap& map, const Viewpoint& viewpoint,
             const core::LevelPose& about, double std_m, double std_rad);
  Fit Followed(const PlaceMap& map, int64_t from, const core::LevelPose& pose,
               int64_t to);
  // Follows it one viewpoint on, or else back.
  void Extend(const PlaceMap& map, Hypothesis& hypothesis);
  bool IsComplete(const Hypothesis& hypothesis) const {
    return hypothesis.first <= oldest_ && hypothesis.last() >= newest();
  }
  bool IsOnGround(const PlaceMap& map, core::LevelPose& pose) const;
  core::LevelPose PoseOf(const Hypothesis& hypothesis,
                         const geometry::Rigid2& odom_from_base) const;
  // Log of the odds of the one against the other.
  double Evidence(const Hypothesis& one, const Hypothesis& other) const;
  // ---- parts of a step ----
  void FindBelieved(const PlaceMap& map, const geometry::Rigid2& odom_from_base,
                    const core::LevelPose& believed);
  // Without one: the place that explains most.
  void BelieveBest();
  void ExtendAll(const PlaceMap& map);
  void Exclude();
  void MergeTwins();
  void Remove(const std::vector<bool>& is_gone);
  void StepSearch(const PlaceMap& map);
  // Of the newest viewpoints, in the frame of the last.
  ScanPoints NewestPoints() const;
  void TakeCandidates(const PlaceMap& map);
  // All that is followed has been compared over all viewpoints.
  bool IsCompared() const;
  void Judge(bool may_end);

  PlaceHypothesesOptions options_;
  OdometryNoise odometry_;
  bool in_doubt_ = false;
  std::deque<Viewpoint> viewpoints_;
  // The number of the first of them.
  int64_t oldest_ = 0;
  std::vector<Hypothesis> hypotheses_;
  // Evidence of the believed place against each.
  std::vector<double> against_;
  // Of hypotheses_; meaningless while there are none.
  size_t believed_ = 0;
  bool has_new_viewpoint_ = false;
  double share_ = 1;
  std::optional<GlobalPoseSearch> search_;
  // The viewpoint of the search that goes on or went last.
  int64_t searched_ = -1;
  // What a search has found and is not followed yet; the worst first.
  std::vector<core::LevelPose> candidates_;
  bool is_search_whole_ = false;
  // Searches that have ended and left out nothing, for the believed place.
  int searches_done_ = 0;
  // Poses left in this step.
  int64_t budget_ = 0;
  GroundSquares ground_;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_PLACE_HYPOTHESES_H_
