#include "nav_agent/behavior/fix_checker.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/pose_lists.h"
#include "nav_agent/behavior/seen_through.h"

namespace treeline::behavior {
namespace {

bool AreSamePlace(const core::LevelPose& a, const core::LevelPose& b) {
  return Distance_m(a, b) < kSamePlace_m &&
         HeadingOff_rad(a, b) < kSamePlace_rad &&
         std::abs(a.place.height_m - b.place.height_m) < kSamePlace_m;
}

// The fit of the newest scan where the robot thought it was, if that is
// elsewhere.
std::optional<localization::ScanFit> FitAtBelief(
    const localization::RobotTracker& tracker, const core::LevelPose& fitted) {
  const auto stamp = tracker.ScanStamp();
  const auto belief = stamp.has_value() ? tracker.PoseAt(*stamp) : std::nullopt;
  if (!belief.has_value() || AreSamePlace(belief->pose, fitted)) {
    return std::nullopt;
  }
  return tracker.FitAt(belief->pose);
}

// From the frame's moment to the scan's, by the wheels.
geometry::Rigid2 FrameFromScan(const localization::RobotTracker& tracker,
                               const GatedFix& fix) {
  const auto stamp = tracker.ScanStamp();
  if (!stamp.has_value()) return {};
  const auto then = tracker.MotionAt(*stamp);
  if (!then.has_value()) return {};
  return fix.motion.odom_from_base.Inverse() * then->odom_from_base;
}

}  // namespace

GatedFix FixChecker::Check(const core::RelocalizationAnswer& answer,
                           const localization::TrackedMotion& motion,
                           const localization::RobotTracker& tracker) const {
  GatedFix fix;
  fix.motion = motion;
  fix.confidence = answer.confidence;
  fix.log_odds = LogOddsOf(answer.confidence);
  fix.is_server_sure = IsServerSure(answer, options_);
  FixWitnesses judging_particles;
  // True if the fix is refused by what was said so far.
  const auto is_refused = [&] {
    FixJudgement judgement = JudgeFix(answer, judging_particles, options_);
    fix.verdict = judgement.verdict;
    fix.why = std::move(judgement.why);
    return IsRefused(fix.verdict);
  };
  if (is_refused()) return fix;
  const geometry::Rigid3 map_from_base =
      answer.map_from_camera * robot_.base_from_camera.Inverse();
  judging_particles.tilt_error_rad =
      TiltError_rad(map_from_base.rotation, motion.level_from_base);
  if (is_refused()) return fix;
  const geometry::Vec3& at = map_from_base.translation;
  const geometry::Vec3 ahead = map_from_base.rotation * geometry::Vec3{1, 0, 0};
  fix.pose.map_from_base = {{at.x, at.y}, std::atan2(ahead.y, ahead.x)};
  fix.covariance = FixCovariance(answer.covariance);
  judging_particles.ground = AskMap(at, tracker, fix);
  if (is_refused()) return fix;
  judging_particles.scan = AskLaser(tracker, fix);
  is_refused();
  return fix;
}

GroundWitness FixChecker::AskMap(const geometry::Vec3& base_in_map,
                                 const localization::RobotTracker& tracker,
                                 GatedFix& fix) const {
  const geometry::Vec2 at = {base_in_map.x, base_in_map.y};
  const auto off_m = [&base_in_map](const core::LevelPlace& place) {
    return std::abs(place.height_m - base_in_map.z);
  };
  std::optional<core::LevelPlace> ground;
  for (int level = 0; level < map_->levels(); ++level) {
    const auto place = map_->GroundOf(at, level);
    if (!place.has_value() ||
        map_->Clearance_m(level, at) < options_.min_clearance_m) {
      continue;
    }
    if (!ground.has_value() || off_m(*place) < off_m(*ground)) ground = place;
  }
  GroundWitness witness = {.base_in_map = base_in_map, .ground_m = {}};
  if (!ground.has_value() || off_m(*ground) > options_.max_height_error_m) {
    for (int level = 0; level < map_->levels(); ++level) {
      const auto place = GroundAmongGhosts(level, base_in_map, tracker, fix);
      if (!place.has_value()) continue;
      ground = place;
      witness.is_seen_through = true;
      break;
    }
  }
  if (ground.has_value()) {
    witness.ground_m = ground->height_m;
    fix.pose.place = *ground;
  }
  return witness;
}

std::optional<core::LevelPlace> FixChecker::GroundAmongGhosts(
    int level, const geometry::Vec3& base_in_map,
    const localization::RobotTracker& tracker, const GatedFix& fix) const {
  const core::OccupancyGrid& grid = map_->grid(level);
  const geometry::Vec2 at = {base_in_map.x, base_in_map.y};
  const core::CellIndex middle = grid.CellOf(at);
  const int reach = static_cast<int>(kGhostReach_m / map_->resolution_m());
  std::optional<core::LevelPlace> nearest;
  double nearest_m = kGhostReach_m;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      if (!grid.Contains({x, y}) || !map_->IsFree(level, {x, y})) continue;
      const geometry::Vec2 center = grid.CenterInMap({x, y});
      const double far_m = geometry::Norm(center - at);
      const auto place = map_->GroundOf(center, level);
      if (far_m >= nearest_m || !place.has_value() ||
          std::abs(place->height_m - base_in_map.z) >
              options_.max_height_error_m) {
        continue;
      }
      nearest = place;
      nearest_m = far_m;
    }
  }
  if (!nearest.has_value()) return std::nullopt;
  const std::vector<geometry::Vec2> ends = tracker.ScanInBase();
  const geometry::Vec3& laser = robot_.base_from_laser.translation;
  const ScanFromPlace scan = {
      .map_from_base = fix.pose.map_from_base * FrameFromScan(tracker, fix),
      .laser_in_base = {laser.x, laser.y},
      .ends_in_base = ends};
  if (!IsSeenThrough(*map_, level, scan, options_.min_clearance_m, robot_)) {
    return std::nullopt;
  }
  return nearest;
}

ScanWitness FixChecker::AskLaser(const localization::RobotTracker& tracker,
                                 GatedFix& fix) const {
  const geometry::Rigid2 frame_from_scan = FrameFromScan(tracker, fix);
  core::LevelPose begin = fix.pose;
  begin.map_from_base = fix.pose.map_from_base * frame_from_scan;
  const std::optional<localization::ScanFit> here = tracker.FitAt(begin);
  if (!here.has_value()) return {};
  const std::array<localization::FitStep, 2> passes = {
      {{.m = options_.search_m * 2 / 3, .rad = options_.search_rad * 2 / 3},
       {.m = options_.search_m / 3, .rad = options_.search_rad / 3}}};
  const localization::FittedPose best = localization::RefineFit(
      {.pose = begin, .fit = *here, .score = localization::FitScore(*here)},
      passes, 1e-9,
      [&tracker](const core::LevelPose& pose) { return tracker.FitAt(pose); },
      [&begin](const core::LevelPose& pose, const localization::ScanFit& fit) {
        const double moved_m = geometry::Norm(pose.map_from_base.translation -
                                              begin.map_from_base.translation);
        const double turned_rad = std::abs(geometry::NormalizedAngle_rad(
            pose.map_from_base.yaw_rad - begin.map_from_base.yaw_rad));
        return localization::FitScore(fit) - kFitMoveCost_per_m * moved_m -
               kFitTurnCost_per_rad * turned_rad;
      });
  fix.fit = best.fit;
  fix.pose.map_from_base = best.pose.map_from_base * frame_from_scan.Inverse();
  return {.at_fix = best.fit, .at_belief = FitAtBelief(tracker, best.pose)};
}

}  // namespace treeline::behavior
