#include "nav_agent/app/ros/ros_robot.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/ros2/messages/message_codec.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/bridge/topic_inputs/topic_watch.h"

namespace treeline::ros_app {
namespace {

// A command that is too old is ended after so long at the latest.
constexpr auto kStep = std::chrono::milliseconds(20);
constexpr auto kLookUp = std::chrono::milliseconds(50);
constexpr auto kFirstReport = std::chrono::seconds(2);
constexpr auto kReport = std::chrono::seconds(5);
// A laser's axis may lean so far from the vertical; what its planes then show
// at some metres is the navigator's matter.
constexpr double kUpright = 0.95;

constexpr char kClockTopic[] = "/clock";
constexpr char kFramesTopic[] = "/tf_static";
constexpr dds::Quality kClock = {
    .is_reliable = false, .is_latched = false, .depth = 1};
constexpr dds::Quality kStaticTransforms = {
    .is_reliable = true, .is_latched = true, .depth = 100};
// A reader that is looked at every few milliseconds.
constexpr dds::Quality kSensors = {
    .is_reliable = false, .is_latched = false, .depth = 10};
// A command that is late is worth nothing.
constexpr dds::Quality kCommands = {
    .is_reliable = true, .is_latched = false, .depth = 1};

messages::Twist TwistOf(const core::VelocityCommand& command) {
  messages::Twist twist;
  twist.linear.x = command.forward_mps;
  twist.angular.z = command.yaw_rate_radps;
  return twist;
}

// Processor time of the thread that asks.
double ThreadTime_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) +
         1e-9 * static_cast<double>(time.tv_nsec);
}

std::string NameOf(const std::string& frame) {
  return std::string(absl::StripPrefix(frame, "/"));
}

}  // namespace

RosRobot::RosRobot(const RosRobotConfig& config, const base::Clock& real_clock,
                   Warn warn)
    : config_(config),
      real_clock_(real_clock),
      warn_(std::move(warn)),
      model_(config.robot),
      time_(config.use_sim_time, real_clock, robot_ports::SystemNow_ns),
      laser_(config.scan, time_, real_clock),
      rear_laser_(config.rear_scan, time_, real_clock),
      odometry_(config.odom, config.robot.wheel_track_m, time_, real_clock),
      camera_(config.image,
              {.is_rectified = config.is_rectified,
               .has_depth = !config.depth.empty()},
              1 / config.picture_hz, time_, real_clock),
      battery_(real_clock) {}

RosRobot::~RosRobot() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  // Says zero, if it must, while there is a network.
  base_.reset();
}

absl::StatusOr<std::unique_ptr<RosRobot>> RosRobot::Open(
    const RosRobotConfig& config, bool drives, const base::Clock& real_clock,
    Warn warn) {
  TL_RETURN_IF_ERROR(config.Validate());
  std::unique_ptr<RosRobot> robot(
      new RosRobot(config, real_clock, std::move(warn)));
  TL_ASSIGN_OR_RETURN(robot->domain_, dds::Domain::Join(config.domain));
  TL_ASSIGN_OR_RETURN(robot->node_,
                      dds::Node::Create(*robot->domain_, config.node));
  TL_RETURN_IF_ERROR(robot->AdvertiseBase(drives));
  TL_RETURN_IF_ERROR(robot->Subscribe());
  robot->thread_ =
      std::jthread([made = robot.get()](const std::stop_token& stop) {
        made->Listen(stop);
      });
  return robot;
}

absl::Status RosRobot::AdvertiseBase(bool drives) {
  robot_ports::BasePort::Wire wire = {
      .send =
          [](const core::VelocityCommand&) {
            return absl::FailedPreconditionError("nobody may drive the robot");
          },
      .listeners = [] { return 1; },
      // Whoever drives by a clock that stands does not see the time pass.
      .obstacle = [this]() -> absl::Status {
        if (time_.is_running()) return absl::OkStatus();
        return absl::UnavailableError(
            "nothing comes on /clock: the robot stands");
      }};
  if (drives) {
    TL_ASSIGN_OR_RETURN(cmd_vel_,
                        node_->Advertise(config_.cmd_vel,
                                         config_.is_cmd_vel_stamped
                                             ? messages::TwistStamped::kName
                                             : messages::Twist::kName,
                                         kCommands));
    wire.listeners = [this] { return cmd_vel_->matched(); };
    wire.why_nobody = [this] { return cmd_vel_->WhyNobody(); };
    wire.send = [this](const core::VelocityCommand& command) {
      return Send(command);
    };
  }
  base_ = std::make_unique<robot_ports::BasePort>(config_.cmd_vel, real_clock_,
                                                  std::move(wire));
  return absl::OkStatus();
}

absl::Status RosRobot::Send(const core::VelocityCommand& command) {
  if (!config_.is_cmd_vel_stamped) {
    return cmd_vel_->Publish(messages::Encode(TwistOf(command)));
  }
  return cmd_vel_->Publish(messages::Encode(
      messages::TwistStamped{.header = {.stamp = time_.StampOf(time_.Now()),
                                        .frame_id = config_.base_frame},
                             .twist = TwistOf(command)}));
}

absl::Status RosRobot::Subscribe() {
  const absl::MutexLock lock(&inputs_mutex_);
  inputs_ = std::make_unique<topic_inputs::TopicInputs>(*node_);
  // In the order in which they are handed over: what tells of the robot before
  // what it saw.
  if (config_.use_sim_time) {
    TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::Clock>(
        kClockTopic, kClock,
        [this](const messages::Clock& clock) { return SetClock(clock); }));
  }
  TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::TFMessage>(
      kFramesTopic, kStaticTransforms,
      [this](const messages::TFMessage& message) {
        const absl::MutexLock frames_lock(&mutex_);
        frames_.Add(message);
        return absl::OkStatus();
      }));
  TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::Odometry>(
      config_.odom, kSensors, [this](const messages::Odometry& message) {
        return AddOdometry(message);
      }));
  TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::LaserScan>(
      config_.scan, kSensors, [this](const messages::LaserScan& message) {
        return laser_.Add(message);
      }));
  if (!config_.rear_scan.empty()) {
    TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::LaserScan>(
        config_.rear_scan, kSensors,
        [this](const messages::LaserScan& message) {
          return rear_laser_.Add(message);
        }));
  }
  if (!config_.battery.empty()) {
    TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::BatteryState>(
        config_.battery, kSensors, [this](const messages::BatteryState& state) {
          return battery_.Add(state);
        }));
  }
  return config_.image.empty() ? absl::OkStatus() : SubscribeCamera();
}

absl::Status RosRobot::SubscribeCamera() {
  dds::Quality quality = dds::kSensorData;
  quality.is_reliable = config_.reliable_pictures;
  TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::CameraInfo>(
      config_.camera_info, dds::kSensorData,
      [this](const messages::CameraInfo& info) {
        return camera_.AddInfo(info);
      }));
  const auto subscribe = [this, &quality](const std::string& topic,
                                          auto add) -> absl::Status {
    if (bridge_app::IsCompressed(topic)) {
      return inputs_->Subscribe<messages::CompressedImage>(topic, quality, add);
    }
    return inputs_->Subscribe<messages::Image>(topic, quality, add);
  };
  TL_RETURN_IF_ERROR(subscribe(config_.image, [this](auto picture) {
    camera_.AddColor(std::move(picture));
    return absl::OkStatus();
  }));
  if (config_.depth.empty()) return absl::OkStatus();
  return subscribe(config_.depth, [this](auto picture) {
    camera_.AddDepth(std::move(picture));
    return absl::OkStatus();
  });
}

absl::Status RosRobot::SetClock(const messages::Clock& clock) {
  // The thread that hands over holds inputs_mutex_.
  inputs_mutex_.AssertHeld();
  const int publishers = inputs_->publishers(kClockTopic);
  if (publishers > 1) {
    return absl::FailedPreconditionError(
        absl::StrCat(publishers,
                     " programs tell the time: it stands still until one is "
                     "left"));
  }
  time_.Set(clock);
  return absl::OkStatus();
}

std::string RosRobot::WhyNothing(const std::string& topic,
                                 const core::DeviceHealth& health) const {
  // What came was no use.
  if (health.corrupt > 0) {
    return absl::StrCat(topic, ": ", health.cause.message());
  }
  const std::string nobody = WhyNobody(topic);
  return nobody.empty()
             ? absl::StrCat(topic, " is published, and nothing has come yet")
             : nobody;
}

std::string RosRobot::WhyNobody(const std::string& topic) const {
  const absl::MutexLock lock(&inputs_mutex_);
  return inputs_->WhyNobody(topic);
}

std::string RosRobot::WhyNoMount(const std::string& frame) const {
  const std::string nobody = WhyNobody(kFramesTopic);
  if (!nobody.empty()) {
    return absl::StrCat(kFramesTopic, " does not tell where ", frame,
                        " is from ", config_.base_frame, ": ", nobody);
  }
  const absl::MutexLock lock(&mutex_);
  return std::string(
      frames_.Find(config_.base_frame, frame).status().message());
}

absl::Status RosRobot::AddOdometry(const messages::Odometry& message) {
  const std::string child = NameOf(message.child_frame_id);
  if (!child_from_base_.has_value()) {
    if (child.empty() || child == config_.base_frame) {
      child_from_base_ = geometry::Rigid3{};
    } else {
      const absl::MutexLock lock(&mutex_);
      const auto found = frames_.Find(child, config_.base_frame);
      if (!found.ok()) {
        return odometry_.Refuse(absl::InvalidArgumentError(
            absl::StrCat("odometry is of the frame ", child,
                         ", and /tf_static does not "
                         "tell where ",
                         config_.base_frame,
                         " is from there: set base_frame "
                         "to ",
                         child, " if that is on the ground")));
      }
      child_from_base_ = *found;
    }
  }
  return odometry_.Add(message, *child_from_base_);
}

std::optional<geometry::Rigid3> RosRobot::Mount(
    const std::optional<geometry::Rigid3>& given,
    const std::string& frame_id) const {
  if (given.has_value()) return given;
  if (frame_id.empty()) return std::nullopt;
  const absl::MutexLock lock(&mutex_);
  const auto found = frames_.Find(config_.base_frame, NameOf(frame_id));
  if (!found.ok()) return std::nullopt;
  return *found;
}

absl::StatusOr<std::string> RosRobot::FindLaser(
    const std::string& topic, robot_ports::LaserPort& laser,
    const std::optional<geometry::Rigid3>& given,
    geometry::Rigid3& base_from_laser) {
  const core::DeviceHealth health = laser.Health();
  if (health.received == 0) return WhyNothing(topic, health);
  const std::string frame = laser.frame_id();
  const std::optional<geometry::Rigid3> mount = Mount(given, frame);
  if (!mount.has_value()) return WhyNoMount(frame);
  base_from_laser = *mount;
  const double up = (mount->rotation * geometry::Vec3{0, 0, 1}).z;
  if (std::abs(up) < kUpright) {
    return absl::FailedPreconditionError(
        absl::StrCat("the laser ", frame,
                     " is neither level nor upside down: its scans are of no "
                     "plane that the robot drives in"));
  }
  if (up < 0) {
    laser.SetUpsideDown();
    base_from_laser.rotation =
        mount->rotation *
        geometry::Rotation3::FromAxisAngle({std::numbers::pi, 0, 0});
  }
  // One that was turned over speaks once more.
  return laser.Info().beams > 0 ? "" : "the next scan";
}

absl::StatusOr<std::string> RosRobot::FindCamera() {
  const core::DeviceHealth health = camera_.Health();
  if (health.received == 0) return WhyNothing(config_.image, health);
  if (!camera_.has_info()) return WhyNothing(config_.camera_info, health);
  const std::string frame = camera_.frame_id();
  const std::optional<geometry::Rigid3> mount =
      Mount(config_.base_from_camera, frame);
  if (!mount.has_value()) return WhyNoMount(frame);
  model_.base_from_camera = *mount;
  return "";
}

absl::StatusOr<std::string> RosRobot::Missing() {
  if (!time_.is_running()) {
    const std::string nobody = WhyNobody(kClockTopic);
    return absl::StrCat("nothing comes on /clock, and use_sim_time is set",
                        nobody.empty() ? "" : ": ", nobody);
  }
  const core::DeviceHealth odometry = odometry_.Health();
  if (odometry.received == 0) return WhyNothing(config_.odom, odometry);
  TL_ASSIGN_OR_RETURN(std::string missing,
                      FindLaser(config_.scan, laser_, config_.base_from_laser,
                                model_.base_from_laser));
  if (missing.empty() && !config_.rear_scan.empty()) {
    TL_ASSIGN_OR_RETURN(missing, FindLaser(config_.rear_scan, rear_laser_,
                                           config_.base_from_rear_laser,
                                           model_.base_from_rear_laser));
  }
  if (missing.empty() && !config_.image.empty()) {
    TL_ASSIGN_OR_RETURN(missing, FindCamera());
  }
  return missing;
}

absl::Status RosRobot::WaitUntilKnown(const std::stop_token& stop) {
  base::MonotonicTime next_report = real_clock_.Now() + kFirstReport;
  while (!stop.stop_requested()) {
    TL_ASSIGN_OR_RETURN(const std::string missing, Missing());
    if (missing.empty()) return model_.Validate();
    if (real_clock_.Now() >= next_report) {
      next_report += kReport;
      warn_(absl::StrCat("waiting for the robot: ", missing));
    }
    std::this_thread::sleep_for(kLookUp);
  }
  return absl::OkStatus();
}

void RosRobot::Listen(const std::stop_token& stop) {
  topic_inputs::TopicWatch watch({kClockTopic, config_.odom, config_.scan,
                                  config_.rear_scan, config_.image},
                                 /*tells_nobody=*/false);
  while (!stop.stop_requested()) {
    std::vector<topic_inputs::TopicInputs::Fault> faults;
    std::vector<std::string> complaints;
    agent_report::TopicFacts facts;
    {
      const absl::MutexLock lock(&inputs_mutex_);
      faults = inputs_->Deliver(kStep);
      complaints = watch.Look(*inputs_, real_clock_.Now());
      facts.delivered = inputs_->delivered();
      facts.refused = inputs_->refused();
    }
    time_.Watch();
    base_->Watch();
    {
      const absl::MutexLock lock(&mutex_);
      listening_s_ = ThreadTime_s();
      facts_.delivered = facts.delivered;
      facts_.refused = facts.refused;
    }
    for (const std::string& complaint : complaints) warn_(complaint);
    for (const topic_inputs::TopicInputs::Fault& fault : faults) {
      warn_(absl::StrCat(fault.topic, ": ", fault.why.message(), " (",
                         fault.refused, " refused)"));
    }
  }
}

agent_report::TopicFacts RosRobot::Facts() const {
  agent_report::TopicFacts facts;
  {
    const absl::MutexLock lock(&mutex_);
    facts = facts_;
  }
  facts.clock_jumps = time_.jumps();
  facts.odometry_leaps = odometry_.leaps();
  facts.is_clock_running = time_.is_running();
  return facts;
}

double RosRobot::listening_s() const {
  const absl::MutexLock lock(&mutex_);
  return listening_s_;
}

double RosRobot::Delivery_ms(double share) const {
  const absl::MutexLock lock(&inputs_mutex_);
  return inputs_->Delivery_ms(share);
}

}  // namespace treeline::ros_app
