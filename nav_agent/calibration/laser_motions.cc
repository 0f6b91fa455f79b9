#include "nav_agent/calibration/laser_motions.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/calibration/parameters.h"
#include "nav_agent/mapping/scan_outline.h"

namespace treeline::calibration {
namespace {

struct Stretch {
  size_t begin = 0;
  size_t end = 0;
};

bool IsStill(const geometry::Rigid2& motion) {
  return geometry::Norm(motion.translation) < kStillWay_m &&
         std::abs(motion.yaw_rad) < kStillTurn_rad;
}

std::vector<Stretch> FindStretches(const Drive& drive, const WheelPath& path,
                                   const Wheels& wheels) {
  std::vector<Stretch> stretches;
  size_t begin = 0;
  for (size_t i = 1; i < drive.scans.size(); ++i) {
    const double interval_s = drive.scans[i].time_s - drive.scans[i - 1].time_s;
    const double begin_s = drive.scans[begin].time_s;
    const auto motion = path.Motion(begin_s, drive.scans[i].time_s, wheels);
    if (interval_s > drive.longest_gap_s || !motion.has_value() ||
        drive.scans[i].time_s - begin_s >
            std::max(kLongestWindow_s.value, drive.longest_gap_s)) {
      begin = i;
      continue;
    }
    if (IsStill(*motion)) {
      begin = i;
    } else if (geometry::Norm(motion->translation) >= kWindowWay_m ||
               std::abs(motion->yaw_rad) >= kWindowTurn_rad) {
      stretches.push_back({begin, i});
      begin = i;
    }
  }
  return stretches;
}

class Matcher {
 public:
  Matcher(const Drive& drive, const WheelPath& path, const Wheels& wheels)
      : drive_(drive),
        path_(path),
        wheels_(wheels),
        base_from_laser_(geometry::PlanarPose(drive.robot.base_from_laser)) {
    outline_.max_range_m = kMatchRange_m;
  }

  // The stretch's motion, or why there is none.
  enum class Outcome { kMatched, kUnmatched, kDisagreed };
  Outcome Match(const Stretch& stretch, LaserMotion& motion) const {
    const double begin_s = drive_.scans[stretch.begin].time_s;
    const double end_s = drive_.scans[stretch.end].time_s;
    const mapping::ScanOutline begin = Outline(stretch.begin);
    const mapping::ScanOutline end = Outline(stretch.end);
    const geometry::Rigid2 guess = ByWheels(begin_s, end_s);
    const auto there = MatchOne(begin, end, guess);
    if (!there) return Outcome::kUnmatched;
    const auto back = MatchOne(end, begin, guess.Inverse());
    if (!back) return Outcome::kUnmatched;
    const geometry::Rigid2 inverse = back->target_from_scan.Inverse();
    const geometry::Rigid2 apart = there->target_from_scan.Inverse() * inverse;
    if (geometry::Norm(apart.translation) > kAgree_m ||
        std::abs(apart.yaw_rad) > kAgree_rad) {
      return Outcome::kDisagreed;
    }
    motion = {.begin_s = begin_s,
              .end_s = end_s,
              .begin_from_end = there->target_from_scan *
                                geometry::Rigid2{0.5 * apart.translation,
                                                 0.5 * apart.yaw_rad},
              .covariance = there->covariance,
              .disagreement = apart};
    motion.covariance[0] += kMatchNoise_m * kMatchNoise_m;
    motion.covariance[4] += kMatchNoise_m * kMatchNoise_m;
    motion.covariance[8] += kMatchNoise_rad * kMatchNoise_rad;
    return Outcome::kMatched;
  }

 private:
  geometry::Rigid2 ByWheels(double begin_s, double end_s) const {
    const auto motion = path_.Motion(begin_s, end_s, wheels_);
    return base_from_laser_.Inverse() * motion.value_or(geometry::Rigid2{}) *
           base_from_laser_;
  }

  // In the laser's frame.
  mapping::ScanOutline Outline(size_t scan) const {
    const double begin_s = drive_.scans[scan].time_s;
    const double turn_s =
        drive_.laser.beam_interval_s * (drive_.laser.beams - 1);
    return mapping::MakeScanOutline(drive_.scans[scan].ranges_m, drive_.laser,
                                    {}, outline_,
                                    ByWheels(begin_s, begin_s + turn_s));
  }

  std::optional<mapping::ScanMatch> MatchOne(
      const mapping::ScanOutline& reference, const mapping::ScanOutline& scan,
      const geometry::Rigid2& guess) const {
    constexpr size_t kMinPoints = 20;
    if (reference.size() < kMinPoints || scan.size() < kMinPoints) {
      return std::nullopt;
    }
    const mapping::PlacedScan placed[] = {
        {.scan = &reference, .target_from_scan = {}}};
    mapping::MatchSearch search;
    search.half_extent_m = kSearchWay_m;
    search.half_angle_rad = kSearchTurn_rad;
    const mapping::SurfaceGrid grid =
        mapping::MakeSurfaceGrid(placed, scan, guess, search, options_);
    const mapping::ScanMatch match =
        mapping::MatchScan(grid, scan, guess, search, options_);
    if (match.response < kMinResponse || match.is_at_border) {
      return std::nullopt;
    }
    return match;
  }

  const Drive& drive_;
  const WheelPath& path_;
  const Wheels wheels_;
  const geometry::Rigid2 base_from_laser_;
  mapping::ScanOutlineOptions outline_;
  const mapping::ScanMatcherOptions options_;
};

absl::Status TooFew(const LaserMotions& found) {
  if (found.stretches < kMinMotions) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the drive has ", found.stretches,
        " stretches of half a metre or 20 degrees in which scans and wheels "
        "are there; ",
        kMinMotions.value,
        " are needed, and 200 are good: drive for some minutes, straight "
        "ahead and in turns both ways"));
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "of ", found.stretches, " stretches of the drive only ",
      found.motions.size(), " have scans that match (", found.unmatched,
      " do not, ", found.disagreed,
      " differ there and back): drive where walls and furniture are within "
      "range, slower; or the laser is mounted upside down, or odometry and "
      "scans are not of the same drive"));
}

}  // namespace

absl::StatusOr<LaserMotions> MeasureLaserMotions(const Drive& drive,
                                                 const WheelPath& path,
                                                 const std::stop_token& stop) {
  const Wheels wheels = {.track_m = drive.robot.wheel_track_m};
  const std::vector<Stretch> stretches = FindStretches(drive, path, wheels);
  const Matcher matcher(drive, path, wheels);
  LaserMotions found;
  const size_t step = 1 + stretches.size() / (kMaxMotions.value + 1);
  for (size_t i = 0; i < stretches.size(); i += step) {
    if (stop.stop_requested()) return absl::CancelledError("interrupted");
    ++found.stretches;
    LaserMotion motion;
    switch (matcher.Match(stretches[i], motion)) {
      case Matcher::Outcome::kMatched:
        found.motions.push_back(motion);
        break;
      case Matcher::Outcome::kUnmatched:
        ++found.unmatched;
        break;
      case Matcher::Outcome::kDisagreed:
        ++found.disagreed;
        break;
    }
  }
  if (found.motions.size() < static_cast<size_t>(kMinMotions)) {
    return TooFew(found);
  }
  return found;
}

}  // namespace treeline::calibration
