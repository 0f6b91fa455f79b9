#include "nav_agent/bridge/foxglove/live_topics.h"

#include <cstring>
#include <utility>

#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/message_schema.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_report/agent_report.h"
#include "nav_agent/bridge/agent_values/laser_values.h"

namespace treeline::foxglove {
namespace {

using Encoded = std::vector<std::vector<uint8_t>>;
using agent_service::AgentState;

constexpr char kMapFrame[] = "map";
constexpr char kBaseFrame[] = "base_link";
constexpr char kLaserFrame[] = "laser";
constexpr char kCameraFrame[] = "camera_color_optical_frame";
constexpr int64_t kReportInterval_ns = 1'000'000'000;
// Those of before a viewer came.
constexpr size_t kMaxEvents = 50;
// A band and a scan lie a little above the ground, or flicker in it.
constexpr double kAbove_m = 0.02;
// What nav_msgs/OccupancyGrid says of an obstacle that was seen and of one that
// the map has.
constexpr int8_t kSeen = 100;
constexpr int8_t kMapped = 80;

size_t Index(LiveTopic topic) { return static_cast<size_t>(topic); }

template <messages::Message M>
Channel ChannelOf(LiveTopic topic, const char* name) {
  return {.id = static_cast<uint32_t>(topic),
          .topic = name,
          .schema_name = M::kName,
          .schema = messages::SchemaText<M>()};
}

messages::Header HeaderOf(int64_t now_ns, const char* frame) {
  return {.stamp = messages::TimeOf(now_ns), .frame_id = frame};
}

template <messages::Message M>
Encoded One(const M& message) {
  return {messages::Encode(message)};
}

messages::Pose Upright(const geometry::Vec2& at, double height_m) {
  return conversions::PoseOf(
      {.rotation = {}, .translation = {at.x, at.y, height_m}});
}

// The height of the ground that the robot is on.
double Ground_m(const AgentState& state) {
  return state.snapshot.pose ? state.snapshot.pose->pose.place.height_m : 0;
}

Encoded Frames(const AgentState& state, const core::RobotModel& robot,
               int64_t now_ns) {
  if (!state.snapshot.pose) return {};
  const messages::Header base = HeaderOf(now_ns, kBaseFrame);
  return One(messages::TFMessage{
      {{.header = HeaderOf(now_ns, kMapFrame),
        .child_frame_id = kBaseFrame,
        .transform = conversions::TransformOf(
            agent_report::MapFromBase(*state.snapshot.pose))},
       {.header = base,
        .child_frame_id = kLaserFrame,
        .transform = conversions::TransformOf(robot.base_from_laser)},
       {.header = base,
        .child_frame_id = kCameraFrame,
        .transform = conversions::TransformOf(robot.base_from_camera)}}});
}

messages::Path BandOf(const AgentState& state, int64_t now_ns) {
  messages::Path path;
  path.header = HeaderOf(now_ns, kMapFrame);
  for (const control::Bubble& bubble : state.snapshot.bubbles) {
    path.poses.push_back(
        {.header = path.header,
         .pose = Upright(bubble.center_in_map, Ground_m(state) + kAbove_m)});
  }
  return path;
}

// Points of so many float32 each, named as `names`.
messages::PointCloud2 CloudOf(std::span<const char* const> names,
                              std::span<const float> values, int64_t now_ns) {
  messages::PointCloud2 cloud;
  cloud.header = HeaderOf(now_ns, kMapFrame);
  for (size_t i = 0; i < names.size(); ++i) {
    cloud.fields.push_back({.name = names[i],
                            .offset = static_cast<uint32_t>(4 * i),
                            .datatype = messages::PointField::kFloat32,
                            .count = 1});
  }
  cloud.point_step = static_cast<uint32_t>(4 * names.size());
  cloud.height = 1;
  cloud.width = static_cast<uint32_t>(values.size() / names.size());
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = true;
  cloud.data.resize(values.size_bytes());
  if (!values.empty()) {
    std::memcpy(cloud.data.data(), values.data(), values.size_bytes());
  }
  return cloud;
}

Encoded Scan(const AgentState& state, int64_t now_ns) {
  constexpr const char* kNames[] = {"x", "y", "z"};
  std::vector<float> values;
  const auto height = static_cast<float>(Ground_m(state) + kAbove_m);
  for (const geometry::Vec2& end : state.snapshot.scan_in_map) {
    values.insert(values.end(), {static_cast<float>(end.x),
                                 static_cast<float>(end.y), height});
  }
  return One(CloudOf(kNames, values, now_ns));
}

Encoded Particles(const AgentState& state, int64_t now_ns) {
  constexpr const char* kNames[] = {"x", "y", "z", "weight"};
  std::vector<float> values;
  for (const localization::Particle& one : state.snapshot.particles) {
    const geometry::Vec2& at = one.map_from_base.translation;
    values.insert(values.end(),
                  {static_cast<float>(at.x), static_cast<float>(at.y),
                   static_cast<float>(one.place.height_m),
                   static_cast<float>(one.weight)});
  }
  return One(CloudOf(kNames, values, now_ns));
}

Encoded Costmap(const AgentState& state, int64_t now_ns) {
  const control::CostmapView& view = state.snapshot.costmap;
  if (view.cells.empty()) return {};
  messages::OccupancyGrid grid;
  grid.header = HeaderOf(now_ns, kMapFrame);
  grid.info.map_load_time = grid.header.stamp;
  grid.info.resolution = static_cast<float>(view.resolution_m);
  grid.info.width = static_cast<uint32_t>(view.width);
  grid.info.height = static_cast<uint32_t>(view.height);
  grid.info.origin = Upright(view.origin_in_map, Ground_m(state));
  grid.data.reserve(view.cells.size());
  for (const uint8_t cell : view.cells) {
    grid.data.push_back(cell == 0 ? int8_t{0} : cell == 1 ? kMapped : kSeen);
  }
  return One(grid);
}

Encoded Command(const AgentState& state, int64_t now_ns) {
  messages::TwistStamped twist;
  twist.header = HeaderOf(now_ns, kBaseFrame);
  twist.twist.linear.x = state.snapshot.command.forward_mps;
  twist.twist.angular.z = state.snapshot.command.yaw_rate_radps;
  return One(twist);
}

}  // namespace

const std::vector<Channel>& LiveChannels() {
  using T = LiveTopic;
  static const auto* const channels = new std::vector<Channel>{
      ChannelOf<messages::TFMessage>(T::kFrames, "/tf"),
      ChannelOf<messages::PoseWithCovarianceStamped>(T::kPose, "/pose"),
      ChannelOf<messages::Path>(T::kPlan, "/plan"),
      ChannelOf<messages::Path>(T::kBand, "/band"),
      ChannelOf<messages::PointCloud2>(T::kScan, "/scan_points"),
      ChannelOf<messages::PointCloud2>(T::kParticles, "/particles"),
      ChannelOf<messages::OccupancyGrid>(T::kMap, "/map"),
      ChannelOf<messages::OccupancyGrid>(T::kCostmap, "/local_costmap"),
      ChannelOf<messages::TwistStamped>(T::kCommand, "/cmd_vel"),
      ChannelOf<messages::DiagnosticArray>(T::kDiagnostics, "/diagnostics"),
      ChannelOf<messages::Log>(T::kEvents, "/rosout"),
      ChannelOf<messages::CompressedImage>(
          T::kCamera, "/camera/color/image_raw/compressed")};
  return *channels;
}

void LiveTopics::Begin(LiveTopic topic) {
  told_[Index(topic)].reset();
  if (topic == LiveTopic::kCamera) picture_ = nullptr;
}

bool LiveTopics::IsNew(LiveTopic topic, uint64_t mark) {
  std::optional<uint64_t>& told = told_[Index(topic)];
  if (told == mark) return false;
  told = mark;
  return true;
}

Encoded LiveTopics::Next(LiveTopic topic, const AgentState& state,
                         int64_t now_ns) {
  // What is kept for who comes late says itself whether it is new.
  switch (topic) {
    case LiveTopic::kEvents:
      return Events(now_ns);
    case LiveTopic::kCamera:
      return Picture(now_ns);
    case LiveTopic::kMap:
      return Map(
          state.snapshot.pose ? state.snapshot.pose->pose.place.level : 0,
          now_ns);
    case LiveTopic::kPlan:
      if (told_[Index(topic)] && state.snapshot.path == path_) return {};
      told_[Index(topic)] = 0;
      path_ = state.snapshot.path;
      return One(agent_report::PathOf(path_, HeaderOf(now_ns, kMapFrame)));
    case LiveTopic::kDiagnostics: {
      // Another mode is told at once.
      const auto mode = static_cast<uint64_t>(state.snapshot.mode);
      const auto interval = static_cast<uint64_t>(now_ns / kReportInterval_ns);
      if (!IsNew(topic, (interval << 8) | mode)) return {};
      return One(agent_report::ReportOf(state, std::nullopt,
                                        messages::TimeOf(now_ns)));
    }
    default:
      break;
  }
  if (!IsNew(topic, state.number)) return {};
  switch (topic) {
    case LiveTopic::kFrames:
      return Frames(state, info_.robot, now_ns);
    case LiveTopic::kPose:
      if (!state.snapshot.pose) return {};
      return One(agent_report::PlaceOf(*state.snapshot.pose,
                                       HeaderOf(now_ns, kMapFrame)));
    case LiveTopic::kBand:
      return One(BandOf(state, now_ns));
    case LiveTopic::kScan:
      return Scan(state, now_ns);
    case LiveTopic::kParticles:
      return Particles(state, now_ns);
    case LiveTopic::kCostmap:
      return Costmap(state, now_ns);
    case LiveTopic::kCommand:
      return Command(state, now_ns);
    default:
      return {};
  }
}

Encoded LiveTopics::Map(int level, int64_t now_ns) {
  const auto& levels = info_.map->levels.levels;
  if (level < 0 || static_cast<size_t>(level) >= levels.size()) return {};
  if (!IsNew(LiveTopic::kMap, static_cast<uint64_t>(level))) return {};
  return One(agent_values::MessageOf(levels[static_cast<size_t>(level)].grid,
                                     HeaderOf(now_ns, kMapFrame)));
}

Encoded LiveTopics::Events(int64_t now_ns) {
  std::optional<uint64_t>& told = told_[Index(LiveTopic::kEvents)];
  if (!told) {
    const uint64_t last = hub_.last_event();
    told = last > kMaxEvents ? last - kMaxEvents : 0;
  }
  Encoded lines;
  for (const agent_service::AgentHub::Event& event :
       hub_.EventsAfter(*told, kMaxEvents)) {
    told = event.number;
    messages::Log line;
    line.stamp = messages::TimeOf(now_ns);
    line.name = "treeline." + event.kind;
    line.msg = event.text;
    lines.push_back(messages::Encode(line));
  }
  return lines;
}

Encoded LiveTopics::Picture(int64_t now_ns) {
  if (camera_ == nullptr) return {};
  auto jpeg = camera_->Jpeg();
  if (!jpeg.ok() || *jpeg == picture_) return {};
  picture_ = *std::move(jpeg);
  messages::CompressedImage picture;
  picture.header = HeaderOf(now_ns, kCameraFrame);
  picture.format = "jpeg";
  picture.data.assign(picture_->begin(), picture_->end());
  return One(picture);
}

}  // namespace treeline::foxglove
