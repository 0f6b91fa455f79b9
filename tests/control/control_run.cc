#include "tests/control/control_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/geometry/planar_pose.h"

namespace treeline {
namespace {

using std::chrono::milliseconds;

// An error that wanders with a time constant of two seconds.
class Wander {
 public:
  Wander(double error_m, double error_rad, uint64_t seed)
      : random_(seed, 7), error_m_(error_m), error_rad_(error_rad) {}
  void Step() {
    const double keep = std::exp(-0.025 / 2);
    const double kick = std::sqrt(1 - keep * keep);
    off_.translation.x =
        keep * off_.translation.x + kick * error_m_ * random_.NextGaussian();
    off_.translation.y =
        keep * off_.translation.y + kick * error_m_ * random_.NextGaussian();
    off_.yaw_rad =
        keep * off_.yaw_rad + kick * error_rad_ * random_.NextGaussian();
  }
  control::ControlPose Wrong(control::ControlPose pose) const {
    pose.pose.map_from_base.translation =
        pose.pose.map_from_base.translation + off_.translation;
    pose.pose.map_from_base.yaw_rad += off_.yaw_rad;
    return pose;
  }

 private:
  base::Random random_;
  double error_m_;
  double error_rad_;
  geometry::Rigid2 off_;
};

// Counts turning points of a value that differ by more than a threshold.
class SwingCounter {
 public:
  explicit SwingCounter(double threshold) : threshold_(threshold) {}
  void Add(double value) {
    if (rises_ ? value > extreme_ : value < extreme_) extreme_ = value;
    if (std::abs(value - extreme_) > threshold_) {
      rises_ = !rises_;
      extreme_ = value;
      ++swings_;
    }
  }
  int swings() const { return swings_; }

 private:
  double threshold_;
  double extreme_ = 0;
  bool rises_ = true;
  int swings_ = 0;
};

double LengthOf(const std::vector<core::LevelPose>& path) {
  double length_m = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    length_m += Norm(path[i].map_from_base.translation -
                     path[i - 1].map_from_base.translation);
  }
  return length_m;
}

void TakeEvents(simulator::Simulator& simulator, bool traces,
                ControlRunResult& result) {
  for (const simulator::SimEvent& event : simulator.TakeEvents()) {
    if (event.kind == simulator::SimEventKind::kCollision) {
      if (event.caused_by_robot) {
        ++result.collisions_caused;
        result.why += "hit " + event.what + "; ";
      } else {
        ++result.collisions_suffered;
      }
      if (traces) {
        std::printf(
            "  %.2f collision %s caused=%d at %.2f %.2f, robot %.2f "
            "%.2f; robot %.2f m/s, body %.2f m/s\n",
            simulator::Seconds(event.time), event.what.c_str(),
            event.caused_by_robot ? 1 : 0, event.point_in_world.x,
            event.point_in_world.y, event.world_from_base.translation.x,
            event.world_from_base.translation.y, event.robot_approach_mps,
            event.body_approach_mps);
      }
    } else if (event.kind == simulator::SimEventKind::kFall ||
               event.kind == simulator::SimEventKind::kStairs ||
               event.kind == simulator::SimEventKind::kTipped) {
      ++result.falls;
      result.why += std::string(simulator::SimEventName(event.kind)) + "; ";
    }
  }
}

}  // namespace

control::ControlPose TruePose(const ControlWorld& world,
                              const simulator::Simulator& simulator,
                              simulator::SimTime time,
                              const core::BaseReading& reading) {
  const geometry::Rigid3 world_from_base = simulator.WorldFromBaseAt(time);
  const geometry::Rigid2 planar = geometry::PlanarPose(world_from_base);
  control::ControlPose pose;
  pose.stamp = simulator::SimClock::StampOf(time);
  pose.pose = world.PlaceAt(planar.translation, planar.yaw_rad,
                            world_from_base.translation.z);
  pose.level_from_base =
      geometry::Rotation3::FromAxisAngle({0, 0, -planar.yaw_rad}) *
      world_from_base.rotation;
  pose.forward_mps = reading.forward_mps;
  pose.yaw_rate_radps = reading.yaw_rate_radps;
  return pose;
}

ControlRunResult RunControl(const ControlWorld& world,
                            simulator::Simulator& simulator,
                            control::LocalController& controller,
                            const std::vector<core::LevelPose>& first_path,
                            const ControlRunOptions& options) {
  ControlRunResult result;
  result.path_m = LengthOf(first_path);
  Wander wander(options.error_m, options.error_rad, options.seed);
  SwingCounter speeds(0.1);
  SwingCounter turns(0.3);
  core::BaseReading reading;
  std::vector<KeepOut> keep_out;
  const double begin_m = simulator.state().distance_m;
  const simulator::SimTime begin = simulator.now();
  controller.SetPath(first_path);
  double total_ms = 0;
  int steps = 0;
  int still_blocked = 0;
  while (simulator::Seconds(simulator.now() - begin) < options.max_s) {
    if (options.before_step) options.before_step(simulator);
    simulator.Step(milliseconds(25));
    for (const core::BaseReading& next : simulator.odometry().TakeReadings()) {
      reading = next;
    }
    wander.Step();
    const auto from = std::chrono::steady_clock::now();
    for (const core::LaserScan& scan : simulator.laser().TakeScans()) {
      (void)controller.AddScan(
          wander.Wrong(TruePose(world, simulator, scan.stamp.time_since_epoch(),
                                reading)),
          scan);
    }
    const control::ControlPose now =
        wander.Wrong(TruePose(world, simulator, simulator.now(), reading));
    const control::ControlResult step = controller.Step(now);
    const double step_ms =
        base::MillisecondsBetween(from, std::chrono::steady_clock::now());
    total_ms += step_ms;
    ++steps;
    result.longest_step_ms = std::max(result.longest_step_ms, step_ms);
    (void)simulator.base().SetVelocity(step.command);
    speeds.Add(simulator.state().forward_mps);
    turns.Add(simulator.state().yaw_rate_radps);
    if (step.is_stopped_by_guard) result.guarded_s += 0.025;
    if (step.state == control::ControlState::kWaiting) result.waited_s += 0.025;
    TakeEvents(simulator, options.traces, result);
    if (options.traces && steps % 20 == 0) {
      const geometry::Rigid2& at = now.pose.map_from_base;
      std::printf(
          "  %6.2f at %.2f %.2f %.2f L%d z %.2f v %.2f w %.2f cmd %.2f "
          "%.2f state %d guard %d go %.2f obst %.2f %.2f r %.2f\n",
          simulator::Seconds(simulator.now()), at.translation.x,
          at.translation.y, at.yaw_rad, now.pose.place.level,
          now.pose.place.height_m, simulator.state().forward_mps,
          simulator.state().yaw_rate_radps, step.command.forward_mps,
          step.command.yaw_rate_radps, static_cast<int>(step.state),
          step.is_stopped_by_guard ? 1 : 0, step.to_go_m,
          step.obstacle_in_map.x, step.obstacle_in_map.y,
          step.obstacle_radius_m);
    }
    if (simulator.state().is_fallen) break;
    if (step.state == control::ControlState::kArrived) {
      result.arrived = true;
      break;
    }
    still_blocked =
        step.state == control::ControlState::kBlocked ? still_blocked + 1 : 0;
    if (still_blocked == 8) {
      // What a navigator does: another way, with what stands there in mind.
      ++result.times_blocked;
      keep_out.push_back(
          {.center = step.obstacle_in_map, .radius_m = step.obstacle_radius_m});
      std::vector<core::LevelPose> path =
          world.FindPath(now.pose, first_path.back(), 0.42, keep_out);
      if (path.empty()) keep_out.clear();
      if (!path.empty()) controller.SetPath(path);
      still_blocked = -80;
    }
  }
  result.seconds = simulator::Seconds(simulator.now() - begin);
  result.driven_m = simulator.state().distance_m - begin_m;
  const control::ControlPose end =
      TruePose(world, simulator, simulator.now(), reading);
  const geometry::Rigid2& goal = first_path.back().map_from_base;
  result.error_m = Norm(end.pose.map_from_base.translation - goal.translation);
  result.error_rad = std::abs(geometry::NormalizedAngle_rad(
      end.pose.map_from_base.yaw_rad - goal.yaw_rad));
  result.speed_swings = speeds.swings();
  result.turn_swings = turns.swings();
  result.mean_step_ms = steps > 0 ? total_ms / steps : 0;
  return result;
}

}  // namespace treeline
