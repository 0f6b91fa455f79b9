#include "evaluation/suites/suite_robot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/processor_time.h"
#include "common/base/status_macros.h"

namespace treeline::suites {
namespace {

// How well a robot knows where it is when it is told.
constexpr localization::PoseCovariance2 kToldCovariance = {
    0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.0025};
constexpr double kFirstBin_ms = 0.25;
constexpr double kStep_ms = 25;
// The laser and the wheels begin to speak.
constexpr int kWarmUpSteps = 8;

}  // namespace

double PlaceRadius_m(const core::RobotModel& robot) {
  return std::ceil(robot.Circumradius_m() / kPlaceCell_m) * kPlaceCell_m;
}

void StepTimes::Add(double step_ms) {
  ++steps;
  total_ms += step_ms;
  highest_ms = std::max(highest_ms, step_ms);
  if (step_ms > kStep_ms) ++missed;
  size_t bin = 0;
  for (double edge_ms = kFirstBin_ms;
       step_ms > edge_ms && bin + 1 < histogram.size(); edge_ms *= 2) {
    ++bin;
  }
  ++histogram[bin];
}

void StepTimes::Add(const StepTimes& other) {
  steps += other.steps;
  missed += other.missed;
  total_ms += other.total_ms;
  highest_ms = std::max(highest_ms, other.highest_ms);
  plans.Add(other.plans);
  for (size_t i = 0; i < histogram.size(); ++i) {
    histogram[i] += other.histogram[i];
  }
}

double StepTimes::Percentile_ms(double share) const {
  int64_t below = 0;
  double edge_ms = kFirstBin_ms;
  for (const int64_t count : histogram) {
    below += count;
    if (static_cast<double>(below) >= share * static_cast<double>(steps)) {
      break;
    }
    edge_ms *= 2;
  }
  return edge_ms;
}

// Renders when the navigator takes a frame.
class SuiteRobot::Camera final : public core::RgbdCamera {
 public:
  explicit Camera(simulator::SimulatedCamera& camera) : camera_(&camera) {}

  camera::RgbdCalibration Calibration() const override {
    return camera_->Calibration();
  }
  std::vector<core::RgbdFrame> TakeFrames() override {
    const double before_ms = base::ThreadProcessorTime_ms();
    // Nobody looks at older ones.
    std::vector<core::RgbdFrame> frames = camera_->TakeNewest();
    rendering_ms_ += base::ThreadProcessorTime_ms() - before_ms;
    return frames;
  }
  core::DeviceHealth Health() const override { return camera_->Health(); }
  // What a real camera would not take of a step's time.
  double TakeRendering_ms() { return std::exchange(rendering_ms_, 0); }

 private:
  simulator::SimulatedCamera* camera_;
  double rendering_ms_ = 0;
};

SuiteRobot::SuiteRobot(const SuitePlace& place) : place_(&place) {}
SuiteRobot::~SuiteRobot() = default;

absl::StatusOr<std::unique_ptr<SuiteRobot>> SuiteRobot::Create(
    const SuitePlace& place, worlds::World world,
    const SuiteRobotOptions& options) {
  std::unique_ptr<SuiteRobot> robot(new SuiteRobot(place));
  simulator::SimulatorOptions simulation;
  simulation.seed = options.seed;
  simulation.start = options.start;
  simulation.sensors.has_rear_laser = true;
  if (options.robot.has_value()) {
    simulation.robot = options.robot->model;
    simulation.sensors.UseLasers(options.robot->lasers);
    if (options.robot->noise.has_value()) {
      simulation.errors.UseNoise(*options.robot->noise,
                                 options.robot->model.wheel_track_m);
    }
  }
  if (!options.has_rear_laser) simulation.sensors.has_rear_laser = false;
  simulation.sensors.camera_hz = options.camera_hz;
  simulation.sensors.camera_scale = options.camera_scale;
  simulation.sensors.camera_is_lit = options.camera_is_lit;
  TL_ASSIGN_OR_RETURN(robot->simulator_, simulator::Simulator::Create(
                                             std::move(world), simulation));
  simulator::Simulator& simulator = *robot->simulator_;
  // Devices say what they are with what they measure first.
  simulator.Step(kWarmUpSteps * kSuiteStep);
  if (options.make_server != nullptr) {
    robot->server_ = options.make_server(simulator.clock());
  }
  behavior::NavigatorDevices devices = {.laser = simulator.laser(),
                                        .odometry = simulator.odometry(),
                                        .base = simulator.base(),
                                        .rear_laser = simulator.rear_laser(),
                                        .camera = nullptr,
                                        .server = robot->server_.get()};
  if (options.camera_hz > 0) {
    robot->camera_ = std::make_unique<Camera>(simulator.camera());
    devices.camera = robot->camera_.get();
  }
  behavior::NavigatorOptions navigator = options.navigator;
  navigator.seed = options.seed;
  navigator.plan_steps = kSuitePlanSteps;
  TL_ASSIGN_OR_RETURN(
      robot->navigator_,
      behavior::Navigator::Create(place.map(), simulation.robot, devices,
                                  navigator, simulator.clock()));
  robot->record_.world = simulator.world().name;
  robot->record_.seed = options.seed;
  robot->record_.track.emplace_back();
  robot->navigator_->Step();
  robot->Record();
  return robot;
}

void SuiteRobot::Step() {
  simulator_->Step(kSuiteStep);
  const double before_ms = base::ThreadProcessorTime_ms();
  navigator_->Step();
  const double took_ms = base::ThreadProcessorTime_ms() - before_ms;
  times_.Add(took_ms - (camera_ == nullptr ? 0 : camera_->TakeRendering_ms()));
  Record();
}

void SuiteRobot::Record() {
  const simulator::TrueState state = simulator_->state();
  for (simulator::SimEvent& event : simulator_->TakeEvents()) {
    if (event.kind == simulator::SimEventKind::kPlaced)
      record_.track.emplace_back();
    record_.events.push_back(std::move(event));
  }
  record_.track.back().push_back(state.world_from_base.translation);
  record_.simulated_s = simulator::Seconds(state.time);
  record_.final_state = state;
  for (behavior::NavigatorEvent& event : navigator_->TakeEvents()) {
    navigator_events_.push_back(std::move(event));
  }
}

StepTimes SuiteRobot::step_times() const {
  StepTimes times = times_;
  times.plans = navigator_->Snapshot().plans;
  return times;
}

absl::Status SuiteRobot::Tell(const core::LevelPose& pose) {
  return navigator_->SetPose(pose, kToldCovariance);
}

std::optional<PoseMiss> SuiteRobot::EstimateError() const {
  const behavior::NavigatorSnapshot snapshot = navigator_->Snapshot();
  if (!snapshot.pose.has_value()) return std::nullopt;
  return place_->ErrorOf(snapshot.pose->pose,
                         simulator_->state().world_from_base);
}

}  // namespace treeline::suites
