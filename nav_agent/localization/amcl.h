// Adaptive Monte Carlo localization: where a robot is on a known map, from its
// odometry and its laser (thesis 6.4.2; Fox 2003; Thrun et al. 2005).
#ifndef NAV_AGENT_LOCALIZATION_AMCL_H_
#define NAV_AGENT_LOCALIZATION_AMCL_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/localization/laser_level_map.h"
#include "nav_agent/localization/likelihood_field.h"
#include "nav_agent/localization/odometry_motion.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/place_hypotheses.h"
#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

// Covariance of a pose in the plane, row-major, of x, y (m) and yaw (rad).
using PoseCovariance2 = std::array<double, 9>;

struct AmclOptions {
  // How many particles KLD sampling may choose; global localization begins
  // with max_global_localization_particles and comes down as they gather.
  int min_particles = kMinParticles;
  int max_particles = kMaxParticles;
  int max_global_localization_particles = kMaxGlobalParticles;
  // KLD sampling (Fox 2003): with probability 1 - delta the error is below
  // `kld_error`; kld_z is the upper 1 - delta quantile of the normal
  // distribution. Bins of this size.
  double kld_error = kKldError;
  double kld_z = kKldQuantile;
  double bin_m = kBin_m;
  double bin_rad = kBin_rad;

  // Scans are taken in after the robot has moved this far, or turned so.
  double update_distance_m = kUpdateDistance_m;
  double update_turn_rad = kUpdateTurn_rad;
  int max_beams = kScanBeams;
  // Neighbouring beams tell nearly the same: all of them together count as so
  // many that are independent.
  double independent_beams = kIndependentBeams;
  // A scan may not leave less than this share of the particles with any weight
  // to speak of: it counts for less until it does not (tempering). What is
  // right survives that; what only looks right on one scan does not win by it.
  double min_counting_share = kMinCountingShare;
  // While the robot is looked for everywhere, particles are few for so much
  // room. So scans count for still less, and after each drawing particles are
  // spread again by these standard deviations (a regularised filter: Musso,
  // Oudjane, Le Gland, 2001), lest what is right lie between them. The search
  // ends when one cluster holds found_share of the weight and max_particles
  // are enough.
  double searching_share = kSearchingShare;
  double regularization_m = kRegularization_m;
  double regularization_rad = kRegularization_rad;
  double found_share = kFoundShare;
  // A beam that fewer than this share of the particles explain is left out (a
  // person, a moved chair), unless that would leave fewer than half of them.
  // "Explained": its end is within beam_skip_distance_m of an obstacle.
  double beam_skip_threshold = kBeamSkipThreshold;
  double beam_skip_distance_m = kBeamSkipDistance_m;

  // Augmented MCL (Probabilistic Robotics, table 8.3): short- and long-term
  // averages of the mean likelihood of a beam. When inject_ratio times the
  // short one falls below the long one (Gutmann and Fox, "An experimental
  // comparison of localization methods continued", 2002), the robot is looked
  // for everywhere: max_global_localization_particles are drawn anew from all
  // free ground, with injected_share of the weight, beside those that there
  // are. A trickle of new particles hardly ever hits a pose in a building, but
  // keeps all estimates unsure where a map is a little out of date. inject =
  // false: never.
  bool inject = true;
  double alpha_slow = kAlphaSlow;
  double alpha_fast = kAlphaFast;
  double inject_ratio = kInjectRatio;
  double injected_share = kInjectedShare;
  // On levels: a particle that no ground is below, in a wall or a void, counts
  // as if it missed this share of the beams.
  double off_ground_share = kOffGroundShare;
  // On levels: a beam that ends this near to the ground (m, and as a share of
  // its length, for the error of the tilt) is left out.
  double ground_m = kBeamGround_m;
  double ground_share = kBeamGroundShare;

  // Particles are drawn again when fewer than this share of them counts.
  double resample_below = kResampleBelow;

  // What is found by a search is in doubt until no other place of the map
  // explains what was seen (PlaceHypotheses). false: never in doubt.
  bool doubt = true;
  PlaceHypothesesOptions places;

  LikelihoodFieldOptions field;
  OdometryNoise odometry;

  absl::Status Validate() const;
};

struct PlanarEstimate {
  // Mean and covariance of the heaviest cluster of particles.
  geometry::Rigid2 map_from_base;
  PoseCovariance2 covariance{};
  // The cluster's share of the weight, in (0, 1].
  double share = 0;
  // The mean likelihood of a beam of the last scan, left out or not, over all
  // particles; in (0, 1].
  double fit = 0;
  int particles = 0;
  // Whether the robot is being looked for everywhere.
  bool is_searching = false;
  // It was looked for everywhere, and not all other places that explain what
  // was seen are excluded yet: nobody is to rely on the pose.
  bool in_doubt = false;
  // The share of this place among all that explain what was seen since the
  // doubt began: at most one half while another explains as much; 0 before that
  // is known, 1 without doubt.
  double place_share = 1;
  // The likeliest others, at most kOtherPlacesShown, the likeliest first.
  std::vector<PossiblePlace> other_places = {};
  // Beams of the last scan that were used, and that were left out because few
  // particles explain them.
  int beams_used = 0;
  int beams_skipped = 0;
  // Beams of the last scan that ended on the ground, from where the robot was
  // thought to be: they tell nothing, and were left out first. Only on levels.
  int beams_on_ground = 0;
  // On levels: where it stands. Else both are 0.
  core::LevelPlace place;
};

struct Particle {
  geometry::Rigid2 map_from_base;
  double weight = 0;
  // On levels: what it stands on, or stood on last.
  core::LevelPlace place = {};
};

// Deterministic: the same calls give the same particles for one seed. Not
// thread-safe.
class Amcl {
 public:
  // INVALID_ARGUMENT for bad options and for maps without free cells.
  static absl::StatusOr<Amcl> Create(const core::OccupancyGrid& map,
                                     const AmclOptions& options, uint64_t seed);

  // On all levels of a building at once: each particle has a level, and goes
  // over to the next one where it drives over their join. Scans need heights
  // (PointsInSpace). options.field is not used: the map has its own.
  static absl::StatusOr<Amcl> CreateOnLevels(
      std::shared_ptr<const LaserLevelMap> map, const AmclOptions& options,
      uint64_t seed);

  // The robot is about here. INVALID_ARGUMENT for what is not finite or a
  // covariance that is not positive semidefinite; on levels, the lowest ground
  // there is meant.
  absl::Status SetPose(const geometry::Rigid2& map_from_base,
                       const PoseCovariance2& covariance);
  // The same on the ground nearest to a height. INVALID_ARGUMENT if there is no
  // ground within max_rise_m of it, or there are no levels.
  absl::Status SetPoseOnLevel(const geometry::Rigid2& map_from_base,
                              double height_m,
                              const PoseCovariance2& covariance);
  // The robot may be anywhere on free ground.
  void StartGlobalLocalization();

  // Moves the particles along with the odometry, and, if the robot has moved
  // far enough since the last scan that was taken in, weighs them by this one.
  // The estimate is of this moment either way; nullopt before SetPose or
  // StartGlobalLocalization. INVALID_ARGUMENT for an odometry that is not
  // finite.
  absl::StatusOr<std::optional<PlanarEstimate>> Update(
      const geometry::Rigid2& odom_from_base, const ScanPoints& points);
  // Update in two parts of about the same length, for whom thirty thousand
  // particles at once are too many: moves and weighs; then draws anew and makes
  // the estimate, of the moment of Begin. Until then it is the one before. What
  // was begun and not settled, the next Begin settles.
  absl::Status Begin(const geometry::Rigid2& odom_from_base,
                     const ScanPoints& points);
  std::optional<PlanarEstimate> Settle();
  bool is_settled() const { return is_settled_; }
  // Between scans, while in doubt: goes on looking for places by a slice (about
  // 2 ms), of which a search over a large map needs many. The estimate, of the
  // moment of the last Update or Begin; nullopt without doubt, or when a scan
  // was begun and not settled.
  std::optional<PlanarEstimate> Ponder();

  // Takes in the next scan whether or not the robot has moved.
  void ForceNextScan() { force_next_ = true; }

  const std::vector<Particle>& particles() const { return particles_; }
  // One free place of each square of the search's grid.
  const std::shared_ptr<const std::vector<FreePlace>>& search_places() const {
    return search_places_;
  }

 private:
  Amcl(LikelihoodField field, std::shared_ptr<const LaserLevelMap> levels,
       std::vector<FreePlace> free_places, double resolution_m,
       const AmclOptions& options, uint64_t seed);

  const LikelihoodField& field() const {
    return levels_ == nullptr ? field_ : levels_->field();
  }
  Particle AnyParticle(base::Random& random) const;
  absl::Status PlaceAbout(const geometry::Rigid2& map_from_base,
                          const PoseCovariance2& covariance,
                          const core::LevelPlace& place);
  // Particles about a pose; root: of the covariance (Cholesky), row-major.
  void Gather(const geometry::Rigid2& map_from_base,
              const std::array<double, 9>& root, const core::LevelPlace& place);
  bool IsWhereItWasSure() const;
  // Which ground a particle that has moved is on now.
  void FindGround(Particle& particle) const;
  bool IsOffGround(const Particle& particle) const;
  void Move(const geometry::Rigid2& before_from_after);
  ScanPoints WithoutGround(const ScanPoints& points) const;
  ScanPoints WithoutUnexplained(const ScanPoints& points);
  void UpdateFit(double fit);
  // How much of the sums of logs (of so many beams, the best one 0) counts.
  double GainFor(const std::vector<float>& sums, double beams) const;
  void Weigh(const ScanPoints& points);
  void Resample();
  void SearchEverywhere();
  void Roughen(std::vector<Particle>& particles);
  void UpdateEstimate();
  // The places that explain what was seen: goes on comparing, and goes over to
  // one that is clearly better, or to the best if particles are everywhere.
  void Doubt();
  bool MayDoubt() const;
  void NoteDoubt(PlanarEstimate& estimate) const;

  LikelihoodField field_;
  // Null: one flat map, of field_.
  std::shared_ptr<const LaserLevelMap> levels_;
  std::vector<FreePlace> free_places_;
  double resolution_m_ = 0;
  AmclOptions options_;
  uint64_t seed_ = 0;

  std::vector<Particle> particles_;
  int max_particles_now_ = 0;
  bool is_searching_ = false;
  // Numbers what draws random numbers.
  uint64_t draws_ = 0;
  std::optional<geometry::Rigid2> odom_from_base_;  // of the last call
  std::optional<geometry::Rigid2> odom_at_scan_;    // of the last scan taken in
  bool force_next_ = false;
  bool is_settled_ = true;
  // Since the last Settle a scan was taken in.
  bool is_weighed_ = false;
  // How many fits the averages hold since the particles were placed.
  int64_t fits_ = 0;
  double w_slow_ = 0;
  double w_fast_ = 0;
  std::shared_ptr<const std::vector<FreePlace>> search_places_;
  PlaceHypotheses places_;
  // Where it was sure to be when it began to look everywhere by itself: what is
  // found there is not in doubt.
  struct SurePlace {
    core::LevelPose pose;
    geometry::Rigid2 odom_from_base;
  };
  std::optional<SurePlace> sure_before_;
  PlanarEstimate estimate_;
};

// The number of particles that keeps the sampling error below `error` with the
// probability that `z` stands for, when they fall into `bins` bins (Fox 2003,
// equation 7, by Wilson and Hilferty's approximation). At least 1.
int KldSampleCount(int bins, double error, double z);

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_AMCL_H_
