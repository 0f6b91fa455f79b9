#include "evaluation/lost/lost_suite.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/processor_time.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/localization/scan_points.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"

namespace treeline::lost {
namespace {

constexpr simulator::SimTime kSlice = std::chrono::milliseconds(100);
// Every fourth scan of a laser of 40 Hz.
constexpr double kScanInterval_s = 0.1;
// The middle of a scan after its first beam.
constexpr auto kMiddleOfScan = std::chrono::microseconds(9375);
constexpr double kSettle_s = 8;
constexpr double kWatch_s = 5;
// A robot that lost its place in a drive is told it again after this.
constexpr double kPatience_s = 10;
constexpr double kWander_mps = 0.3;
constexpr double kWander_radps = 0.6;
constexpr localization::PoseCovariance2 kToldCovariance = {
    0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.0025};
constexpr localization::PoseCovariance2 kStartCovariance = {
    0.0625, 0, 0, 0, 0.0625, 0, 0, 0, 0.02};

// Where wheels and the inertial sensor say that the robot is.
class WheelOdometry {
 public:
  explicit WheelOdometry(double wheel_track_m) : track_m_(wheel_track_m) {}

  void Add(const core::BaseReading& reading) {
    if (last_.has_value()) {
      const double left_m = reading.left_wheel_m - last_->left_wheel_m;
      const double right_m = reading.right_wheel_m - last_->right_wheel_m;
      const double turn_rad = (right_m - left_m) / track_m_;
      const double way_m =
          0.5 * (left_m + right_m) * std::cos(reading.pitch_rad);
      odom_from_base_ =
          odom_from_base_ * geometry::Rigid2{{way_m * std::cos(turn_rad / 2),
                                              way_m * std::sin(turn_rad / 2)},
                                             turn_rad};
    }
    last_ = reading;
    // Of 10 ms: the noise of single readings is not tilt.
    pitch_rad_ += kSmoothing * (reading.pitch_rad - pitch_rad_);
    roll_rad_ += kSmoothing * (reading.roll_rad - roll_rad_);
    past_.push_back({reading.stamp, odom_from_base_});
    if (past_.size() > 64) past_.pop_front();
  }

  geometry::Rigid2 At(base::MonotonicTime stamp) const {
    geometry::Rigid2 found = odom_from_base_;
    for (auto it = past_.rbegin(); it != past_.rend(); ++it) {
      found = it->second;
      if (it->first <= stamp) break;
    }
    return found;
  }
  geometry::Rigid2 Now() const { return odom_from_base_; }
  double pitch_rad() const { return pitch_rad_; }
  double roll_rad() const { return roll_rad_; }

 private:
  static constexpr double kSmoothing = 0.2;
  double track_m_;
  std::optional<core::BaseReading> last_;
  geometry::Rigid2 odom_from_base_;
  double pitch_rad_ = 0;
  double roll_rad_ = 0;
  std::deque<std::pair<base::MonotonicTime, geometry::Rigid2>> past_;
};

// A simulated robot with AMCL and the detector.
class LocalizedRobot {
 public:
  static absl::StatusOr<std::unique_ptr<LocalizedRobot>> Create(
      const runs::SuiteWorld& map, const LostRunOptions& options);

  simulator::Simulator& simulator() { return *simulator_; }
  const simulator::TourAction& tour() const { return tour_; }

  // The pose is told to localization, right or wrong.
  absl::Status Tell(const geometry::Rigid2& map_from_base,
                    const localization::PoseCovariance2& covariance, int level);
  absl::Status TellTruth();
  void TellNothing();

  enum class Drive { kTour, kWander, kStand };
  // A slice of time. Adds what was observed.
  absl::Status Step(Drive drive, std::vector<LostSample>& samples);
  absl::Status StepFor(double seconds, Drive drive, const std::stop_token& stop,
                       std::vector<LostSample>& samples);
  bool IsLost() const { return is_lost_; }
  int TrueLevel() const;

  double total_us = 0;
  double highest_us = 0;
  int64_t observed = 0;

 private:
  LocalizedRobot(const runs::SuiteWorld& map, const LostRunOptions& options,
                 std::unique_ptr<simulator::Simulator> simulator,
                 std::vector<localization::Amcl> filters,
                 localization::LostDetector detector);
  absl::Status Place(const geometry::Rigid2& map_from_base,
                     const localization::PoseCovariance2& covariance);
  void DriveOn(Drive drive);
  absl::Status FollowLevel();
  absl::Status Observe(const core::LaserScan& scan,
                       std::vector<LostSample>& samples);

  const runs::SuiteWorld* map_;
  LostRunOptions options_;
  std::unique_ptr<simulator::Simulator> simulator_;
  // One for each level.
  std::vector<localization::Amcl> filters_;
  localization::LostDetector detector_;
  simulator::TourAction tour_;
  std::unique_ptr<simulator::ScenarioPlayer> player_;
  Drive drive_ = Drive::kStand;
  WheelOdometry odometry_;
  base::Random wander_;
  double wander_radps_ = 0;
  int slices_ = 0;
  int level_ = 0;
  // Localization follows the robot from level to level while it knows where it
  // is; that is another piece's task.
  bool follows_level_ = true;
  bool is_lost_ = false;
  bool is_first_ = true;
  base::MonotonicTime told_at_{};
  geometry::Rigid2 map_from_base_;
};

LocalizedRobot::LocalizedRobot(const runs::SuiteWorld& map,
                               const LostRunOptions& options,
                               std::unique_ptr<simulator::Simulator> simulator,
                               std::vector<localization::Amcl> filters,
                               localization::LostDetector detector)
    : map_(&map),
      options_(options),
      simulator_(std::move(simulator)),
      filters_(std::move(filters)),
      detector_(std::move(detector)),
      odometry_(simulator_->options().robot.wheel_track_m),
      wander_(options.seed, 77) {
  tour_.options.repeats = true;
  player_ = std::make_unique<simulator::ScenarioPlayer>(simulator::Scenario(),
                                                        *simulator_);
}

absl::StatusOr<std::unique_ptr<LocalizedRobot>> LocalizedRobot::Create(
    const runs::SuiteWorld& map, const LostRunOptions& options) {
  simulator::Scenario scenario;
  scenario.options.seed = options.seed;
  scenario.options.sensors.laser.scan_interval_s = kScanInterval_s;
  scenario.world = options.world;
  scenario.world_options = {.after_moves = true,
                            .rearranged = options.rearranged,
                            .threads = 1,
                            .paint = false};
  TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<simulator::Simulator> simulator,
      simulator::Simulator::Create(std::move(world), scenario.options));
  // The sensor says what it is with its first scan.
  simulator->Step(2 * kSlice);
  std::vector<localization::Amcl> filters;
  for (const localization::LaserMap& level : map.laser_maps()) {
    TL_ASSIGN_OR_RETURN(
        localization::Amcl amcl,
        localization::Amcl::Create(level.map, options.amcl, options.seed));
    filters.push_back(std::move(amcl));
  }
  TL_ASSIGN_OR_RETURN(
      localization::LostDetector detector,
      localization::LostDetector::Create(
          map.laser_maps()[0], simulator->laser().Info(),
          simulator->options().robot.base_from_laser, options.detector));
  return std::unique_ptr<LocalizedRobot>(
      new LocalizedRobot(map, options, std::move(simulator), std::move(filters),
                         std::move(detector)));
}

int LocalizedRobot::TrueLevel() const {
  return map_->LevelAt(simulator_->state().world_from_base.translation)
      .value_or(level_);
}

absl::Status LocalizedRobot::Tell(
    const geometry::Rigid2& map_from_base,
    const localization::PoseCovariance2& covariance, int level) {
  level_ = level;
  is_first_ = true;
  told_at_ = simulator_->clock().Now();
  follows_level_ = true;
  detector_.Reset();
  TL_RETURN_IF_ERROR(
      detector_.SetMap(map_->laser_maps()[static_cast<size_t>(level_)]));
  return Place(map_from_base, covariance);
}

absl::Status LocalizedRobot::Place(
    const geometry::Rigid2& map_from_base,
    const localization::PoseCovariance2& covariance) {
  localization::Amcl& amcl = filters_[static_cast<size_t>(level_)];
  // What the wheels did while another level's filter was in use is none of its
  // business.
  TL_RETURN_IF_ERROR(amcl.Update(odometry_.Now(), {}).status());
  return amcl.SetPose(map_from_base, covariance);
}

absl::Status LocalizedRobot::TellTruth() {
  return Tell(geometry::PlanarPose(simulator_->state().world_from_base),
              kToldCovariance, TrueLevel());
}

void LocalizedRobot::TellNothing() {
  is_first_ = true;
  told_at_ = simulator_->clock().Now();
  detector_.Reset();
  filters_[static_cast<size_t>(level_)].StartGlobalLocalization();
}

absl::Status LocalizedRobot::FollowLevel() {
  const int level = TrueLevel();
  if (is_lost_) follows_level_ = false;
  if (level == level_ || !follows_level_) return absl::OkStatus();
  level_ = level;
  TL_RETURN_IF_ERROR(
      detector_.SetMap(map_->laser_maps()[static_cast<size_t>(level_)]));
  return Place(map_from_base_, kToldCovariance);
}

absl::Status LocalizedRobot::Observe(const core::LaserScan& scan,
                                     std::vector<LostSample>& samples) {
  const core::RangeSensorInfo info = simulator_->laser().Info();
  const geometry::Rigid3& base_from_laser =
      simulator_->options().robot.base_from_laser;
  TL_ASSIGN_OR_RETURN(const localization::ScanPoints points,
                      localization::PointsAtLaserHeight(
                          scan, info, base_from_laser, odometry_.pitch_rad(),
                          odometry_.roll_rad(), options_.amcl.max_beams,
                          options_.detector.scan));
  const base::MonotonicTime middle = scan.stamp + kMiddleOfScan;
  const geometry::Rigid2 odom_from_base = odometry_.At(middle);
  TL_ASSIGN_OR_RETURN(
      const std::optional<localization::PlanarEstimate> estimate,
      filters_[static_cast<size_t>(level_)].Update(odom_from_base, points));
  if (!estimate.has_value()) return absl::OkStatus();
  map_from_base_ = estimate->map_from_base;
  const double before_us = 1e3 * base::ThreadProcessorTime_ms();
  TL_ASSIGN_OR_RETURN(const localization::LostVerdict verdict,
                      detector_.Observe({.stamp = middle,
                                         .estimate = *estimate,
                                         .odom_from_base = odom_from_base,
                                         .pitch_rad = odometry_.pitch_rad(),
                                         .roll_rad = odometry_.roll_rad()},
                                        scan));
  const double took_us = 1e3 * base::ThreadProcessorTime_ms() - before_us;
  total_us += took_us;
  highest_us = std::max(highest_us, took_us);
  ++observed;
  const simulator::SimTime at = std::chrono::duration_cast<simulator::SimTime>(
      middle - simulator::SimClock::StampOf(simulator::SimTime(0)));
  const geometry::Rigid3 world_from_base = simulator_->WorldFromBaseAt(at);
  const geometry::Rigid2 truth = geometry::PlanarPose(world_from_base);
  const double error_m = Norm(truth.translation - map_from_base_.translation);
  const double error_deg = std::abs(geometry::NormalizedAngle_rad(
                               truth.yaw_rad - map_from_base_.yaw_rad)) *
                           180 / std::numbers::pi;
  is_lost_ = TrueLevel() != level_ || error_m > kLostBeyond_m ||
             error_deg > kLostBeyond_deg;
  samples.push_back({.time_s = static_cast<float>(simulator::Seconds(at)),
                     .log_odds = static_cast<float>(detector_.log_odds()),
                     .error_m = static_cast<float>(error_m),
                     .error_deg = static_cast<float>(error_deg),
                     .position = world_from_base.translation,
                     .is_lost = is_lost_,
                     .is_first = is_first_,
                     .state = verdict.state,
                     .features = verdict.features});
  is_first_ = false;
  return absl::OkStatus();
}

void LocalizedRobot::DriveOn(Drive drive) {
  if (drive == Drive::kTour) {
    if (drive_ != Drive::kTour) player_->DriveTour(tour_);
    player_->Step(kSlice);
  } else {
    core::VelocityCommand command;
    if (drive == Drive::kWander) {
      if (slices_ % 15 == 0) {
        wander_radps_ = wander_.NextUniform(-kWander_radps, kWander_radps);
      }
      command = {.forward_mps = kWander_mps, .yaw_rate_radps = wander_radps_};
    }
    simulator_->base().SetVelocity(command).IgnoreError();
    simulator_->Step(kSlice);
  }
  drive_ = drive;
  ++slices_;
}

absl::Status LocalizedRobot::Step(Drive drive,
                                  std::vector<LostSample>& samples) {
  DriveOn(drive);
  for (const core::BaseReading& reading :
       simulator_->odometry().TakeReadings()) {
    odometry_.Add(reading);
  }
  TL_RETURN_IF_ERROR(FollowLevel());
  for (const core::LaserScan& scan : simulator_->laser().TakeScans()) {
    // What was on its way when it was told a place is of another one.
    if (scan.stamp < told_at_) continue;
    TL_RETURN_IF_ERROR(Observe(scan, samples));
  }
  return absl::OkStatus();
}

absl::Status LocalizedRobot::StepFor(double seconds, Drive drive,
                                     const std::stop_token& stop,
                                     std::vector<LostSample>& samples) {
  const simulator::SimTime until =
      simulator_->now() + simulator::FromSeconds(seconds);
  while (simulator_->now() < until) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    TL_RETURN_IF_ERROR(Step(drive, samples));
  }
  return absl::OkStatus();
}

absl::Status RunDrive(LocalizedRobot& robot, const LostRunOptions& options,
                      const std::function<void(double)>& progress,
                      const std::stop_token& stop, LostRun& run) {
  TL_RETURN_IF_ERROR(robot.TellTruth());
  double lost_s = 0;
  for (double time_s = 0; time_s < options.drive_s;
       time_s += simulator::Seconds(kSlice)) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    TL_RETURN_IF_ERROR(robot.Step(LocalizedRobot::Drive::kTour, run.drive));
    lost_s = robot.IsLost() ? lost_s + simulator::Seconds(kSlice) : 0;
    if (lost_s > kPatience_s) {
      ++run.losses;
      lost_s = 0;
      TL_RETURN_IF_ERROR(robot.TellTruth());
    }
    progress(simulator::Seconds(kSlice));
  }
  return absl::OkStatus();
}

// Which kinds of kidnaps there are, in turn.
KidnapTrial KindOf(int number) {
  KidnapTrial trial;
  const int kind = number % 10;
  trial.drives = number % 2 == 0;
  trial.is_near = kind == 2 || kind == 3 || kind == 6 || kind == 7;
  trial.start = kind < 4   ? KidnapStart::kWarm
                : kind < 8 ? KidnapStart::kCold
                           : KidnapStart::kAnywhere;
  return trial;
}

absl::StatusOr<KidnapTrial> RunTrial(const runs::SuiteWorld& map, int number,
                                     uint64_t seed, const std::stop_token& stop,
                                     LocalizedRobot& robot) {
  KidnapTrial trial = KindOf(number);
  base::Random random(seed, 1000 + static_cast<uint64_t>(number));
  simulator::Simulator& simulator = robot.simulator();
  std::vector<LostSample> settling;
  // Somewhere else first, where localization follows it.
  TL_RETURN_IF_ERROR(runs::CarryAway(map, false, random, simulator));
  TL_RETURN_IF_ERROR(robot.TellTruth());
  TL_RETURN_IF_ERROR(robot.StepFor(kSettle_s,
                                   trial.drives ? LocalizedRobot::Drive::kWander
                                                : LocalizedRobot::Drive::kStand,
                                   stop, settling));
  const geometry::Rigid2 before =
      geometry::PlanarPose(simulator.state().world_from_base);
  const int level = robot.TrueLevel();
  trial.time_s = simulator::Seconds(simulator.now());
  trial.log_odds_before = -1e9;
  for (const LostSample& sample : settling) {
    if (sample.time_s > trial.time_s - 1) {
      trial.log_odds_before =
          std::max<double>(trial.log_odds_before, sample.log_odds);
    }
  }
  TL_RETURN_IF_ERROR(runs::CarryAway(map, trial.is_near, random, simulator));
  const geometry::Rigid2 after =
      geometry::PlanarPose(simulator.state().world_from_base);
  trial.away_m = Norm(after.translation - before.translation);
  trial.turned_deg =
      std::abs(geometry::NormalizedAngle_rad(after.yaw_rad - before.yaw_rad)) *
      180 / std::numbers::pi;
  if (trial.start == KidnapStart::kCold) {
    TL_RETURN_IF_ERROR(robot.Tell(before, kStartCovariance, level));
  } else if (trial.start == KidnapStart::kAnywhere) {
    robot.TellNothing();
  }
  TL_RETURN_IF_ERROR(robot.StepFor(kWatch_s,
                                   trial.drives ? LocalizedRobot::Drive::kWander
                                                : LocalizedRobot::Drive::kStand,
                                   stop, trial.samples));
  return trial;
}

}  // namespace

const char* KidnapStartName(KidnapStart start) {
  switch (start) {
    case KidnapStart::kWarm:
      return "warm";
    case KidnapStart::kCold:
      return "cold";
    case KidnapStart::kAnywhere:
      return "anywhere";
  }
  return "?";
}

double ExpectedSeconds(const LostRunOptions& options) {
  return options.drive_s + options.kidnaps * (kSettle_s + kWatch_s);
}

absl::StatusOr<LostRun> RunLostSuite(
    const runs::SuiteWorld& map, const LostRunOptions& options,
    const std::function<void(double seconds)>& progress,
    const std::stop_token& stop) {
  LostRun run;
  run.world = options.world;
  run.seed = options.seed;
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<LocalizedRobot> robot,
                      LocalizedRobot::Create(map, options));
  run.obstacles = runs::AddObstacles(map, options.new_obstacles, options.seed,
                                     robot->simulator());
  TL_RETURN_IF_ERROR(RunDrive(*robot, options, progress, stop, run));
  for (int i = 0; i < options.kidnaps; ++i) {
    TL_ASSIGN_OR_RETURN(KidnapTrial trial,
                        RunTrial(map, i, options.seed, stop, *robot));
    run.trials.push_back(std::move(trial));
    progress(kSettle_s + kWatch_s);
  }
  run.mean_us = robot->observed > 0
                    ? robot->total_us / static_cast<double>(robot->observed)
                    : 0;
  run.highest_us = robot->highest_us;
  run.simulated_s = simulator::Seconds(robot->simulator().now());
  return run;
}

}  // namespace treeline::lost
