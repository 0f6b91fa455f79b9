#include "simulation/ros2_robot/ros2_robot.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/check_range.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/camera/camera.h"
#include "common/geometry/planar_pose.h"
#include "common/image/decode.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/bridge/dds/node.h"
#include "simulation/ros2_robot/robot_orders.h"
#include "simulation/simulator/paced_runner.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/simulator.h"

namespace treeline::ros2_robot {
namespace {

using simulator::SimTime;

// Of simulated time: between two looks at what is to be published.
constexpr SimTime kStep = std::chrono::milliseconds(5);
// ROS 2's simulations publish /clock about so often.
constexpr SimTime kClockInterval = std::chrono::milliseconds(10);
constexpr auto kLookUp = std::chrono::milliseconds(1);
constexpr auto kStatusInterval = std::chrono::milliseconds(500);
constexpr double kTourSpeed_mps = 0.6;
constexpr int kJpegQuality = 85;
constexpr SimTime kSteerInterval = std::chrono::milliseconds(50);
// A simulation's clock begins somewhere.
constexpr int64_t kClockBegins_ns = 1'000'000'000'000;

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

  absl::Status Run(const std::stop_token& stop);

 private:
  template <typename M>
  absl::Status Make(const std::string& topic, const dds::Quality& quality,
                    std::unique_ptr<dds::Publisher>& made) {
    TL_ASSIGN_OR_RETURN(made, node_.Advertise(topic, M::kName, quality));
    return absl::OkStatus();
  }
  template <typename M>
  absl::Status Hear(const std::string& topic, const dds::Quality& quality,
                    std::unique_ptr<dds::Subscription>& made) {
    TL_ASSIGN_OR_RETURN(made, node_.Subscribe(topic, M::kName, quality));
    return absl::OkStatus();
  }
  // What cannot be sent ends Run.
  template <typename M>
  void Send(dds::Publisher& publisher, const M& message) {
    sent_.Update(publisher.Publish(messages::Encode(message)));
  }
  // The newest message, if one has come that can be read.
  template <typename M>
  static std::optional<M> Newest(dds::Subscription& subscription) {
    const std::vector<dds::Sample> samples = subscription.Take();
    if (samples.empty()) return std::nullopt;
    auto message = messages::Decode<M>(samples.back().bytes);
    if (!message.ok()) return std::nullopt;
    return *std::move(message);
  }

  absl::Status Advertise();
  void SendMounts();
  void Step();
  void Steer();
  void PublishSensors();
  void PublishOdometry(const core::BaseReading& reading);
  void PublishFrame(const core::RgbdFrame& frame);
  void TakeMessages();
  // Who clicks looks whether anybody listens.
  bool CanObey(const RobotOrder& order) const {
    if (order.kind == RobotOrder::Kind::kGoal) return goal_->matched() > 0;
    if (order.kind == RobotOrder::Kind::kPlace) {
      return initial_pose_->matched() > 0;
    }
    return true;
  }
  void TakeOrders();
  void Obey(const RobotOrder& order);
  void DriveTour();
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
  messages::Pose InMap(const RobotOrder& order) const {
    const geometry::Rigid2 place =
        map_from_world_ *
        geometry::Rigid2{{order.x_m, order.y_m}, order.yaw_rad};
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
  OrderReader orders_;
  std::deque<RobotOrder> waiting_;
  absl::Status sent_;
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

absl::Status SimulatedRobot::Run(const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(Advertise());
  SendMounts();
  auto next_status = real_clock_.Now();
  while (!stop.stop_requested() && sent_.ok()) {
    TakeOrders();
    const base::MonotonicTime now = real_clock_.Now();
    if (pace_.Due(now) >= kStep) {
      Step();
    } else {
      node_.Wait(kLookUp);
    }
    TakeMessages();
    if (now >= next_status) {
      next_status = now + kStatusInterval;
      Tell();
    }
  }
  return sent_;
}

absl::Status SimulatedRobot::Advertise() {
  if (has_clock_) {
    TL_RETURN_IF_ERROR(Make<messages::Clock>(
        "/clock", {.is_reliable = false, .is_latched = false, .depth = 1},
        clock_));
  }
  TL_RETURN_IF_ERROR(
      Make<messages::TFMessage>("/tf_static", dds::kLatched, static_frames_));
  TL_RETURN_IF_ERROR(Make<messages::Odometry>("odom", {}, odom_));
  TL_RETURN_IF_ERROR(
      Make<messages::LaserScan>("scan", dds::kSensorData, scan_));
  if (robot_->rear_laser() != nullptr) {
    TL_RETURN_IF_ERROR(
        Make<messages::LaserScan>("rear_scan", dds::kSensorData, rear_scan_));
  }
  if (has_camera_) {
    TL_RETURN_IF_ERROR(Make<messages::CameraInfo>("camera/camera_info",
                                                  dds::kSensorData, info_));
    TL_RETURN_IF_ERROR(Make<messages::CompressedImage>(
        "camera/image_raw/compressed", dds::kSensorData, picture_));
  }
  TL_RETURN_IF_ERROR(Make<messages::PoseStamped>("goal_pose", {}, goal_));
  TL_RETURN_IF_ERROR(Make<messages::PoseWithCovarianceStamped>(
      "initialpose", {}, initial_pose_));
  TL_RETURN_IF_ERROR(Hear<messages::Twist>("cmd_vel", {}, cmd_vel_heard_));
  TL_RETURN_IF_ERROR(
      Hear<messages::PoseWithCovarianceStamped>("amcl_pose", {}, place_heard_));
  TL_RETURN_IF_ERROR(Hear<messages::TFMessage>(
      "/tf", {.is_reliable = true, .is_latched = false, .depth = 100},
      frames_heard_));
  TL_RETURN_IF_ERROR(
      Hear<messages::OccupancyGrid>("map", dds::kLatched, map_heard_));
  TL_RETURN_IF_ERROR(Hear<messages::Path>("plan", {}, plan_heard_));
  return Hear<messages::DiagnosticArray>("/diagnostics", {},
                                         diagnostics_heard_);
}

void SimulatedRobot::SendMounts() {
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
  const auto jpeg = image::EncodeJpeg(frame.frame.color, kJpegQuality);
  sent_.Update(jpeg.status());
  if (!jpeg.ok()) return;
  picture.data.assign(jpeg->begin(), jpeg->end());
  Send(*picture_, picture);
}

void SimulatedRobot::TakeMessages() {
  for (const dds::Sample& sample : cmd_vel_heard_->Take()) {
    const auto twist = messages::Decode<messages::Twist>(sample.bytes);
    if (!twist.ok()) continue;
    command_ = {.forward_mps = twist->linear.x,
                .yaw_rate_radps = twist->angular.z};
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

void SimulatedRobot::TakeOrders() {
  for (const std::string& line : orders_.TakeLines()) {
    const absl::StatusOr<RobotOrder> order = ParseOrder(line);
    if (order.ok()) {
      waiting_.push_back(*order);
    } else {
      std::fprintf(stderr, "%s\n",
                   std::string(order.status().message()).c_str());
    }
  }
  while (!waiting_.empty() && CanObey(waiting_.front())) {
    Obey(waiting_.front());
    waiting_.pop_front();
  }
}

void SimulatedRobot::DriveTour() {
  simulator::TourOptions options;
  options.speed_mps = kTourSpeed_mps;
  std::vector<geometry::Vec3> corners;
  for (const worlds::Float3& corner : robot_->world().tour) {
    corners.push_back({static_cast<double>(corner.x),
                       static_cast<double>(corner.y),
                       static_cast<double>(corner.z)});
  }
  tour_ = std::make_unique<simulator::TourDriver>(corners, options);
}

void SimulatedRobot::Obey(const RobotOrder& order) {
  const messages::Header now =
      HeaderOf(base::MonotonicTime(robot_->now()), "map");
  switch (order.kind) {
    case RobotOrder::Kind::kTour:
      return DriveTour();
    case RobotOrder::Kind::kKidnap: {
      const absl::Status status = robot_->Kidnap(
          {.position = {order.x_m, order.y_m}, .yaw_rad = order.yaw_rad});
      if (!status.ok()) {
        std::fprintf(stderr, "%s\n", std::string(status.message()).c_str());
      }
      return;
    }
    case RobotOrder::Kind::kGoal:
      return Send(*goal_,
                  messages::PoseStamped{.header = now, .pose = InMap(order)});
    case RobotOrder::Kind::kPlace: {
      messages::PoseWithCovarianceStamped place;
      place.header = now;
      place.pose.pose = InMap(order);
      return Send(*initial_pose_, place);
    }
    case RobotOrder::Kind::kSilence:
      silent_until_[order.topic] =
          robot_->now() + simulator::FromSeconds(order.seconds);
      return;
    case RobotOrder::Kind::kJump:
      jump_ns_ += static_cast<int64_t>(order.seconds * 1e9);
      return;
    case RobotOrder::Kind::kNonsense:
      return SendNonsense();
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
  sent_.Update(scan_->Publish(std::span(bytes).first(bytes.size() / 2)));
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
                               const absl::StatusOr<geometry::Rigid3>& found,
                               const geometry::Rigid2& frame_from_base) {
    if (!found.ok()) return;
    const geometry::Rigid2 off = TrueMapFromBase().Inverse() *
                                 geometry::PlanarPose(*found) * frame_from_base;
    std::printf(" %s=%.3f,%.3f", name, geometry::Norm(off.translation),
                std::abs(off.yaw_rad));
  };
  if (place_.has_value()) {
    tell_off("place_off", conversions::RigidOf(place_->pose.pose), {});
  }
  if (frames_.has_value() && !frames_->transforms.empty()) {
    tell_off("tf_off",
             conversions::RigidOf(frames_->transforms.front().transform),
             odom_from_base_);
  }
  for (const auto& [name, message] : diagnostics_) {
    std::printf(" [%s=%s]", name.c_str(), message.c_str());
  }
  std::printf("\n");
  std::fflush(stdout);
}

simulator::Scenario ScenarioOf(const Ros2RobotOptions& options) {
  simulator::Scenario scenario;
  scenario.world = options.world;
  scenario.world_options.with_people = options.has_people;
  scenario.world_options.paint = options.camera_hz > 0;
  scenario.options.seed = options.seed;
  scenario.options.sensors.camera_hz = options.camera_hz;
  scenario.options.sensors.camera_is_lit = false;
  scenario.options.sensors.has_rear_laser = !options.is_plain;
  if (options.is_plain) {
    sensors::LaserScannerOptions& laser = scenario.options.sensors.laser;
    laser.beams = 541;
    laser.angle_increment_rad *= 2;
    laser.scan_interval_s = 0.05;
    laser.beam_interval_s *= 4;
  }
  return scenario;
}

}  // namespace

absl::Status Ros2RobotOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("pace", pace, 0, 100));
  return base::CheckRange("camera_hz", camera_hz, 0, 30);
}

absl::Status PlayRos2Robot(const Ros2RobotOptions& options,
                           const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  simulator::Scenario scenario = ScenarioOf(options);
  TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<simulator::Simulator> robot,
      simulator::Simulator::Create(std::move(world), scenario.options));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<dds::Domain> domain,
                      dds::Domain::Join(options.domain));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<dds::Node> node,
                      dds::Node::Create(*domain, options.node));
  return SimulatedRobot(*node, std::move(robot), options.pace,
                        options.camera_hz > 0)
      .Run(stop);
}

}  // namespace treeline::ros2_robot
