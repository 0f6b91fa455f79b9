#include "nav_agent/mapping/laser_slam.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/processor_time.h"
#include "common/base/status_macros.h"
#include "nav_agent/mapping/laser_slam_on_thread.h"
#include "nav_agent/mapping/scan_plane.h"

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

// How fast the usual response, a running mean, follows.
constexpr double kResponseRate = 0.05;
bool IsTilted(const geometry::Rotation3& level_from_base) {
  return std::hypot(level_from_base.x, level_from_base.y) > 0.5 * kLevel_rad;
}

}  // namespace

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
  std::optional<geometry::Rigid2> way_from_previous;
  if (!Segment().empty()) {
    const Keyscan& previous = keyscans_.back();
    added.previous_from_this =
        previous.map_from_base.Inverse() * map_from_base_;
    way_from_previous = added.previous_from_this;
    added.covariance =
        Turned(covariance_in_map, -previous.map_from_base.yaw_rad);
    added.climb_m = height_m_ - previous.height_m;
    const geometry::Rigid2 motion =
        odom_from_keyscan_.Inverse() * scan.odom_from_base;
    added.odometry = {.previous_from_this = motion,
                      .sigma = doubt_.SigmaOf(motion)};
  }
  keyscans_.push_back({.scan = std::move(outline),
                       .map_from_base = map_from_base_,
                       .height_m = height_m_,
                       .slope = added.slope,
                       .previous_from_this = way_from_previous});
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

void LaserSlamOnThread::Finish() {
  worker_.Finish(options_.polish_rounds);
  ApplyCorrection();
  if (!options_.loops.enabled || options_.polish_rounds == 0) return;
  const size_t in_map = is_lost_ ? segment_begin_ : keyscans_.size();
  between_.Refine(std::span(keyscans_).first(in_map), doubt_,
                  options_.max_gap_m, options_.max_tilt, places_);
}

absl::StatusOr<geometry::Rigid2> LaserSlamOnThread::AddScan(
    const LaserSlamScan& scan) {
  TL_RETURN_IF_ERROR(Check(scan));
  const double start_ms = base::ThreadProcessorTime_ms();
  ApplyCorrection();
  Predict(scan);
  std::shared_ptr<const ScanOutline> outline;
  bool is_keyscan = false;
  bool is_between = false;
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
        is_between = !is_keyscan && has_matched_;
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
  if (outline == nullptr && !keyscans_.empty() &&
      HasMoved(odom_from_between_.Inverse() * scan.odom_from_base,
               options_.between_m, options_.between_rad)) {
    outline = OutlineOf(scan);
    is_between = true;
  }
  statistics_.front_end_ms.push_back(base::ThreadProcessorTime_ms() - start_ms);
  if (is_between) between_.Add(places_.size(), *outline);
  if (is_between || is_keyscan) odom_from_between_ = scan.odom_from_base;
  if (is_keyscan) AddKeyscan(std::move(outline), scan, covariance);
  AddPlace(scan);
  ++statistics_.scans;
  if (is_lost_) LookForSegment(scan.stamp);
  return map_from_base_;
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
