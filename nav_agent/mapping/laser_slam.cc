#include "nav_agent/mapping/laser_slam.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/mapping/loop_worker.h"

namespace treeline {
namespace {

bool IsFinitePose(const Rigid2& pose) {
  return std::isfinite(pose.translation.x) &&
         std::isfinite(pose.translation.y) && std::isfinite(pose.yaw_rad);
}

bool HasMoved(const Rigid2& motion, double length_m, double angle_rad) {
  return Norm(motion.translation) >= length_m ||
         std::abs(motion.yaw_rad) >= angle_rad;
}

struct Keyscan {
  std::shared_ptr<const ScanPoints> scan;
  Rigid2 map_from_base;
};

// A scan's place, tied to the keyscan before it so that it moves with it.
struct ScanPlace {
  RecordingTime stamp;
  size_t keyscan = 0;
  Rigid2 keyscan_from_base;
};

class LaserSlamOnThread final : public LaserSlam {
 public:
  LaserSlamOnThread(const RangeSensorInfo& laser, const Rigid3& base_from_laser,
                    const LaserSlamOptions& options)
      : laser_(laser),
        base_from_laser_(base_from_laser),
        options_(options),
        worker_(LoopCloser(options.loops, options.matcher, options.graph),
                options.synchronous) {}

  absl::StatusOr<Rigid2> AddScan(const LaserSlamScan& scan) override;
  void Finish() override {
    worker_.Finish(options_.polish_rounds);
    ApplyCorrection();
  }
  std::vector<TrajectoryPose> Trajectory() const override;
  LaserSlamStatistics Statistics() const override {
    LaserSlamStatistics statistics = statistics_;
    statistics.keyscans = static_cast<int64_t>(keyscans_.size());
    statistics.loops = worker_.Statistics();
    return statistics;
  }

 private:
  absl::Status Check(const LaserSlamScan& scan) const;
  void ApplyCorrection();
  // Finds the robot, from a prediction; false: odometry has to do.
  bool Match(const ScanPoints& scan, const MatchSearch& search,
             Covariance3* covariance);
  MatchSearch SearchAfter(const Rigid2& motion) const;
  void AddKeyscan(std::shared_ptr<const ScanPoints> scan,
                  const Covariance3& covariance_in_map);

  const RangeSensorInfo laser_;
  const Rigid3 base_from_laser_;
  const LaserSlamOptions options_;
  SteadyClock clock_;
  std::vector<Keyscan> keyscans_;
  std::vector<ScanPlace> places_;
  Rigid2 map_from_base_;
  // Odometry of the last scan, of the last one that was matched, and of the
  // last keyscan.
  Rigid2 odom_from_last_;
  Rigid2 odom_from_matched_;
  Rigid2 odom_from_keyscan_;
  LaserSlamStatistics statistics_;
  LoopWorker worker_;
};

absl::Status LaserSlamOnThread::Check(const LaserSlamScan& scan) const {
  if (static_cast<int>(scan.ranges_m.size()) != laser_.beams) {
    return absl::InvalidArgumentError(
        absl::StrCat("a scan of ", scan.ranges_m.size(), " beams from a laser",
                     " of ", laser_.beams));
  }
  const Rotation3& q = scan.level_from_base;
  if (!IsFinitePose(scan.odom_from_base) ||
      !IsFinite(Rigid3{.rotation = q, .translation = {}})) {
    return absl::InvalidArgumentError("a scan at a pose that is not finite");
  }
  if (!places_.empty() && scan.stamp < places_.back().stamp) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the clock jumped back by %.3f s",
        SecondsBetween(scan.stamp, places_.back().stamp)));
  }
  return absl::OkStatus();
}

void LaserSlamOnThread::ApplyCorrection() {
  const auto corrected = worker_.TakeCorrection();
  if (!corrected.has_value() || corrected->empty()) return;
  const size_t known = corrected->size();
  // What came later moves with the last one that was corrected.
  const Rigid2 new_from_old = corrected->back() *
                              keyscans_[known - 1].map_from_base.Inverse();
  for (size_t i = 0; i < keyscans_.size(); ++i) {
    Rigid2& map_from_base = keyscans_[i].map_from_base;
    map_from_base = i < known ? (*corrected)[i] : new_from_old * map_from_base;
  }
  map_from_base_ = new_from_old * map_from_base_;
}

MatchSearch LaserSlamOnThread::SearchAfter(const Rigid2& motion) const {
  const double moved_m = Norm(motion.translation);
  const double turned_rad = std::abs(motion.yaw_rad);
  const double sigma_m = options_.odometry_m +
                         options_.odometry_m_per_m * moved_m +
                         options_.odometry_m_per_rad * turned_rad;
  const double sigma_rad = options_.odometry_rad +
                           options_.odometry_rad_per_rad * turned_rad +
                           options_.odometry_rad_per_m * moved_m;
  return {.half_extent_m =
              std::min(options_.search_sigmas * sigma_m, options_.max_search_m),
          .half_angle_rad = std::min(options_.search_sigmas * sigma_rad,
                                     options_.max_search_rad),
          .guess_sigma_m = sigma_m,
          .guess_sigma_rad = sigma_rad};
}

bool LaserSlamOnThread::Match(const ScanPoints& scan, const MatchSearch& search,
                              Covariance3* covariance) {
  if (static_cast<int>(scan.size()) < options_.min_points) return false;
  std::vector<PlacedScan> references;
  const size_t count =
      std::min(keyscans_.size(), static_cast<size_t>(options_.window));
  for (size_t i = keyscans_.size() - count; i < keyscans_.size(); ++i) {
    references.push_back({.scan = keyscans_[i].scan.get(),
                          .target_from_scan = keyscans_[i].map_from_base});
  }
  const SurfaceGrid grid = MakeSurfaceGrid(references, scan, map_from_base_,
                                           search, options_.matcher);
  const ScanMatch match =
      MatchScan(grid, scan, map_from_base_, search, options_.matcher);
  if (match.response < options_.min_response) return false;
  map_from_base_ = match.target_from_scan;
  *covariance = match.covariance;
  return true;
}

void LaserSlamOnThread::AddKeyscan(std::shared_ptr<const ScanPoints> scan,
                                   const Covariance3& covariance_in_map) {
  KeyscanJob job;
  job.scan = scan;
  if (!keyscans_.empty()) {
    const Rigid2& map_from_previous = keyscans_.back().map_from_base;
    job.previous_from_this = map_from_previous.Inverse() * map_from_base_;
    job.covariance = Turned(covariance_in_map, -map_from_previous.yaw_rad);
  }
  keyscans_.push_back(
      {.scan = std::move(scan), .map_from_base = map_from_base_});
  worker_.Add(std::move(job));
}

absl::StatusOr<Rigid2> LaserSlamOnThread::AddScan(const LaserSlamScan& scan) {
  TL_RETURN_IF_ERROR(Check(scan));
  const MonotonicTime start = clock_.Now();
  ApplyCorrection();
  const Rigid3 level_from_laser =
      Rigid3{.rotation = scan.level_from_base, .translation = {}} *
      base_from_laser_;
  const Rigid2& odom_from_base = scan.odom_from_base;
  auto points = std::make_shared<const ScanPoints>(MakeScanPoints(
      scan.ranges_m, laser_, level_from_laser, options_.points));
  bool is_keyscan = keyscans_.empty() && !points->empty();
  Covariance3 covariance{};
  if (!places_.empty()) {
    map_from_base_ =
        map_from_base_ * (odom_from_last_.Inverse() * odom_from_base);
  }
  if (!keyscans_.empty()) {
    const Rigid2 since_match = odom_from_matched_.Inverse() * odom_from_base;
    const Rigid2 since_keyscan = odom_from_keyscan_.Inverse() * odom_from_base;
    const bool far =
        HasMoved(since_keyscan, options_.keyscan_m, options_.keyscan_rad);
    if (far || HasMoved(since_match, options_.still_m, options_.still_rad)) {
      if (Match(*points, SearchAfter(since_match), &covariance)) {
        odom_from_matched_ = odom_from_base;
      } else {
        ++statistics_.unmatched;
        const MatchSearch odometry = SearchAfter(since_keyscan);
        covariance[0] = covariance[4] =
            odometry.guess_sigma_m * odometry.guess_sigma_m;
        covariance[8] = odometry.guess_sigma_rad * odometry.guess_sigma_rad;
      }
    }
    is_keyscan = far;
  }
  odom_from_last_ = odom_from_base;
  statistics_.front_end_ms.push_back(
      MillisecondsBetween(start, clock_.Now()));
  if (is_keyscan) {
    odom_from_keyscan_ = odom_from_base;
    odom_from_matched_ = odom_from_base;
    AddKeyscan(std::move(points), covariance);
  }
  ScanPlace place = {.stamp = scan.stamp,
                     .keyscan_from_base = map_from_base_};
  if (!keyscans_.empty()) {
    place.keyscan = keyscans_.size() - 1;
    place.keyscan_from_base =
        keyscans_.back().map_from_base.Inverse() * map_from_base_;
  }
  places_.push_back(place);
  ++statistics_.scans;
  return map_from_base_;
}

std::vector<TrajectoryPose> LaserSlamOnThread::Trajectory() const {
  std::vector<TrajectoryPose> trajectory;
  trajectory.reserve(places_.size());
  for (const ScanPlace& place : places_) {
    const Rigid2 map_from_keyscan =
        keyscans_.empty() ? Rigid2{} : keyscans_[place.keyscan].map_from_base;
    trajectory.push_back(
        {.stamp = place.stamp,
         .map_from_base = map_from_keyscan * place.keyscan_from_base});
  }
  return trajectory;
}

}  // namespace

absl::Status LaserSlamOptions::Validate() const {
  TL_RETURN_IF_ERROR(points.Validate());
  TL_RETURN_IF_ERROR(matcher.Validate());
  TL_RETURN_IF_ERROR(loops.Validate());
  const bool lengths = keyscan_m > 0 && keyscan_rad > 0 && still_m > 0 &&
                       still_rad > 0 && max_search_m > 0 &&
                       max_search_rad > 0 && search_sigmas > 0;
  const bool odometry = odometry_m > 0 && odometry_rad > 0 &&
                        odometry_m_per_m >= 0 && odometry_m_per_rad >= 0 &&
                        odometry_rad_per_rad >= 0 && odometry_rad_per_m >= 0;
  if (!lengths || !odometry || window < 1 || min_points < 3 ||
      polish_rounds < 0 || !(graph.kernel_sigmas > 0) ||
      graph.max_iterations < 1 || !(max_search_m <= 20)) {
    return absl::InvalidArgumentError(
        "laser SLAM: lengths, angles, counts and what odometry may be wrong "
        "by must be above 0, max_search_m at most 20");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<LaserSlam>> LaserSlam::Create(
    const RangeSensorInfo& laser, const Rigid3& base_from_laser,
    const LaserSlamOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (laser.beams < 1 || !std::isfinite(laser.angle_min_rad) ||
      !std::isfinite(laser.angle_increment_rad) ||
      !(laser.range_min_m >= 0) || !IsFinite(base_from_laser)) {
    return absl::InvalidArgumentError(
        "the laser's geometry or its place on the robot is not sane");
  }
  return std::make_unique<LaserSlamOnThread>(laser, base_from_laser, options);
}

}  // namespace treeline
