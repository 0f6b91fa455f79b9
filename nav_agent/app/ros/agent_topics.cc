#include "nav_agent/app/ros/agent_topics.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "nav_agent/bridge/agent_values/laser_values.h"

namespace treeline::ros_app {
namespace {

// Between looks for a newer state: those come ten times a second.
constexpr auto kStep = std::chrono::milliseconds(20);
// As ROS 2's diagnostics come.
constexpr auto kReportInterval = std::chrono::seconds(1);
// What RViz says of an initial pose where its message says nothing.
constexpr double kStartStd_m = 0.25;
constexpr double kStartStd_rad = 0.2;
// More is no place at all, less nobody can click.
constexpr double kMinStd = 0.02;
constexpr double kMaxStd_m = 5;
constexpr double kMaxStd_rad = 3;

constexpr dds::Quality kFrames = {
    .is_reliable = true, .is_latched = false, .depth = 100};

double StdOf(double variance, double if_none, double most) {
  if (!(variance > 0) || !std::isfinite(variance)) return if_none;
  return std::clamp(std::sqrt(variance), kMinStd, most);
}

}  // namespace

absl::StatusOr<std::unique_ptr<AgentTopics>> AgentTopics::Start(
    RosRobot& robot, agent_service::AgentCommands& commands,
    RosRobot::Warn warn) {
  std::unique_ptr<AgentTopics> topics(
      new AgentTopics(robot, commands, std::move(warn)));
  TL_ASSIGN_OR_RETURN(topics->node_,
                      dds::Node::Create(robot.domain(), robot.config().node));
  TL_RETURN_IF_ERROR(topics->Advertise());
  TL_RETURN_IF_ERROR(topics->Subscribe());
  TL_RETURN_IF_ERROR(topics->ServeActions());
  topics->thread_ = std::jthread(
      [made = topics.get()](const std::stop_token& stop) { made->Run(stop); });
  return topics;
}

AgentTopics::~AgentTopics() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

absl::Status AgentTopics::Advertise() {
  const RosRobotConfig& config = robot_.config();
  TL_ASSIGN_OR_RETURN(
      map_, node_->Advertise(config.map, messages::OccupancyGrid::kName,
                             dds::kLatched));
  TL_ASSIGN_OR_RETURN(plan_,
                      node_->Advertise(config.plan, messages::Path::kName, {}));
  TL_ASSIGN_OR_RETURN(
      pose_,
      node_->Advertise(config.pose, messages::PoseWithCovarianceStamped::kName,
                       dds::kLatched));
  if (config.publishes_tf) {
    TL_ASSIGN_OR_RETURN(
        frames_, node_->Advertise("/tf", messages::TFMessage::kName, kFrames));
  }
  TL_ASSIGN_OR_RETURN(
      diagnostics_,
      node_->Advertise("/diagnostics", messages::DiagnosticArray::kName, {}));
  return absl::OkStatus();
}

absl::Status AgentTopics::Subscribe() {
  const RosRobotConfig& config = robot_.config();
  inputs_ = std::make_unique<topic_inputs::TopicInputs>(*node_);
  if (!config.goal.empty()) {
    TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::PoseStamped>(
        config.goal, {}, [this](const messages::PoseStamped& goal) {
          return SetGoal(goal).status();
        }));
  }
  if (!config.initial_pose.empty()) {
    TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::PoseWithCovarianceStamped>(
        config.initial_pose, {},
        [this](const messages::PoseWithCovarianceStamped& place) {
          return TakePlace(place);
        }));
  }
  TL_RETURN_IF_ERROR(inputs_->Subscribe<messages::Empty>(
      "~/cancel", {},
      [this](const messages::Empty&) { return commands_.Cancel(0); }));
  return inputs_->Subscribe<messages::Empty>(
      "~/find_yourself", {},
      [this](const messages::Empty&) { return commands_.FindYourself(); });
}

absl::Status AgentTopics::ServeActions() {
  const std::string& action = robot_.config().navigate_to_pose;
  if (action.empty()) return absl::OkStatus();
  if (robot_.config().rmw == Rmw::kFastDds) {
    TL_ASSIGN_OR_RETURN(fast_services_,
                        fast_dds::FastServices::Join(robot_.config().domain,
                                                     robot_.config().node));
  }
  TL_ASSIGN_OR_RETURN(
      navigate_,
      navigate_action::NavigateServer::Open(
          *node_,
          [this](const std::string& service, const std::string& type) {
            return fast_services_ == nullptr
                       ? node_->Serve(service, type)
                       : fast_services_->Serve(service, type);
          },
          action,
          {.set_goal =
               [this](const messages::PoseStamped& goal) {
                 return SetGoal(goal);
               },
           .cancel = [this](uint64_t goal) { return commands_.Cancel(goal); }},
          warn_));
  return absl::OkStatus();
}

absl::StatusOr<agent_service::RequestedPose> AgentTopics::RequestedOf(
    const messages::Header& header, const messages::Pose& pose) const {
  const absl::string_view frame = absl::StripPrefix(header.frame_id, "/");
  const std::string& map_frame = robot_.config().map_frame;
  if (!frame.empty() && frame != map_frame) {
    return absl::InvalidArgumentError(
        absl::StrCat("a pose in the frame ", frame, "; only those in ",
                     map_frame, " are understood"));
  }
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 map_from_base,
                      conversions::RigidOf(pose));
  const geometry::Rigid2 planar = geometry::PlanarPose(map_from_base);
  return agent_service::RequestedPose{
      .x_m = planar.translation.x,
      .y_m = planar.translation.y,
      .yaw_rad = planar.yaw_rad,
      .level = commands_.NearestLevel(map_from_base).place.level};
}

absl::StatusOr<uint64_t> AgentTopics::SetGoal(
    const messages::PoseStamped& goal) {
  TL_ASSIGN_OR_RETURN(const agent_service::RequestedPose pose,
                      RequestedOf(goal.header, goal.pose));
  return commands_.SetGoal({pose});
}

absl::Status AgentTopics::TakePlace(
    const messages::PoseWithCovarianceStamped& place) {
  TL_ASSIGN_OR_RETURN(const agent_service::RequestedPose pose,
                      RequestedOf(place.header, place.pose.pose));
  const auto& covariance = place.pose.covariance;
  return commands_.SetPose(
      pose,
      StdOf(std::max(covariance[0], covariance[7]), kStartStd_m, kMaxStd_m),
      StdOf(covariance[35], kStartStd_rad, kMaxStd_rad));
}

void AgentTopics::Run(const std::stop_token& stop) {
  uint64_t last = 0;
  std::string last_error;
  while (!stop.stop_requested()) {
    for (const topic_inputs::TopicInputs::Fault& fault :
         inputs_->Deliver(kStep)) {
      warn_(absl::StrCat(fault.topic, ": ", fault.why.message()));
    }
    if (navigate_ != nullptr) navigate_->Answer(Now());
    const std::shared_ptr<const agent_service::AgentState> state =
        commands_.hub().Latest();
    if (state == nullptr || state->number == last) continue;
    last = state->number;
    absl::Status status = Publish(*state);
    if (navigate_ != nullptr) {
      status.Update(navigate_->Tell(*state, Now(), robot_.config().map_frame));
    }
    if (!status.ok() && status.message() != last_error) {
      last_error = std::string(status.message());
      warn_(last_error);
    }
  }
  if (navigate_ != nullptr) navigate_->Close(Now());
}

messages::Header AgentTopics::InMap(base::MonotonicTime stamp) const {
  return {.stamp = robot_.time().StampOf(stamp),
          .frame_id = robot_.config().map_frame};
}

navigate_action::Moment AgentTopics::Now() const {
  const base::MonotonicTime now = robot_.time().Now();
  return {.now = now, .stamp = robot_.time().StampOf(now)};
}

absl::Status AgentTopics::Publish(const agent_service::AgentState& state) {
  const behavior::NavigatorSnapshot& robot = state.snapshot;
  TL_RETURN_IF_ERROR(PublishMap(robot.pose.has_value()
                                    ? robot.pose->pose.place.level
                                    : level_.value_or(0)));
  if (robot.pose.has_value()) TL_RETURN_IF_ERROR(PublishPlace(*robot.pose));
  if (robot.path != path_) {
    path_ = robot.path;
    TL_RETURN_IF_ERROR(plan_->Publish(
        messages::Encode(agent_report::PathOf(path_, InMap(robot.stamp)))));
  }
  const base::MonotonicTime now = robot_.time().Now();
  if (mode_ == robot.mode && now < next_report_) return absl::OkStatus();
  mode_ = robot.mode;
  next_report_ = now + kReportInterval;
  return PublishReport(state);
}

absl::Status AgentTopics::PublishPlace(const localization::TrackedPose& pose) {
  // A stamp twice makes who listens to /tf complain.
  if (place_stamp_.has_value() && pose.stamp <= *place_stamp_) {
    return absl::OkStatus();
  }
  place_stamp_ = pose.stamp;
  TL_RETURN_IF_ERROR(pose_->Publish(
      messages::Encode(agent_report::PlaceOf(pose, InMap(pose.stamp)))));
  if (frames_ == nullptr) return absl::OkStatus();
  const std::optional<geometry::Rigid3> odom_from_base =
      robot_.odometry().OdomFromBaseAt(pose.stamp);
  if (!odom_from_base.has_value()) return absl::OkStatus();
  const auto ahead = std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double>(robot_.config().tf_tolerance_s));
  return frames_->Publish(messages::Encode(messages::TFMessage{
      .transforms = {{.header = InMap(pose.stamp + ahead),
                      .child_frame_id = robot_.odometry().frame_id(),
                      .transform = conversions::TransformOf(
                          agent_report::MapFromBase(pose) *
                          odom_from_base->Inverse())}}}));
}

absl::Status AgentTopics::PublishMap(int level) {
  if (level_ == level) return absl::OkStatus();
  const auto& levels = commands_.info().map->levels.levels;
  if (level < 0 || static_cast<size_t>(level) >= levels.size()) {
    return absl::OkStatus();
  }
  level_ = level;
  return map_->Publish(messages::Encode(agent_values::MessageOf(
      levels[static_cast<size_t>(level)].grid, InMap(robot_.time().Now()))));
}

absl::Status AgentTopics::PublishReport(
    const agent_service::AgentState& state) {
  return diagnostics_->Publish(messages::Encode(agent_report::ReportOf(
      state, robot_.Facts(), robot_.time().StampOf(robot_.time().Now()))));
}

}  // namespace treeline::ros_app
