// A robot of ROS 2 that is known over DDS alone: a simulated one, in a world of
// the simulator, that publishes what its sensors say and drives as /cmd_vel
// says. A person with a remote control (the tour) and RViz (goals) are played,
// too.
//
//   simulated_robot DOMAIN WORLD PACE CAMERA_HZ [plain]
//
// PACE: simulated seconds in a real one; time is told on /clock. 0: real time,
// with stamps of the system's clock and without /clock. plain: one laser of 541
// beams at 20 Hz, instead of two of which one has 1081 at 40 Hz.
//
// Lines on standard input:
//   tour                     drives the world's tour, once
//   kidnap X Y YAW           is elsewhere in the world (m, rad)
//   goal X Y YAW             somebody clicks a goal, there in the world
//   place X Y YAW            somebody clicks an initial pose
//   silence TOPIC SECONDS    scan, odom or clock says nothing for so long
//   jump SECONDS             the clock that stamps are of is set ahead by so
//   much nonsense                 a scan and an odometry that are none
// On standard output, twice a second, a line of key=value that tests wait for.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/camera/camera.h"
#include "common/geometry/planar_pose.h"
#include "common/image/decode.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "simulation/simulator/paced_runner.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/simulator.h"

namespace treeline {
namespace {

using simulator::SimTime;

// Of simulated time: between two looks at what is to be published.
constexpr SimTime kStep = std::chrono::milliseconds(5);
// ROS 2's simulations publish /clock about so often.
constexpr SimTime kClockInterval = std::chrono::milliseconds(10);
constexpr SimTime kSteerInterval = std::chrono::milliseconds(50);
// A simulation's clock begins somewhere.
constexpr int64_t kClockBegins_ns = 1'000'000'000'000;

// What the test's input says, line by line.
class Orders {
 public:
  Orders()
      : thread_([this] {
          std::string line;
          while (std::getline(std::cin, line)) {
            const absl::MutexLock lock(&mutex_);
            lines_.push_back(line);
          }
          const absl::MutexLock lock(&mutex_);
          is_over_ = true;
        }) {}
  ~Orders() { thread_.detach(); }

  std::vector<std::string> Take() {
    const absl::MutexLock lock(&mutex_);
    return std::exchange(lines_, {});
  }
  bool is_over() {
    const absl::MutexLock lock(&mutex_);
    return is_over_;
  }

 private:
  absl::Mutex mutex_;
  std::vector<std::string> lines_ ABSL_GUARDED_BY(mutex_);
  bool is_over_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

class SimulatedRobot {
 public:
  SimulatedRobot(dds::Node& node, std::unique_ptr<simulator::Simulator> robot,
                 double pace, bool has_camera)
      : node_(node),
        robot_(std::move(robot)),
        map_from_world_(
            geometry::PlanarPose(robot_->state().world_from_base).Inverse()),
        has_clock_(pace > 0),
        has_camera_(has_camera),
        pace_(has_clock_ ? pace : 1) {}

  void Run() {
    Advertise();
    Orders orders;
    auto next_status = std::chrono::steady_clock::now();
    while (!orders.is_over()) {
      for (const std::string& line : orders.Take()) waiting_.push_back(line);
      while (!waiting_.empty() && CanObey(waiting_.front())) {
        Obey(waiting_.front());
        waiting_.pop_front();
      }
      const base::MonotonicTime now = real_clock_.Now();
      if (pace_.Due(now) >= kStep) {
        Step();
      } else {
        node_.Wait(std::chrono::milliseconds(1));
      }
      TakeMessages();
      if (now >= next_status) {
        next_status = now + std::chrono::milliseconds(500);
        Tell();
      }
    }
  }

 private:
  template <typename M>
  std::unique_ptr<dds::Publisher> Make(const std::string& topic,
                                       const dds::Quality& quality) {
    return node_.Advertise(topic, M::kName, quality).value();
  }
  template <typename M>
  std::unique_ptr<dds::Subscription> Hear(const std::string& topic,
                                          const dds::Quality& quality) {
    return node_.Subscribe(topic, M::kName, quality).value();
  }
  template <typename M>
  static void Send(dds::Publisher& publisher, const M& message) {
    if (!publisher.Publish(messages::Encode(message)).ok()) std::abort();
  }
  // The newest message, if one has come.
  template <typename M>
  static std::optional<M> Newest(dds::Subscription& subscription) {
    const std::vector<dds::Sample> samples = subscription.Take();
    if (samples.empty()) return std::nullopt;
    return messages::Decode<M>(samples.back().bytes).value();
  }

  void Advertise();
  void Step();
  void Steer();
  void PublishSensors();
  void PublishOdometry(const core::BaseReading& reading);
  void PublishFrame(const core::RgbdFrame& frame);
  void TakeMessages();
  // Who clicks looks whether anybody listens.
  bool CanObey(const std::string& line) const {
    if (line.starts_with("goal")) return goal_->matched() > 0;
    if (line.starts_with("place")) return initial_pose_->matched() > 0;
    return true;
  }
  void Obey(const std::string& line);
  void SendNonsense();
  void Tell();

  // As a stamp: by /clock, or by the system's clock.
  messages::Time StampOf(base::MonotonicTime measured) const {
    const int64_t sim_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                               measured.time_since_epoch())
                               .count();
    return messages::TimeOf(sim_ns + shift_ns_ + jump_ns_);
  }
  messages::Header HeaderOf(base::MonotonicTime measured,
                            const std::string& frame) const {
    return {.stamp = StampOf(measured), .frame_id = frame};
  }
  bool IsSilent(const std::string& topic) const {
    const auto until = silent_until_.find(topic);
    return until != silent_until_.end() && robot_->now() < until->second;
  }
  geometry::Rigid2 TrueMapFromBase() const {
    return map_from_world_ *
           geometry::PlanarPose(robot_->state().world_from_base);
  }
  messages::Pose InMap(double x_m, double y_m, double yaw_rad) const {
    const geometry::Rigid2 place =
        map_from_world_ * geometry::Rigid2{{x_m, y_m}, yaw_rad};
    return conversions::PoseOf(
        {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, place.yaw_rad}),
         .translation = {place.translation.x, place.translation.y, 0}});
  }

  dds::Node& node_;
  const base::SteadyClock real_clock_;
  const std::unique_ptr<simulator::Simulator> robot_;
  // Maps begin where their drive began.
  const geometry::Rigid2 map_from_world_;
  const bool has_clock_;
  const bool has_camera_;
  simulator::Pace pace_;
  int64_t shift_ns_ = kClockBegins_ns;
  int64_t jump_ns_ = 0;
  SimTime next_clock_{0};
  SimTime next_steering_{0};
  std::deque<std::string> waiting_;
  std::map<std::string, SimTime> silent_until_;
  std::unique_ptr<simulator::TourDriver> tour_;
  // ---- wheels ----
  std::optional<core::BaseReading> last_reading_;
  geometry::Rigid2 odom_from_base_;
  // ---- what was heard ----
  core::VelocityCommand command_;
  int64_t commands_ = 0;
  std::optional<messages::PoseWithCovarianceStamped> place_;
  std::optional<messages::TFMessage> frames_;
  std::map<std::string, std::string> diagnostics_;
  size_t map_cells_ = 0;
  size_t plan_poses_ = 0;
  std::unique_ptr<dds::Publisher> clock_;
  std::unique_ptr<dds::Publisher> static_frames_;
  std::unique_ptr<dds::Publisher> odom_;
  std::unique_ptr<dds::Publisher> scan_;
  std::unique_ptr<dds::Publisher> rear_scan_;
  std::unique_ptr<dds::Publisher> info_;
  std::unique_ptr<dds::Publisher> picture_;
  std::unique_ptr<dds::Publisher> goal_;
  std::unique_ptr<dds::Publisher> initial_pose_;
  std::unique_ptr<dds::Subscription> cmd_vel_heard_;
  std::unique_ptr<dds::Subscription> place_heard_;
  std::unique_ptr<dds::Subscription> frames_heard_;
  std::unique_ptr<dds::Subscription> map_heard_;
  std::unique_ptr<dds::Subscription> plan_heard_;
  std::unique_ptr<dds::Subscription> diagnostics_heard_;
};

void SimulatedRobot::Advertise() {
  static_frames_ = Make<messages::TFMessage>("/tf_static", dds::kLatched);
  messages::TFMessage mounts;
  const core::RobotModel& model = robot_->options().robot;
  for (const auto& [name, base_from_sensor] :
       {std::pair{"laser", model.base_from_laser},
        std::pair{"rear_laser", model.base_from_rear_laser},
        std::pair{"optical", model.base_from_camera}}) {
    mounts.transforms.push_back(
        {.header = HeaderOf({}, "base_footprint"),
         .child_frame_id = name,
         .transform = conversions::TransformOf(base_from_sensor)});
  }
  Send(*static_frames_, mounts);
  if (has_clock_) {
    clock_ = Make<messages::Clock>("/clock", {.is_reliable = false});
  }
  odom_ = Make<messages::Odometry>("odom", {});
  scan_ = Make<messages::LaserScan>("scan", dds::kSensorData);
  rear_scan_ = Make<messages::LaserScan>("rear_scan", dds::kSensorData);
  info_ = Make<messages::CameraInfo>("camera/camera_info", dds::kSensorData);
  picture_ = Make<messages::CompressedImage>("camera/image_raw/compressed",
                                             dds::kSensorData);
  goal_ = Make<messages::PoseStamped>("goal_pose", {});
  initial_pose_ = Make<messages::PoseWithCovarianceStamped>("initialpose", {});
  cmd_vel_heard_ = Hear<messages::Twist>("cmd_vel", {});
  place_heard_ = Hear<messages::PoseWithCovarianceStamped>("amcl_pose", {});
  frames_heard_ = Hear<messages::TFMessage>("/tf", {.depth = 100});
  map_heard_ = Hear<messages::OccupancyGrid>("map", dds::kLatched);
  plan_heard_ = Hear<messages::Path>("plan", {});
  diagnostics_heard_ = Hear<messages::DiagnosticArray>("/diagnostics", {});
}

void SimulatedRobot::Step() {
  if (!has_clock_) {
    // What was measured a moment ago is stamped so, however slow we are.
    shift_ns_ =
        std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::chrono::system_clock::now().time_since_epoch())
            .count() -
        std::chrono::duration_cast<std::chrono::nanoseconds>(robot_->now())
            .count();
  }
  Steer();
  // All that is due, in small steps: a message does not wait for the last.
  robot_->Step(kStep);
  if (has_clock_ && robot_->now() >= next_clock_ && !IsSilent("clock")) {
    next_clock_ = robot_->now() + kClockInterval;
    Send(*clock_,
         messages::Clock{.clock = StampOf(base::MonotonicTime(robot_->now()))});
  }
  PublishSensors();
}

void SimulatedRobot::Steer() {
  if (tour_ == nullptr || robot_->now() < next_steering_) return;
  next_steering_ = robot_->now() + kSteerInterval;
  robot_->base()
      .SetVelocity(tour_->CommandAt(robot_->state().world_from_base))
      .IgnoreError();
  if (tour_->is_done()) tour_.reset();
}

void SimulatedRobot::PublishSensors() {
  for (const core::BaseReading& reading : robot_->odometry().TakeReadings()) {
    PublishOdometry(reading);
  }
  const auto send_scans = [this](core::RangeSensor& laser,
                                 const std::string& frame,
                                 dds::Publisher& publisher) {
    for (const core::LaserScan& scan : laser.TakeScans()) {
      if (IsSilent("scan")) continue;
      messages::LaserScan message =
          agent_values::MessageOf(scan, laser.Info(), frame);
      message.header = HeaderOf(scan.stamp, frame);
      Send(publisher, message);
    }
  };
  send_scans(robot_->laser(), "laser", *scan_);
  if (robot_->rear_laser() != nullptr) {
    send_scans(*robot_->rear_laser(), "rear_laser", *rear_scan_);
  }
  if (!has_camera_) return;
  for (const core::RgbdFrame& frame : robot_->camera().TakeNewest()) {
    PublishFrame(frame);
  }
}

void SimulatedRobot::PublishOdometry(const core::BaseReading& reading) {
  if (last_reading_.has_value()) {
    const double left_m = reading.left_wheel_m - last_reading_->left_wheel_m;
    const double right_m = reading.right_wheel_m - last_reading_->right_wheel_m;
    const double turn_rad =
        (right_m - left_m) / robot_->options().robot.wheel_track_m;
    const double way_m = (left_m + right_m) / 2;
    odom_from_base_ =
        odom_from_base_ * geometry::Rigid2{{way_m * std::cos(turn_rad / 2),
                                            way_m * std::sin(turn_rad / 2)},
                                           turn_rad};
  }
  last_reading_ = reading;
  if (IsSilent("odom")) return;
  messages::Odometry message;
  message.header = HeaderOf(reading.stamp, "odom");
  message.child_frame_id = "base_footprint";
  const geometry::Rotation3 rotation =
      geometry::Rotation3::FromAxisAngle({0, 0, odom_from_base_.yaw_rad}) *
      geometry::Rotation3::FromAxisAngle({0, reading.pitch_rad, 0}) *
      geometry::Rotation3::FromAxisAngle({reading.roll_rad, 0, 0});
  message.pose.pose =
      conversions::PoseOf({.rotation = rotation,
                           .translation = {odom_from_base_.translation.x,
                                           odom_from_base_.translation.y, 0}});
  message.twist.twist.linear.x = reading.forward_mps;
  message.twist.twist.angular.z = reading.yaw_rate_radps;
  Send(*odom_, message);
}

void SimulatedRobot::PublishFrame(const core::RgbdFrame& frame) {
  const camera::Camera camera = robot_->camera().Calibration().color;
  messages::CameraInfo info;
  info.header = HeaderOf(frame.stamp, "optical");
  info.width = static_cast<uint32_t>(camera.width());
  info.height = static_cast<uint32_t>(camera.height());
  info.k = {camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1};
  Send(*info_, info);
  messages::CompressedImage picture;
  picture.header = info.header;
  picture.format = "jpeg";
  const std::string jpeg = image::EncodeJpeg(frame.frame.color, 85).value();
  picture.data.assign(jpeg.begin(), jpeg.end());
  Send(*picture_, picture);
}

void SimulatedRobot::TakeMessages() {
  for (const dds::Sample& sample : cmd_vel_heard_->Take()) {
    const auto twist = messages::Decode<messages::Twist>(sample.bytes).value();
    command_ = {.forward_mps = twist.linear.x,
                .yaw_rate_radps = twist.angular.z};
    ++commands_;
    if (tour_ == nullptr) robot_->base().SetVelocity(command_).IgnoreError();
  }
  if (auto place = Newest<messages::PoseWithCovarianceStamped>(*place_heard_)) {
    place_ = *place;
  }
  if (auto frames = Newest<messages::TFMessage>(*frames_heard_)) {
    frames_ = *frames;
  }
  if (auto map = Newest<messages::OccupancyGrid>(*map_heard_)) {
    map_cells_ = map->data.size();
  }
  if (auto plan = Newest<messages::Path>(*plan_heard_)) {
    plan_poses_ = plan->poses.size();
  }
  if (auto report = Newest<messages::DiagnosticArray>(*diagnostics_heard_)) {
    diagnostics_.clear();
    for (const messages::DiagnosticStatus& status : report->status) {
      diagnostics_[status.name] = status.message;
      for (const messages::KeyValue& value : status.values) {
        diagnostics_[status.name + "/" + value.key] = value.value;
      }
    }
  }
}

void SimulatedRobot::Obey(const std::string& line) {
  std::istringstream words(line);
  std::string order;
  words >> order;
  if (order == "silence") {
    std::string topic;
    double seconds = 0;
    words >> topic >> seconds;
    silent_until_[topic] = robot_->now() + simulator::FromSeconds(seconds);
    return;
  }
  double x = 0;
  double y = 0;
  double yaw = 0;
  words >> x >> y >> yaw;
  if (order == "tour") {
    simulator::TourOptions options;
    options.speed_mps = 0.6;
    std::vector<geometry::Vec3> corners;
    for (const worlds::Float3& corner : robot_->world().tour) {
      corners.push_back({static_cast<double>(corner.x),
                         static_cast<double>(corner.y),
                         static_cast<double>(corner.z)});
    }
    tour_ = std::make_unique<simulator::TourDriver>(corners, options);
  } else if (order == "kidnap") {
    const absl::Status status =
        robot_->Kidnap({.position = {x, y}, .yaw_rad = yaw});
    if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  } else if (order == "goal") {
    messages::PoseStamped goal;
    goal.header = HeaderOf(base::MonotonicTime(robot_->now()), "map");
    goal.pose = InMap(x, y, yaw);
    Send(*goal_, goal);
  } else if (order == "place") {
    messages::PoseWithCovarianceStamped place;
    place.header = HeaderOf(base::MonotonicTime(robot_->now()), "map");
    place.pose.pose = InMap(x, y, yaw);
    Send(*initial_pose_, place);
  } else if (order == "jump") {
    jump_ns_ += static_cast<int64_t>(x * 1e9);
  } else if (order == "nonsense") {
    SendNonsense();
  } else {
    std::fprintf(stderr, "what is '%s'?\n", line.c_str());
  }
}

void SimulatedRobot::SendNonsense() {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  messages::LaserScan scan;
  scan.header = HeaderOf(base::MonotonicTime(robot_->now()), "laser");
  Send(*scan_, scan);
  scan.ranges.assign(100, nan);
  scan.angle_increment = nan;
  Send(*scan_, scan);
  scan.angle_increment = 1000;
  scan.range_max = 10;
  Send(*scan_, scan);
  messages::Odometry odometry;
  odometry.header = HeaderOf(base::MonotonicTime(robot_->now()), "odom");
  odometry.child_frame_id = "base_footprint";
  odometry.pose.pose.position.x = std::numeric_limits<double>::infinity();
  Send(*odom_, odometry);
  // A scan whose bytes end too early.
  const std::vector<uint8_t> bytes = messages::Encode(scan);
  if (!scan_->Publish(std::span(bytes).first(bytes.size() / 2)).ok()) {
    std::abort();
  }
}

void SimulatedRobot::Tell() {
  const simulator::TrueState state = robot_->state();
  const geometry::Rigid2 world = geometry::PlanarPose(state.world_from_base);
  std::printf(
      "t=%.2f true=%.3f,%.3f,%.3f speed=%.3f driven=%.2f tour=%d "
      "cmd=%.3f,%.3f commands=%lld map=%zu plan=%zu",
      std::chrono::duration<double>(robot_->now()).count(), world.translation.x,
      world.translation.y, world.yaw_rad,
      std::abs(state.forward_mps) + std::abs(state.yaw_rate_radps),
      state.distance_m, tour_ != nullptr ? 1 : 0, command_.forward_mps,
      command_.yaw_rate_radps, static_cast<long long>(commands_), map_cells_,
      plan_poses_);
  const auto tell_off = [this](const char* name,
                               const geometry::Rigid2& map_from_base) {
    const geometry::Rigid2 off = TrueMapFromBase().Inverse() * map_from_base;
    std::printf(" %s=%.3f,%.3f", name, geometry::Norm(off.translation),
                std::abs(off.yaw_rad));
  };
  if (place_.has_value()) {
    tell_off("place_off", geometry::PlanarPose(
                              conversions::RigidOf(place_->pose.pose).value()));
  }
  if (frames_.has_value()) {
    tell_off(
        "tf_off",
        geometry::PlanarPose(
            conversions::RigidOf(frames_->transforms.at(0).transform).value()) *
            odom_from_base_);
  }
  for (const auto& [name, message] : diagnostics_) {
    std::printf(" [%s=%s]", name.c_str(), message.c_str());
  }
  std::printf("\n");
  std::fflush(stdout);
}

int Play(int domain_id, const std::string& world, double pace, double camera_hz,
         bool is_plain) {
  simulator::Scenario scenario;
  scenario.world = world;
  scenario.world_options.with_people = false;
  scenario.world_options.paint = camera_hz > 0;
  scenario.options.seed = 5;
  scenario.options.sensors.camera_hz = camera_hz;
  scenario.options.sensors.camera_is_lit = false;
  scenario.options.sensors.has_rear_laser = !is_plain;
  if (is_plain) {
    sensors::LaserScannerOptions& laser = scenario.options.sensors.laser;
    laser.beams = 541;
    laser.angle_increment_rad *= 2;
    laser.scan_interval_s = 0.05;
    laser.beam_interval_s *= 4;
  }
  const auto fail = [](const absl::Status& status) {
    std::fprintf(stderr, "%s\n", status.ToString().c_str());
    return 1;
  };
  auto made = worlds::MakeWorld(scenario.world, scenario.world_options);
  if (!made.ok()) return fail(made.status());
  const auto start = simulator::StartOf(scenario, *made);
  if (!start.ok()) return fail(start.status());
  scenario.options.start = *start;
  auto robot = simulator::Simulator::Create(*std::move(made), scenario.options);
  if (!robot.ok()) return fail(robot.status());
  const auto domain = dds::Domain::Join({.id = domain_id, .interface = "lo"});
  if (!domain.ok()) return fail(domain.status());
  const auto node = dds::Node::Create(**domain, {.node = "robot"});
  if (!node.ok()) return fail(node.status());
  SimulatedRobot(**node, *std::move(robot), pace, camera_hz > 0).Run();
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  if (argc != 5 && argc != 6) {
    std::fprintf(stderr, "usage: %s DOMAIN WORLD PACE CAMERA_HZ [plain]\n",
                 argv[0]);
    return 2;
  }
  return treeline::Play(std::atoi(argv[1]), argv[2], std::atof(argv[3]),
                        std::atof(argv[4]), argc == 6);
}
