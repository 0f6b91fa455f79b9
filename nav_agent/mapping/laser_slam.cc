#include "nav_agent/mapping/laser_slam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/processor_time.h"
#include "common/base/status_macros.h"
#include "nav_agent/mapping/keyscan.h"
#include "nav_agent/mapping/loop_worker.h"
#include "nav_agent/mapping/scan_plane.h"
#include "nav_agent/mapping/traversed_ground.h"
#include "nav_agent/mapping/window_matcher.h"

namespace treeline::mapping {
namespace {

bool IsFinitePose(const geometry::Rigid2& pose) {
  return std::isfinite(pose.translation.x) &&
         std::isfinite(pose.translation.y) && std::isfinite(pose.yaw_rad);
}

bool HasMoved(const geometry::Rigid2& motion, double length_m,
              double angle_rad) {
  return geometry::Norm(motion.translation) >= length_m ||
         std::abs(motion.yaw_rad) >= angle_rad;
}

// A tilt that is none (rad).
constexpr double kLevel_rad = 1e-4;
// How much a turn counts beside a way, when corrections are spread (m per rad).
constexpr double kTurnAsWay_m = 0.3;
// Climbs follow the matched way within these factors, and once the way is long
// enough.
constexpr double kMinShareOfWay = 0.5;
constexpr double kMaxShareOfWay = 1.5;
constexpr double kTellingWay_m = 0.03;

// The usual response, of a running mean: where it begins, and how fast it
// follows.
constexpr double kFirstResponse = 0.7;
constexpr double kResponseRate = 0.05;
bool IsTilted(const geometry::Rotation3& level_from_base) {
  return std::hypot(level_from_base.x, level_from_base.y) > 0.5 * kLevel_rad;
}

// The keyscan of a scan of which nobody knows where it was taken.
constexpr size_t kNowhere = std::numeric_limits<size_t>::max();
// So long before a robot is in doubt it may have been lifted, and so long after
// it was put down it may sway (s).
constexpr double kCarried_s = 0.3;

// A scan's place, tied to the keyscan before it so that it moves with it.
struct ScanPlace {
  recording::RecordingTime stamp;
  size_t keyscan = 0;  // or kNowhere
  geometry::Rigid2 keyscan_from_base;
  double climb_m = 0;  // since the keyscan
  geometry::Rotation3 level_from_base;
  double way_m = 0;  // in odometry, turns too
};

class LaserSlamOnThread final : public LaserSlam {
 public:
  LaserSlamOnThread(const core::RangeSensorInfo& laser,
                    const geometry::Rigid3& base_from_laser,
                    const LaserSlamOptions& options)
      : laser_(laser),
        base_from_laser_(base_from_laser),
        options_(options),
        ground_(options.ground_reach_m),
        leaves_out_ground_(options.ground_margin_m > 0 &&
                           base_from_laser.translation.z >
                               2 * options.ground_margin_m),
        doubt_(options.odometry, options.search_sigmas),
        watch_(options.carries),
        finder_(options.segments, options.matcher),
        worker_(LoopCloser(options.loops, options.matcher, options.graph),
                options.synchronous) {}

  absl::StatusOr<geometry::Rigid2> AddScan(const LaserSlamScan& scan) override;
  double Height_m() const override { return height_m_; }
  bool IsLost() const override { return is_lost_; }
  bool SuggestPlace(recording::RecordingTime stamp,
                    const geometry::Rigid2& map_from_base,
                    double height_m) override;
  void Finish() override {
    worker_.Finish(options_.polish_rounds);
    ApplyCorrection();
  }
  std::vector<TrajectoryPose> Trajectory() const override;
  LaserSlamStatistics Statistics() const override {
    LaserSlamStatistics statistics = statistics_;
    statistics.keyscans = static_cast<int64_t>(keyscans_.size());
    statistics.loops = worker_.Statistics();
    statistics.odometry_scale_m = doubt_.scale_m();
    statistics.odometry_scale_rad = doubt_.scale_rad();
    return statistics;
  }

 private:
  absl::Status Check(const LaserSlamScan& scan) const;
  void ApplyCorrection();
  // Finds the robot, from a prediction; false: odometry has to do.
  bool Match(const ScanOutline& scan, const LaserSlamScan& taken,
             const MatchSearch& search, Covariance3* covariance);
  struct Window {
    std::vector<PlacedScan> references;
    // The direction in which they do not tell where the robot is; or 0.
    geometry::Vec2 untold;
  };
  Window WindowFor(const ScanPlane& plane) const;
  MatchSearch SearchAfter(const geometry::Rigid2& motion) const;
  // The scan's points, without those that are known to be ground.
  std::shared_ptr<const ScanOutline> OutlineOf(const LaserSlamScan& scan) const;
  // Where odometry says that the robot is now.
  void Predict(const LaserSlamScan& scan);
  // Matches the scan against the window; its covariance, by odometry where it
  // does not match.
  Covariance3 Locate(const ScanOutline& outline, const LaserSlamScan& scan);
  // Of a robot whose wheels stand: whether it sees something else than before,
  // and only whether that can be where it is. People before it move nothing.
  bool IsElsewhere(const LaserSlamScan& scan) const {
    return options_.notices_carries &&
           (watch_.in_doubt() || watch_.HasChanged(scan.ranges_m));
  }
  void Glance(const ScanOutline& outline, const LaserSlamScan& scan);
  // Spreads what matching has corrected over the scans since the last match.
  void SpreadCorrection(const geometry::Rigid2& map_from_predicted);
  void FollowWay(const geometry::Rigid2& map_from_predicted);
  void AddKeyscan(std::shared_ptr<const ScanOutline> outline,
                  const LaserSlamScan& scan,
                  const Covariance3& covariance_in_map);
  void AddPlace(const LaserSlamScan& scan);
  // ---- carried off ----
  bool Doubts(const ScanOutline& scan, const geometry::Rotation3& level,
              const geometry::Rigid2& map_from_scan,
              const WindowMatch& found) const;
  // What hangs together with the scan in hand.
  std::span<const Keyscan> Segment() const {
    return std::span(keyscans_).subspan(segment_begin_);
  }
  // Nobody knows any more where the robot is: a segment begins.
  void LoseWay(const LaserSlamScan& scan);
  void LookForSegment(recording::RecordingTime stamp);
  // The segment hangs on the map.
  void Join(const SegmentLink& link);

  const core::RangeSensorInfo laser_;
  const geometry::Rigid3 base_from_laser_;
  const LaserSlamOptions options_;
  std::vector<Keyscan> keyscans_;
  std::vector<ScanPlace> places_;
  geometry::Rigid2 map_from_base_;
  double height_m_ = 0;  // of the base, in the map
  double way_m_ = 0;
  // The last scan that was matched: its number and where it was; by how much
  // odometry has climbed since then.
  size_t matched_place_ = 0;
  double matched_way_m_ = 0;
  geometry::Rigid2 map_from_matched_;
  double climb_since_match_m_ = 0;
  // The last scan's height in odometry.
  double last_height_m_ = 0;
  // Odometry of the last scan, of the last one that was matched, and of the
  // last keyscan.
  geometry::Rigid2 odom_from_last_;
  geometry::Rigid2 odom_from_matched_;
  geometry::Rigid2 odom_from_keyscan_;
  TraversedGround ground_;
  const bool leaves_out_ground_;
  OdometryDoubt doubt_;
  CarryWatch watch_;
  SegmentFinder finder_;
  // What map_from_base says is of a frame of its own since this keyscan: the
  // segment's. Its keyscans are not the loop closer's yet.
  bool is_lost_ = false;
  size_t segment_begin_ = 0;
  recording::RecordingTime segment_since_;
  std::vector<NewKeyscan> of_segment_;
  // Of keyscans since the last match that did not match: odometry's errors add
  // up until one does.
  OdometryDoubt::Sigma unmatched_;
  bool has_matched_ = false;  // the scan in hand
  bool stands_ = false;       // since the last scan that was matched
  bool is_doubtful_ = false;  // it cannot be of where the robot seems to be
  // How scans respond usually.
  double usual_response_ = kFirstResponse;
  LaserSlamStatistics statistics_;
  LoopWorker worker_;
};

absl::Status LaserSlamOnThread::Check(const LaserSlamScan& scan) const {
  if (static_cast<int>(scan.ranges_m.size()) != laser_.beams) {
    return absl::InvalidArgumentError(
        absl::StrCat("a scan of ", scan.ranges_m.size(), " beams from a laser",
                     " of ", laser_.beams));
  }
  const geometry::Rotation3& q = scan.level_from_base;
  if (!IsFinitePose(scan.odom_from_base) ||
      !IsFinitePose(scan.first_from_last) || !std::isfinite(scan.height_m) ||
      !geometry::IsFinite(geometry::Rigid3{.rotation = q, .translation = {}})) {
    return absl::InvalidArgumentError("a scan at a pose that is not finite");
  }
  if (!places_.empty() && scan.stamp < places_.back().stamp) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the clock jumped back by %.3f s",
        recording::SecondsBetween(scan.stamp, places_.back().stamp)));
  }
  return absl::OkStatus();
}

void LaserSlamOnThread::ApplyCorrection() {
  const auto corrected = worker_.TakeCorrection();
  if (!corrected.has_value() || corrected->empty()) return;
  const size_t known = corrected->size();
  // What came later moves with the last one that was corrected.
  const KeyscanPlace& last = corrected->back();
  const geometry::Rigid2 new_from_old =
      last.map_from_base * keyscans_[known - 1].map_from_base.Inverse();
  const double rise_m = last.height_m - keyscans_[known - 1].height_m;
  ground_.Clear();
  const size_t in_map = is_lost_ ? segment_begin_ : keyscans_.size();
  for (size_t i = 0; i < in_map; ++i) {
    Keyscan& keyscan = keyscans_[i];
    if (i < known) {
      keyscan.map_from_base = (*corrected)[i].map_from_base;
      keyscan.height_m = (*corrected)[i].height_m;
    } else {
      keyscan.map_from_base = new_from_old * keyscan.map_from_base;
      keyscan.height_m += rise_m;
    }
    ground_.Add(keyscan.Place());
  }
  if (is_lost_) return;
  map_from_base_ = new_from_old * map_from_base_;
  map_from_matched_ = new_from_old * map_from_matched_;
  height_m_ += rise_m;
}

MatchSearch LaserSlamOnThread::SearchAfter(
    const geometry::Rigid2& motion) const {
  const OdometryDoubt::Sigma sigma = doubt_.SigmaOf(motion);
  const OdometryDoubt::Sigma search = doubt_.SearchOf(motion);
  const double sigmas = options_.search_sigmas;
  return {.half_extent_m =
              std::min(search.m + sigmas * unmatched_.m, options_.max_search_m),
          .half_angle_rad = std::min(search.rad + sigmas * unmatched_.rad,
                                     options_.max_search_rad),
          .guess_sigma_m = std::hypot(sigma.m, unmatched_.m),
          .guess_sigma_rad = std::hypot(sigma.rad, unmatched_.rad)};
}

LaserSlamOnThread::Window LaserSlamOnThread::WindowFor(
    const ScanPlane& plane) const {
  Window alike;
  Window all;
  const size_t count =
      std::min(Segment().size(), static_cast<size_t>(options_.window));
  for (size_t i = keyscans_.size() - count; i < keyscans_.size(); ++i) {
    const Keyscan& keyscan = keyscans_[i];
    const ScanPlane other = keyscan.Plane();
    if (Gap_m(plane, other) > options_.max_gap_m) continue;
    const PlacedScan reference = {.scan = keyscan.scan.get(),
                                  .target_from_scan = keyscan.map_from_base};
    all.references.push_back(reference);
    if (TiltBetween(plane, other) <= options_.max_tilt) {
      alike.references.push_back(reference);
    } else {
      all.untold = all.untold + (other.slope - plane.slope);
    }
  }
  const bool enough =
      static_cast<int>(alike.references.size()) >= options_.min_alike;
  if (enough || alike.references.size() == all.references.size()) return alike;
  const double tilt = geometry::Norm(all.untold);
  if (tilt > 0) all.untold = (1 / tilt) * all.untold;
  return all;
}

bool LaserSlamOnThread::Doubts(const ScanOutline& scan,
                               const geometry::Rotation3& level,
                               const geometry::Rigid2& map_from_scan,
                               const WindowMatch& found) const {
  if (!options_.notices_carries || Segment().empty()) return false;
  const double response = found.match.response;
  return watch_.IsDoubtful(
      {.response = response,
       .usual_response = usual_response_,
       .stands = stands_,
       .is_found_widely =
           found.found_widely > 0 && response >= options_.min_response,
       .level_from_base = level,
       .keyscans = Segment(),
       .scan = &scan,
       .map_from_base = map_from_scan});
}

bool LaserSlamOnThread::Match(const ScanOutline& scan,
                              const LaserSlamScan& taken,
                              const MatchSearch& search,
                              Covariance3* covariance) {
  if (static_cast<int>(scan.size()) < options_.min_points) {
    is_doubtful_ = watch_.in_doubt();
    return false;
  }
  const geometry::Rigid2 guess = map_from_base_;
  const geometry::Vec2 slope = SlopeUnder(taken.level_from_base);
  const Window window = WindowFor({.at = guess.translation,
                                   .height_m = height_m_,
                                   .slope = TurnedBy(guess.yaw_rad, slope)});
  const double enough =
      std::max(options_.min_response, usual_response_ - options_.poor_response);
  const WindowMatch found =
      MatchInWindow(window.references, scan, guess, search, enough, options_);
  statistics_.searched_widely += found.searched_widely;
  const ScanMatch& match = found.match;
  const bool matches = match.response >= options_.min_response;
  is_doubtful_ = Doubts(scan, taken.level_from_base,
                        matches ? match.target_from_scan : guess, found);
  if (!matches || is_doubtful_) return false;
  statistics_.found_widely += found.found_widely;
  usual_response_ += kResponseRate * (match.response - usual_response_);
  map_from_base_ = match.target_from_scan;
  *covariance = match.covariance;
  const geometry::Vec2 untold = window.untold;
  if (untold == geometry::Vec2{}) return true;
  const double off_m = geometry::Dot(
      match.target_from_scan.translation - guess.translation, untold);
  map_from_base_.translation = map_from_base_.translation - off_m * untold;
  const double variance = search.guess_sigma_m * search.guess_sigma_m;
  (*covariance)[0] += variance * untold.x * untold.x;
  (*covariance)[1] += variance * untold.x * untold.y;
  (*covariance)[3] += variance * untold.x * untold.y;
  (*covariance)[4] += variance * untold.y * untold.y;
  return true;
}

std::shared_ptr<const ScanOutline> LaserSlamOnThread::OutlineOf(
    const LaserSlamScan& scan) const {
  const geometry::Rigid3 level_from_laser =
      geometry::Rigid3{.rotation = scan.level_from_base, .translation = {}} *
      base_from_laser_;
  ScanOutlineOptions points = options_.points;
  std::span<const float> ranges_m = scan.ranges_m;
  std::vector<float> kept;
  const bool is_tilted = IsTilted(scan.level_from_base);
  if (leaves_out_ground_ && is_tilted) {
    points.min_height_m =
        std::max(points.min_height_m, options_.ground_margin_m);
  }
  if (leaves_out_ground_ && !ground_.IsLevel(options_.ground_margin_m)) {
    const geometry::Vec2 at = map_from_base_.translation;
    const geometry::Rigid3 map_from_level = {
        .rotation =
            geometry::Rotation3::FromAxisAngle({0, 0, map_from_base_.yaw_rad}),
        .translation = {at.x, at.y, height_m_}};
    kept = WithoutGround(ranges_m, laser_, map_from_level * level_from_laser,
                         ground_, options_.ground_margin_m);
    ranges_m = kept;
  }
  return std::make_shared<const ScanOutline>(MakeScanOutline(
      ranges_m, laser_, level_from_laser, points, scan.first_from_last));
}

void LaserSlamOnThread::Predict(const LaserSlamScan& scan) {
  if (places_.empty()) {
    last_height_m_ = scan.height_m;
    return;
  }
  const geometry::Rigid2 motion =
      odom_from_last_.Inverse() * scan.odom_from_base;
  map_from_base_ = map_from_base_ * motion;
  way_m_ += geometry::Norm(motion.translation) +
            kTurnAsWay_m * std::abs(motion.yaw_rad);
  const double climb_m = scan.height_m - last_height_m_;
  height_m_ += climb_m;
  climb_since_match_m_ += climb_m;
  last_height_m_ = scan.height_m;
}

void LaserSlamOnThread::SpreadCorrection(
    const geometry::Rigid2& map_from_predicted) {
  const double length_m = way_m_ - matched_way_m_;
  if (!(length_m > 0) || keyscans_.empty()) return;
  const double yaw_rad = geometry::NormalizedAngle_rad(
      map_from_base_.yaw_rad - map_from_predicted.yaw_rad);
  // In the axes of the keyscan that they are all tied to.
  const geometry::Vec2 off =
      geometry::Rigid2{.translation = {},
                       .yaw_rad = -keyscans_.back().map_from_base.yaw_rad} *
      (map_from_base_.translation - map_from_predicted.translation);
  for (size_t i = matched_place_ + 1; i < places_.size(); ++i) {
    ScanPlace& place = places_[i];
    if (place.keyscan == kNowhere) continue;
    const double part = (place.way_m - matched_way_m_) / length_m;
    geometry::Rigid2& keyscan_from_base = place.keyscan_from_base;
    keyscan_from_base.translation = keyscan_from_base.translation + part * off;
    keyscan_from_base.yaw_rad = geometry::NormalizedAngle_rad(
        keyscan_from_base.yaw_rad + part * yaw_rad);
  }
}

void LaserSlamOnThread::FollowWay(const geometry::Rigid2& map_from_predicted) {
  const geometry::Vec2 matched =
      map_from_base_.translation - map_from_matched_.translation;
  const geometry::Vec2 predicted =
      map_from_predicted.translation - map_from_matched_.translation;
  const double length_m = geometry::Norm(predicted);
  if (length_m > kTellingWay_m) {
    const double factor =
        std::clamp(geometry::Dot(matched, predicted) / (length_m * length_m),
                   kMinShareOfWay, kMaxShareOfWay);
    height_m_ += (factor - 1) * climb_since_match_m_;
  }
}

void LaserSlamOnThread::Glance(const ScanOutline& outline,
                               const LaserSlamScan& scan) {
  const geometry::Rigid2 map_from_base = map_from_base_;
  const double usual_response = usual_response_;
  Covariance3 unused{};
  stands_ = true;
  Match(outline, scan,
        SearchAfter(odom_from_matched_.Inverse() * scan.odom_from_base),
        &unused);
  stands_ = false;
  map_from_base_ = map_from_base;
  usual_response_ = usual_response;
}

Covariance3 LaserSlamOnThread::Locate(const ScanOutline& outline,
                                      const LaserSlamScan& scan) {
  ++statistics_.looked_at;
  const geometry::Rigid2 since_match =
      odom_from_matched_.Inverse() * scan.odom_from_base;
  const geometry::Rigid2 map_from_predicted = map_from_base_;
  Covariance3 covariance{};
  if (Match(outline, scan, SearchAfter(since_match), &covariance)) {
    has_matched_ = true;
    unmatched_ = {};
    doubt_.Learn(since_match, map_from_predicted.Inverse() * map_from_base_);
    SpreadCorrection(map_from_predicted);
    FollowWay(map_from_predicted);
    odom_from_matched_ = scan.odom_from_base;
    map_from_matched_ = map_from_base_;
    climb_since_match_m_ = 0;
    matched_place_ = places_.size();
    matched_way_m_ = way_m_;
    return covariance;
  }
  has_matched_ = false;
  ++statistics_.unmatched;
  const MatchSearch since = SearchAfter(since_match);
  statistics_.unmatched_sigma_m =
      std::max(statistics_.unmatched_sigma_m, since.guess_sigma_m);
  statistics_.unmatched_sigma_rad =
      std::max(statistics_.unmatched_sigma_rad, since.guess_sigma_rad);
  const OdometryDoubt::Sigma odometry =
      doubt_.SigmaOf(odom_from_keyscan_.Inverse() * scan.odom_from_base);
  covariance[0] = covariance[4] = odometry.m * odometry.m;
  covariance[8] = odometry.rad * odometry.rad;
  return covariance;
}

void LaserSlamOnThread::AddKeyscan(std::shared_ptr<const ScanOutline> outline,
                                   const LaserSlamScan& scan,
                                   const Covariance3& covariance_in_map) {
  NewKeyscan added = {.scan = outline,
                      .previous_from_this = {},
                      .slope = SlopeUnder(scan.level_from_base)};
  if (!Segment().empty()) {
    const Keyscan& previous = keyscans_.back();
    added.previous_from_this =
        previous.map_from_base.Inverse() * map_from_base_;
    added.covariance =
        Turned(covariance_in_map, -previous.map_from_base.yaw_rad);
    added.climb_m = height_m_ - previous.height_m;
  }
  keyscans_.push_back({.scan = std::move(outline),
                       .map_from_base = map_from_base_,
                       .height_m = height_m_,
                       .slope = added.slope});
  if (!is_lost_) ground_.Add(keyscans_.back().Place());
  if (!has_matched_ && Segment().size() > 1) {
    const OdometryDoubt::Sigma sigma =
        doubt_.SigmaOf(odom_from_matched_.Inverse() * scan.odom_from_base);
    unmatched_ = {.m = std::hypot(unmatched_.m, sigma.m),
                  .rad = std::hypot(unmatched_.rad, sigma.rad)};
  }
  odom_from_keyscan_ = scan.odom_from_base;
  odom_from_matched_ = scan.odom_from_base;
  map_from_matched_ = map_from_base_;
  climb_since_match_m_ = 0;
  matched_place_ = places_.size();
  matched_way_m_ = way_m_;
  if (is_lost_) {
    of_segment_.push_back(std::move(added));
  } else {
    worker_.Add(std::move(added));
  }
}

void LaserSlamOnThread::AddPlace(const LaserSlamScan& scan) {
  ScanPlace place = {.stamp = scan.stamp,
                     .keyscan_from_base = map_from_base_,
                     .climb_m = height_m_,
                     .level_from_base = scan.level_from_base,
                     .way_m = way_m_};
  if (!keyscans_.empty()) {
    const Keyscan& keyscan = keyscans_.back();
    place.keyscan = keyscans_.size() - 1;
    place.keyscan_from_base = keyscan.map_from_base.Inverse() * map_from_base_;
    place.climb_m = height_m_ - keyscan.height_m;
  }
  if (is_lost_ &&
      (Segment().empty() ||
       recording::SecondsBetween(segment_since_, scan.stamp) < kCarried_s)) {
    place.keyscan = kNowhere;
  }
  places_.push_back(place);
  odom_from_last_ = scan.odom_from_base;
}

absl::StatusOr<geometry::Rigid2> LaserSlamOnThread::AddScan(
    const LaserSlamScan& scan) {
  TL_RETURN_IF_ERROR(Check(scan));
  const double start_ms = base::ThreadProcessorTime_ms();
  ApplyCorrection();
  Predict(scan);
  std::shared_ptr<const ScanOutline> outline;
  bool is_keyscan = false;
  Covariance3 covariance{};
  if (keyscans_.empty()) {
    outline = OutlineOf(scan);
    is_keyscan = !outline->empty();
  } else {
    const geometry::Rigid2& odom_from_base = scan.odom_from_base;
    is_keyscan = HasMoved(odom_from_keyscan_.Inverse() * odom_from_base,
                          options_.keyscan_m, options_.keyscan_rad);
    const bool has_moved =
        HasMoved(odom_from_matched_.Inverse() * odom_from_base,
                 options_.still_m, options_.still_rad);
    if (is_keyscan || has_moved || IsElsewhere(scan)) {
      outline = OutlineOf(scan);
      is_doubtful_ = false;
      if (is_keyscan || has_moved) {
        covariance = Locate(*outline, scan);
      } else {
        Glance(*outline, scan);
      }
      watch_.Note(scan.ranges_m);
      if (watch_.Add(is_doubtful_, scan.stamp)) LoseWay(scan);
      // What is in doubt is no reference; what a segment begins with is.
      is_keyscan = is_lost_ && Segment().empty() ? !outline->empty()
                                                 : is_keyscan && !is_doubtful_;
    }
  }
  statistics_.front_end_ms.push_back(base::ThreadProcessorTime_ms() - start_ms);
  if (is_keyscan) AddKeyscan(std::move(outline), scan, covariance);
  AddPlace(scan);
  ++statistics_.scans;
  if (is_lost_) LookForSegment(scan.stamp);
  return map_from_base_;
}

void LaserSlamOnThread::LoseWay(const LaserSlamScan& scan) {
  const recording::RecordingTime since = watch_.since();
  watch_.Reset();
  if (is_lost_) {
    // Again: of what was seen meanwhile nobody will know where it was.
    keyscans_.resize(segment_begin_);
    of_segment_.clear();
  } else {
    statistics_.carries.push_back({.at = since, .found = {}});
  }
  for (size_t i = places_.size(); i-- > 0;) {
    const bool is_before =
        recording::SecondsBetween(places_[i].stamp, since) > kCarried_s &&
        places_[i].keyscan < keyscans_.size();
    if (is_before) break;
    places_[i].keyscan = kNowhere;
  }
  is_lost_ = true;
  segment_begin_ = keyscans_.size();
  segment_since_ = scan.stamp;
  unmatched_ = {};
  has_matched_ = true;
  usual_response_ = std::max(usual_response_, kFirstResponse);
  finder_.Begin();
  // It may all have been people in front of it.
  finder_.Suggest({}, 0, SegmentWitness::kBelief);
}

void LaserSlamOnThread::LookForSegment(recording::RecordingTime stamp) {
  const std::optional<SegmentLink> link =
      finder_.Step(std::span(keyscans_).first(segment_begin_), Segment());
  if (!link.has_value()) return;
  statistics_.carries.back().found = stamp;
  statistics_.carries.back().who = link->who;
  Join(*link);
}

void LaserSlamOnThread::Join(const SegmentLink& link) {
  const geometry::Rigid2& map_from_segment = link.map_from_segment;
  for (size_t i = segment_begin_; i < keyscans_.size(); ++i) {
    Keyscan& keyscan = keyscans_[i];
    keyscan.map_from_base = map_from_segment * keyscan.map_from_base;
    keyscan.height_m += link.rise_m;
    ground_.Add(keyscan.Place());
  }
  map_from_base_ = map_from_segment * map_from_base_;
  map_from_matched_ = map_from_segment * map_from_matched_;
  height_m_ += link.rise_m;
  is_lost_ = false;
  // The first of the segment hangs where the one that was found says; what is
  // not known of that one's yaw moves the first.
  const Keyscan& from = keyscans_[link.map_keyscan];
  const Keyscan& first = keyscans_[segment_begin_];
  const Keyscan& found = keyscans_[segment_begin_ + link.segment_keyscan];
  NewKeyscan& tied = of_segment_.front();
  tied.tied_to = static_cast<int>(link.map_keyscan);
  tied.previous_from_this = from.map_from_base.Inverse() * first.map_from_base;
  tied.climb_m = first.height_m - from.height_m;
  Covariance3 covariance = link.covariance;
  for (size_t i = 1; i <= link.segment_keyscan; ++i) {
    const Covariance3& step = of_segment_[i].covariance;
    const double variance_m2 = std::max(step[0], step[4]);
    covariance[0] += variance_m2;
    covariance[4] += variance_m2;
    covariance[8] += step[8];
  }
  const double arm_m = geometry::Norm(first.map_from_base.translation -
                                      found.map_from_base.translation);
  covariance[0] += covariance[8] * arm_m * arm_m;
  covariance[4] += covariance[8] * arm_m * arm_m;
  tied.covariance = Turned(covariance, -from.map_from_base.yaw_rad);
  for (NewKeyscan& keyscan : of_segment_) worker_.Add(std::move(keyscan));
  of_segment_.clear();
  segment_begin_ = 0;
}

bool LaserSlamOnThread::SuggestPlace(recording::RecordingTime stamp,
                                     const geometry::Rigid2& map_from_base,
                                     double height_m) {
  if (!is_lost_) return false;
  const auto after = std::lower_bound(
      places_.begin(), places_.end(), stamp,
      [](const ScanPlace& place, recording::RecordingTime time) {
        return place.stamp < time;
      });
  if (after == places_.end() || after == places_.begin() ||
      after->keyscan == kNowhere || after->keyscan < segment_begin_ ||
      (after - 1)->keyscan == kNowhere) {
    return false;
  }
  const auto segment_from = [this](const ScanPlace& place) {
    return keyscans_[place.keyscan].map_from_base * place.keyscan_from_base;
  };
  const ScanPlace& before = *(after - 1);
  const geometry::Rigid2 segment_from_before = segment_from(before);
  const geometry::Rigid2 motion =
      segment_from_before.Inverse() * segment_from(*after);
  const double length_s = recording::SecondsBetween(before.stamp, after->stamp);
  const double part =
      length_s > 0 ? recording::SecondsBetween(before.stamp, stamp) / length_s
                   : 1;
  const geometry::Rigid2 segment_from_base =
      segment_from_before *
      geometry::Rigid2{part * motion.translation, part * motion.yaw_rad};
  const double segment_height_m =
      keyscans_[after->keyscan].height_m + after->climb_m;
  finder_.Suggest(map_from_base * segment_from_base.Inverse(),
                  height_m - segment_height_m, SegmentWitness::kServer);
  return true;
}

std::vector<TrajectoryPose> LaserSlamOnThread::Trajectory() const {
  std::vector<TrajectoryPose> trajectory;
  trajectory.reserve(places_.size());
  const size_t in_map = is_lost_ ? segment_begin_ : keyscans_.size();
  for (const ScanPlace& place : places_) {
    // While it is in doubt whether it was carried off, it may have been.
    const bool is_in_doubt =
        watch_.in_doubt() &&
        recording::SecondsBetween(place.stamp, watch_.since()) <= kCarried_s;
    const bool is_known =
        !is_in_doubt && (keyscans_.empty() || place.keyscan < in_map);
    const Keyscan keyscan =
        keyscans_.empty() || !is_known ? Keyscan{} : keyscans_[place.keyscan];
    trajectory.push_back(
        {.stamp = place.stamp,
         .map_from_base = keyscan.map_from_base * place.keyscan_from_base,
         .height_m = keyscan.height_m + place.climb_m,
         .level_from_base = place.level_from_base,
         .is_known = is_known});
  }
  return trajectory;
}

}  // namespace

absl::StatusOr<std::unique_ptr<LaserSlam>> LaserSlam::Create(
    const core::RangeSensorInfo& laser, const geometry::Rigid3& base_from_laser,
    const LaserSlamOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (laser.beams < 1 || !std::isfinite(laser.angle_min_rad) ||
      !std::isfinite(laser.angle_increment_rad) || !(laser.range_min_m >= 0) ||
      !geometry::IsFinite(base_from_laser)) {
    return absl::InvalidArgumentError(
        "the laser's geometry or its place on the robot is not sane");
  }
  return std::make_unique<LaserSlamOnThread>(laser, base_from_laser, options);
}

}  // namespace treeline::mapping
