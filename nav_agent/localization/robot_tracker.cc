#include "nav_agent/localization/robot_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/slope_odometry.h"
#include "nav_agent/localization/global_pose_search.h"
#include "nav_agent/localization/laser_level_map.h"
#include "nav_agent/localization/laser_views.h"
#include "nav_agent/localization/odometry_buffer.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/particle_clusters.h"
#include "nav_agent/localization/scan_points.h"
#include "nav_agent/localization/upright_points.h"

namespace treeline::localization {
namespace {

// Half of the search's grid, then a quarter of it.
constexpr std::array<FitStep, 2> kRefineSteps = {
    {{.m = kRefineStep_m, .rad = kRefineTurnPerStep * kRefineStep_m},
     {.m = kRefineStep_m / 2, .rad = kRefineTurnPerStep * kRefineStep_m / 2}}};

// What a tracker is made of.
struct TrackerParts {
  std::shared_ptr<const LaserLevelMap> map;
  Amcl amcl;
  LostDetector detector;
  // One a level.
  std::vector<ScanChecker> checkers;
  OdometryBuffer wheels;
};

class AmclTracker final : public RobotTracker {
 public:
  AmclTracker(TrackerParts parts, const core::RobotModel& robot,
              const core::RangeSensorInfo& laser,
              const RobotTrackerOptions& options)
      : parts_(std::move(parts)),
        base_from_laser_(robot.base_from_laser),
        laser_(laser),
        options_(options) {}

  absl::Status AddReading(const core::BaseReading& reading) override;
  absl::Status AddScan(const core::LaserScan& scan) override;
  absl::Status SetPose(const core::LevelPose& pose,
                       const PoseCovariance2& covariance,
                       base::MonotonicTime now) override;
  void SetKnownThings(
      const std::shared_ptr<const KnownThings>& things) override {
    parts_.detector.SetKnownThings(things);
  }
  void StartGlobalLocalization(base::MonotonicTime now) override;
  std::optional<TrackedPose> Pose() const override;
  std::optional<TrackedPose> PoseAt(base::MonotonicTime stamp) const override;
  std::optional<TrackedMotion> Motion() const override;
  std::optional<TrackedMotion> MotionAt(
      base::MonotonicTime stamp) const override;
  const LostVerdict& verdict() const override {
    return parts_.detector.verdict();
  }
  std::optional<ScanFit> FitAt(const core::LevelPose& pose) const override;
  void BeginOtherPlaces(const std::optional<core::LevelPose>& than) override;
  bool StepOtherPlaces() override;
  std::vector<OtherPlace> BestPlaces() const override { return places_; }
  std::vector<float> ExpectedRanges_m(const core::LevelPose& pose,
                                      int directions) const override;
  std::optional<base::MonotonicTime> ScanStamp() const override;
  std::vector<geometry::Vec2> ScanInBase() const override;
  std::vector<Particle> Particles(size_t at_most) const override;
  std::vector<PlaceCandidate> Candidates(size_t at_most) const override;
  int64_t dropped() const override { return dropped_; }

 private:
  // A scan and where the wheels were in the middle of it.
  struct MovedScan {
    core::LaserScan scan;
    BufferedOdometry moment;
  };

  base::MonotonicTime MiddleOf(const core::LaserScan& scan) const {
    return scan.stamp +
           std::chrono::duration_cast<base::MonotonicTime::duration>(
               std::chrono::duration<double>(0.5 * laser_.beam_interval_s *
                                             (laser_.beams - 1)));
  }
  TrackedPose PoseFor(const BufferedOdometry& moment) const;
  std::optional<ScanFit> FitOf(const MovedScan& scan,
                               const core::LevelPose& pose) const;
  // The best fit of the search's scan within a few steps of a pose.
  OtherPlace Refined(const core::LevelPose& tried) const;
  absl::Status TakeIn(MovedScan scan);
  // What AMCL makes of the scan that was taken in.
  absl::Status Settle();
  absl::Status TakeWaiting();
  // The estimate may be on another level.
  void NoteLevel();
  // Brings AMCL's wheels up to date, without a scan.
  void CatchUp();
  void Forget(base::MonotonicTime now);

  TrackerParts parts_;
  geometry::Rigid3 base_from_laser_;
  core::RangeSensorInfo laser_;
  RobotTrackerOptions options_;
  std::deque<core::LaserScan> waiting_;
  std::optional<MovedScan> scan_;
  std::optional<base::MonotonicTime> last_scan_;
  std::optional<base::MonotonicTime> told_;
  std::optional<PlanarEstimate> estimate_;
  // Of the estimate.
  geometry::Rigid2 odom_from_base_;
  int map_level_ = 0;
  int64_t dropped_ = 0;
  // For other places: the search, its scan, and what of its best is looked at.
  std::optional<GlobalPoseSearch> search_;
  std::optional<MovedScan> search_scan_;
  std::vector<core::LevelPose> candidates_;
  std::vector<OtherPlace> places_;
};

absl::Status AmclTracker::AddReading(const core::BaseReading& reading) {
  if (const absl::Status added = parts_.wheels.Add(reading); !added.ok()) {
    ++dropped_;
    return added;
  }
  TL_RETURN_IF_ERROR(TakeWaiting());
  if (const std::optional<PlanarEstimate> estimate = parts_.amcl.Ponder()) {
    estimate_ = estimate;
    NoteLevel();
  }
  return absl::OkStatus();
}

absl::Status AmclTracker::AddScan(const core::LaserScan& scan) {
  if (static_cast<int>(scan.ranges_m.size()) != laser_.beams) {
    ++dropped_;
    return absl::InvalidArgumentError(
        absl::StrCat("a scan of ", scan.ranges_m.size(),
                     " beams; the laser has ", laser_.beams));
  }
  // That is enough for one scan's time.
  if (!parts_.amcl.is_settled()) return Settle();
  const base::MonotonicTime middle = MiddleOf(scan);
  if (told_.has_value() && middle < *told_) {
    ++dropped_;
    return absl::OkStatus();
  }
  if (last_scan_.has_value()) {
    if (middle < *last_scan_) {
      ++dropped_;
      return absl::OkStatus();
    }
    // Thirty thousand particles are moved with each scan: less often then.
    const bool searches = estimate_.has_value() && estimate_->is_searching;
    if (base::SecondsBetween(*last_scan_, middle) <
        (searches ? options_.searching_interval_s : options_.scan_interval_s)) {
      return absl::OkStatus();
    }
  }
  last_scan_ = middle;
  if (waiting_.size() >= kMaxWaitingScans) {
    waiting_.pop_front();
    ++dropped_;
  }
  waiting_.push_back(scan);
  return TakeWaiting();
}

absl::Status AmclTracker::TakeWaiting() {
  absl::Status status = absl::OkStatus();
  while (!waiting_.empty() && !parts_.wheels.is_empty()) {
    const base::MonotonicTime middle = MiddleOf(waiting_.front());
    if (middle > parts_.wheels.newest().motion.stamp) break;
    core::LaserScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    std::optional<BufferedOdometry> moment = parts_.wheels.At(middle);
    if (!moment.has_value()) {
      // From before all that is remembered of the wheels.
      ++dropped_;
      continue;
    }
    status.Update(TakeIn({std::move(scan), *moment}));
  }
  return status;
}

absl::Status AmclTracker::TakeIn(MovedScan scan) {
  TL_ASSIGN_OR_RETURN(const ScanPoints points,
                      PointsInSpace(scan.scan, laser_, base_from_laser_,
                                    scan.moment.motion.level_from_base,
                                    options_.amcl.max_beams));
  TL_RETURN_IF_ERROR(
      parts_.amcl.Begin(scan.moment.motion.odom_from_base, points));
  scan_ = std::move(scan);
  // The other half of a long one comes with the next scan.
  if (parts_.amcl.particles().size() > kParticlesAtOnce) {
    return absl::OkStatus();
  }
  return Settle();
}

absl::Status AmclTracker::Settle() {
  const std::optional<PlanarEstimate> estimate = parts_.amcl.Settle();
  if (!estimate.has_value()) return absl::OkStatus();
  estimate_ = estimate;
  odom_from_base_ = scan_->moment.motion.odom_from_base;
  NoteLevel();
  return parts_.detector
      .Observe({.stamp = scan_->moment.motion.stamp,
                .estimate = *estimate,
                .odom_from_base = odom_from_base_,
                .pitch_rad = scan_->moment.pitch_rad,
                .roll_rad = scan_->moment.roll_rad},
               scan_->scan)
      .status();
}

void AmclTracker::NoteLevel() {
  if (estimate_->place.level == map_level_) return;
  map_level_ = estimate_->place.level;
  parts_.detector.SetChecker(parts_.checkers[static_cast<size_t>(map_level_)]);
}

void AmclTracker::CatchUp() {
  if (parts_.wheels.is_empty()) return;
  const geometry::Rigid2& odom_from_base =
      parts_.wheels.newest().motion.odom_from_base;
  const absl::StatusOr<std::optional<PlanarEstimate>> estimate =
      parts_.amcl.Update(odom_from_base, {});
  if (!estimate.ok() || !estimate->has_value()) return;
  estimate_ = **estimate;
  odom_from_base_ = odom_from_base;
}

void AmclTracker::Forget(base::MonotonicTime now) {
  dropped_ += static_cast<int64_t>(waiting_.size());
  waiting_.clear();
  told_ = now;
  parts_.detector.Reset();
  CatchUp();
  if (estimate_.has_value()) {
    map_level_ = estimate_->place.level;
    parts_.detector.SetChecker(
        parts_.checkers[static_cast<size_t>(map_level_)]);
  }
}

absl::Status AmclTracker::SetPose(const core::LevelPose& pose,
                                  const PoseCovariance2& covariance,
                                  base::MonotonicTime now) {
  CatchUp();
  TL_RETURN_IF_ERROR(parts_.amcl.SetPoseOnLevel(
      pose.map_from_base, pose.place.height_m, covariance));
  Forget(now);
  if (!estimate_.has_value()) {
    // No wheels were heard yet: their way begins here.
    const auto estimate = parts_.amcl.Update(geometry::Rigid2(), {});
    if (estimate.ok()) estimate_ = *estimate;
  }
  return absl::OkStatus();
}

void AmclTracker::StartGlobalLocalization(base::MonotonicTime now) {
  CatchUp();
  parts_.amcl.StartGlobalLocalization();
  Forget(now);
}

TrackedPose AmclTracker::PoseFor(const BufferedOdometry& moment) const {
  TrackedPose tracked;
  tracked.stamp = moment.motion.stamp;
  tracked.pose.map_from_base =
      estimate_->map_from_base *
      (odom_from_base_.Inverse() * moment.motion.odom_from_base);
  tracked.pose.place = parts_.map
                           ->GroundNear(tracked.pose.map_from_base.translation,
                                        estimate_->place.height_m)
                           .value_or(estimate_->place);
  tracked.covariance = estimate_->covariance;
  tracked.level_from_base = moment.motion.level_from_base;
  tracked.forward_mps = moment.motion.forward_mps;
  tracked.yaw_rate_radps = moment.motion.yaw_rate_radps;
  tracked.share = estimate_->share;
  tracked.is_searching = estimate_->is_searching;
  tracked.in_doubt = estimate_->in_doubt;
  tracked.place_share = estimate_->place_share;
  tracked.other_places = estimate_->other_places;
  const geometry::Rigid2 estimate_from_now =
      odom_from_base_.Inverse() * moment.motion.odom_from_base;
  for (PossiblePlace& other : tracked.other_places) {
    other.pose.map_from_base = other.pose.map_from_base * estimate_from_now;
  }
  return tracked;
}

std::optional<TrackedPose> AmclTracker::Pose() const {
  if (!estimate_.has_value() || parts_.wheels.is_empty()) return std::nullopt;
  return PoseFor(parts_.wheels.newest());
}

std::optional<TrackedPose> AmclTracker::PoseAt(
    base::MonotonicTime stamp) const {
  if (!estimate_.has_value()) return std::nullopt;
  const std::optional<BufferedOdometry> moment = parts_.wheels.At(stamp);
  if (!moment.has_value()) return std::nullopt;
  return PoseFor(*moment);
}

std::optional<TrackedMotion> AmclTracker::Motion() const {
  if (parts_.wheels.is_empty()) return std::nullopt;
  return parts_.wheels.newest().motion;
}

std::optional<TrackedMotion> AmclTracker::MotionAt(
    base::MonotonicTime stamp) const {
  const std::optional<BufferedOdometry> moment = parts_.wheels.At(stamp);
  if (!moment.has_value()) return std::nullopt;
  return moment->motion;
}

std::optional<ScanFit> AmclTracker::FitAt(const core::LevelPose& pose) const {
  if (!scan_.has_value()) return std::nullopt;
  return FitOf(*scan_, pose);
}

std::optional<ScanFit> AmclTracker::FitOf(const MovedScan& scan,
                                          const core::LevelPose& pose) const {
  if (pose.place.level < 0 ||
      pose.place.level >= static_cast<int>(parts_.checkers.size())) {
    return std::nullopt;
  }
  const auto beams =
      parts_.checkers[static_cast<size_t>(pose.place.level)].Check(
          {.map_from_base = pose.map_from_base,
           .pitch_rad = scan.moment.pitch_rad,
           .roll_rad = scan.moment.roll_rad},
          laser_, base_from_laser_, scan.scan);
  if (!beams.ok()) return std::nullopt;
  ScanFit fit;
  int explained = 0;
  int contradicted = 0;
  for (const CheckedBeam& beam : *beams) {
    fit.judged += beam.fit != BeamFit::kNotJudged ? 1 : 0;
    explained += beam.fit == BeamFit::kExplained ? 1 : 0;
    contradicted += beam.fit == BeamFit::kLong ? 1 : 0;
  }
  if (fit.judged > 0) {
    fit.explained = static_cast<double>(explained) / fit.judged;
    fit.contradicted = static_cast<double>(contradicted) / fit.judged;
  }
  return fit;
}

void AmclTracker::BeginOtherPlaces(const std::optional<core::LevelPose>& than) {
  search_.reset();
  candidates_.clear();
  places_.clear();
  search_scan_ = scan_;
  if (!scan_.has_value()) return;
  const absl::StatusOr<ScanPoints> points =
      PointsInSpace(scan_->scan, laser_, base_from_laser_,
                    scan_->moment.motion.level_from_base, kScanBeams);
  if (!points.ok()) return;
  search_.emplace(parts_.amcl.search_places(),
                  UprightPoints(*points, options_.lost.scan.ground_m), than);
}

bool AmclTracker::StepOtherPlaces() {
  if (search_.has_value()) {
    if (!search_->Step(parts_.map->field())) return false;
    candidates_ = search_->Best();
    search_.reset();
    return candidates_.empty();
  }
  if (candidates_.empty()) return true;
  const OtherPlace place = Refined(candidates_.back());
  candidates_.pop_back();
  const auto before =
      std::ranges::find_if(places_, [&](const OtherPlace& other) {
        return FitScore(other.fit) < FitScore(place.fit);
      });
  places_.insert(before, place);
  return candidates_.empty();
}

RobotTracker::OtherPlace AmclTracker::Refined(
    const core::LevelPose& tried) const {
  // The place itself is between those that were tried.
  const FittedPose best = RefineFit(
      {.pose = tried, .fit = {}, .score = -2}, kRefineSteps, 0,
      [this](const core::LevelPose& pose) {
        return FitOf(*search_scan_, pose);
      },
      [](const core::LevelPose&, const ScanFit& fit) { return FitScore(fit); });
  return {.pose = best.pose, .fit = best.fit};
}

std::vector<float> AmclTracker::ExpectedRanges_m(const core::LevelPose& pose,
                                                 int directions) const {
  std::vector<float> ranges_m;
  if (pose.place.level < 0 ||
      pose.place.level >= static_cast<int>(parts_.checkers.size())) {
    return ranges_m;
  }
  const ScanChecker& checker =
      parts_.checkers[static_cast<size_t>(pose.place.level)];
  ranges_m.reserve(static_cast<size_t>(directions));
  for (int i = 0; i < directions; ++i) {
    const double yaw_rad =
        pose.map_from_base.yaw_rad + 2 * std::numbers::pi * i / directions;
    const ScanChecker::Ray ray =
        checker.Cast(pose.map_from_base.translation,
                     {std::cos(yaw_rad), std::sin(yaw_rad)}, kViewRange_m);
    ranges_m.push_back(ray.is_known ? static_cast<float>(ray.range_m)
                                    : std::numeric_limits<float>::quiet_NaN());
  }
  return ranges_m;
}

std::optional<base::MonotonicTime> AmclTracker::ScanStamp() const {
  if (!scan_.has_value()) return std::nullopt;
  return scan_->moment.motion.stamp;
}

std::vector<geometry::Vec2> AmclTracker::ScanInBase() const {
  std::vector<geometry::Vec2> ends;
  if (!scan_.has_value()) return ends;
  const absl::StatusOr<ScanPoints> points = PointsAtLaserHeight(
      scan_->scan, laser_, base_from_laser_, scan_->moment.pitch_rad,
      scan_->moment.roll_rad, laser_.beams, options_.lost.scan);
  if (!points.ok()) return ends;
  ends.reserve(points->size());
  for (size_t i = 0; i < points->size(); ++i) {
    ends.push_back({points->x_m[i], points->y_m[i]});
  }
  return ends;
}

std::vector<Particle> AmclTracker::Particles(size_t at_most) const {
  const std::vector<Particle>& all = parts_.amcl.particles();
  if (all.size() <= at_most) return all;
  std::vector<Particle> some;
  some.reserve(at_most);
  for (size_t i = 0; i < at_most; ++i) {
    some.push_back(all[i * all.size() / at_most]);
  }
  return some;
}

std::vector<PlaceCandidate> AmclTracker::Candidates(size_t at_most) const {
  const std::vector<Particle>& all = parts_.amcl.particles();
  if (all.empty()) return {};
  const PoseBins bins =
      BinParticles(all, options_.amcl.bin_m, options_.amcl.bin_rad);
  std::vector<std::vector<Particle>> clusters(
      static_cast<size_t>(bins.clusters));
  std::vector<double> weights(clusters.size());
  for (size_t i = 0; i < all.size(); ++i) {
    const auto cluster = static_cast<size_t>(
        bins.cluster_of_bin[static_cast<size_t>(bins.bin_of_particle[i])]);
    clusters[cluster].push_back(all[i]);
    weights[cluster] += all[i].weight;
  }
  std::vector<size_t> order(clusters.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, [&weights](size_t a, size_t b) {
    return weights[a] > weights[b];
  });
  std::vector<PlaceCandidate> candidates;
  for (size_t i = 0; i < std::min(at_most, order.size()); ++i) {
    const PlanarEstimate estimate = HeaviestCluster(
        clusters[order[i]], options_.amcl.bin_m, options_.amcl.bin_rad);
    candidates.push_back(
        {.pose = {.map_from_base = estimate.map_from_base,
                  .place = parts_.map
                               ->GroundNear(estimate.map_from_base.translation,
                                            estimate.place.height_m)
                               .value_or(estimate.place)},
         .covariance = estimate.covariance,
         .share = weights[order[i]]});
  }
  return candidates;
}

}  // namespace

absl::Status RobotTrackerOptions::Validate() const {
  TL_RETURN_IF_ERROR(amcl.Validate());
  TL_RETURN_IF_ERROR(lost.Validate());
  TL_RETURN_IF_ERROR(
      base::CheckRange("tracker: scan_interval_s", scan_interval_s, 0, 10));
  return base::CheckRange("tracker: searching_interval_s", searching_interval_s,
                          0, 10);
}

absl::StatusOr<std::unique_ptr<RobotTracker>> RobotTracker::Create(
    const octree::VoxelMap& voxels,
    const traversability::TraversableMap& levels, const core::RobotModel& robot,
    const core::RangeSensorInfo& laser, const RobotTrackerOptions& options,
    uint64_t seed) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  if (laser.beams < 1) {
    return absl::InvalidArgumentError(
        "tracker: the laser has not said what it is yet");
  }
  TL_ASSIGN_OR_RETURN(
      LaserLevelMap level_map,
      LaserLevelMap::Make(voxels, levels, {.field = options.amcl.field}));
  auto map = std::make_shared<const LaserLevelMap>(std::move(level_map));
  TL_ASSIGN_OR_RETURN(Amcl amcl, Amcl::CreateOnLevels(map, options.amcl, seed));
  std::vector<ScanChecker> checkers;
  std::optional<LostDetector> detector;
  for (int level = 0; level < static_cast<int>(levels.levels.size()); ++level) {
    TL_ASSIGN_OR_RETURN(
        const LaserMap laser_map,
        LaserMapOf(voxels, levels, level,
                   {.laser_height_m = robot.base_from_laser.translation.z}));
    TL_ASSIGN_OR_RETURN(ScanChecker checker,
                        ScanChecker::Create(laser_map, options.lost.scan));
    checkers.push_back(std::move(checker));
    if (detector.has_value()) continue;
    TL_ASSIGN_OR_RETURN(
        detector, LostDetector::Create(laser_map, laser, robot.base_from_laser,
                                       options.lost));
  }
  TL_ASSIGN_OR_RETURN(
      core::SlopeOdometry odometry,
      core::SlopeOdometry::Create({.wheel_track_m = robot.wheel_track_m}));
  return std::make_unique<AmclTracker>(
      TrackerParts{.map = std::move(map),
                   .amcl = std::move(amcl),
                   .detector = *std::move(detector),
                   .checkers = std::move(checkers),
                   .wheels = OdometryBuffer(odometry)},
      robot, laser, options);
}

}  // namespace treeline::localization
