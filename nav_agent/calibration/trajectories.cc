#include "nav_agent/calibration/trajectories.h"

#include "nav_agent/calibration/wheel_path.h"

namespace treeline::calibration {
namespace {

geometry::Rigid2 ByWheels(const WheelPath& path, const Setup& setup,
                          double begin_s, double end_s) {
  return path
      .Motion(begin_s - setup.laser_delay_s, end_s - setup.laser_delay_s,
              setup.wheels)
      .value_or(geometry::Rigid2{});
}

}  // namespace

Trajectories TrajectoriesOf(const Drive& drive,
                            const Calibration& calibration) {
  const WheelPath path(drive.readings, drive.longest_gap_s);
  const geometry::Rigid2& mount = calibration.found.base_from_laser;
  Trajectories all;
  geometry::Rigid2 before;
  geometry::Rigid2 after;
  geometry::Rigid2 by_scans;
  double now_s = calibration.motions.empty()
                     ? 0
                     : calibration.motions.front().laser.begin_s;
  for (const CheckedMotion& checked : calibration.motions) {
    const LaserMotion& laser = checked.laser;
    before = before * ByWheels(path, calibration.assumed, now_s, laser.end_s);
    after = after * ByWheels(path, calibration.found, now_s, laser.end_s);
    by_scans = by_scans *
               ByWheels(path, calibration.found, now_s, laser.begin_s) * mount *
               laser.begin_from_end * mount.Inverse();
    now_s = laser.end_s;
    all.before.push_back(before.translation);
    all.after.push_back(after.translation);
    all.by_scans.push_back(by_scans.translation);
  }
  return all;
}

}  // namespace treeline::calibration
