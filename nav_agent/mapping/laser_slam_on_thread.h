// Laser SLAM itself: the front end, and what it keeps.
#ifndef NAV_AGENT_MAPPING_LASER_SLAM_ON_THREAD_H_
#define NAV_AGENT_MAPPING_LASER_SLAM_ON_THREAD_H_

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "nav_agent/mapping/between_scans.h"
#include "nav_agent/mapping/carry_watch.h"
#include "nav_agent/mapping/keyscan.h"
#include "nav_agent/mapping/laser_slam.h"
#include "nav_agent/mapping/loop_worker.h"
#include "nav_agent/mapping/odometry_doubt.h"
#include "nav_agent/mapping/segment_finder.h"
#include "nav_agent/mapping/traversed_ground.h"
#include "nav_agent/mapping/window_matcher.h"

namespace treeline::mapping {

// The usual response, of a running mean: where it begins.
inline constexpr double kFirstResponse = 0.7;
// So long before a robot is in doubt it may have been lifted, and so long after
// it was put down it may sway (s).
inline constexpr double kCarried_s = 0.3;

class LaserSlamOnThread final : public LaserSlam {
 public:
  LaserSlamOnThread(const core::RangeSensorInfo& laser,
                    const geometry::Rigid3& base_from_laser,
                    const LaserSlamOptions& options)
      : laser_(laser),
        base_from_laser_(base_from_laser),
        options_(options),
        between_(options.loops.bundle),
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
  void Finish() override;
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
  BetweenScans between_;
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
  // Odometry of the last scan, of the last one that was matched, of the last
  // keyscan, and of the last that is kept for the end.
  geometry::Rigid2 odom_from_last_;
  geometry::Rigid2 odom_from_matched_;
  geometry::Rigid2 odom_from_keyscan_;
  geometry::Rigid2 odom_from_between_;
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

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LASER_SLAM_ON_THREAD_H_
