#include "nav_agent/mapping/laser_slam_on_thread.h"

#include <algorithm>
#include <utility>

#include "nav_agent/mapping/pose_graph.h"

// What a robot asks for that is carried off while it maps: that it is noticed,
// and tied to the map again. The rest is in laser_slam.cc.
namespace treeline::mapping {

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

}  // namespace treeline::mapping
