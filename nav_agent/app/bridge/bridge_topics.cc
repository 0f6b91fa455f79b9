#include "nav_agent/app/bridge/bridge_topics.h"

#include <chrono>
#include <utility>

#include "common/base/status_macros.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::bridge_app {
namespace {

// Of /tf and /tf_static as tf2_ros listens to them.
constexpr dds::Quality kTransforms = {
    .is_reliable = true, .is_latched = false, .depth = 100};
constexpr dds::Quality kStaticTransforms = {
    .is_reliable = true, .is_latched = true, .depth = 100};
constexpr dds::Quality kClock = {
    .is_reliable = false, .is_latched = false, .depth = 1};

}  // namespace

base::MonotonicTime RosClock::Now() const {
  if (is_simulated_) return simulated_;
  return base::MonotonicTime(
      std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::system_clock::now().time_since_epoch()));
}

void RosClock::Set(const messages::Clock& clock) {
  simulated_ = conversions::TimeOf(clock.clock);
}

template <typename M>
absl::Status BridgeTopics::Subscribe(const std::string& topic,
                                     const dds::Quality& quality) {
  return inputs_.Subscribe<M>(topic, quality, [this](const M& message) {
    return finder_.Add(message);
  });
}

absl::Status BridgeTopics::SubscribeCamera(const BridgeConfig& config) {
  dds::Quality quality = dds::kSensorData;
  quality.is_reliable = config.reliable_pictures;
  TL_RETURN_IF_ERROR(inputs_.Subscribe<messages::CameraInfo>(
      config.CameraInfoTopic(), dds::kSensorData,
      [this](const messages::CameraInfo& info) {
        return finder_.camera().AddInfo(info);
      }));
  const auto subscribe = [this, &quality](const std::string& topic,
                                          auto add) -> absl::Status {
    if (IsCompressed(topic)) {
      return inputs_.Subscribe<messages::CompressedImage>(topic, quality, add);
    }
    return inputs_.Subscribe<messages::Image>(topic, quality, add);
  };
  TL_RETURN_IF_ERROR(subscribe(config.image, [this](auto picture) {
    finder_.camera().AddColor(std::move(picture));
    return absl::OkStatus();
  }));
  if (config.depth.empty()) return absl::OkStatus();
  return subscribe(config.depth, [this](auto picture) {
    finder_.camera().AddDepth(std::move(picture));
    return absl::OkStatus();
  });
}

absl::StatusOr<std::unique_ptr<BridgeTopics>> BridgeTopics::Open(
    dds::Node& node, const BridgeConfig& config,
    place_finder::PlaceFinder& finder, RosClock& clock) {
  std::unique_ptr<BridgeTopics> topics(new BridgeTopics(node, finder));
  topic_inputs::TopicInputs& inputs = topics->inputs_;
  const auto add_frames = [&finder](const messages::TFMessage& message) {
    finder.Add(message);
    return absl::OkStatus();
  };
  // In the order in which they are handed over: what tells of the robot before
  // what it saw.
  if (config.use_sim_time) {
    TL_RETURN_IF_ERROR(inputs.Subscribe<messages::Clock>(
        "/clock", kClock, [&clock](const messages::Clock& message) {
          clock.Set(message);
          return absl::OkStatus();
        }));
  }
  TL_RETURN_IF_ERROR(inputs.Subscribe<messages::TFMessage>(
      "/tf_static", kStaticTransforms, add_frames));
  TL_RETURN_IF_ERROR(
      inputs.Subscribe<messages::TFMessage>("/tf", kTransforms, add_frames));
  if (!config.map.empty()) {
    TL_RETURN_IF_ERROR(
        topics->Subscribe<messages::OccupancyGrid>(config.map, dds::kLatched));
  }
  TL_RETURN_IF_ERROR(
      topics->Subscribe<messages::Odometry>(config.odom, dds::kSensorData));
  if (!config.scan.empty()) {
    TL_RETURN_IF_ERROR(
        topics->Subscribe<messages::LaserScan>(config.scan, dds::kSensorData));
  }
  TL_RETURN_IF_ERROR(topics->SubscribeCamera(config));
  TL_RETURN_IF_ERROR(inputs.Subscribe<messages::Empty>(
      "~/relocalize", {}, [&finder](const messages::Empty&) {
        finder.AskNow();
        return absl::OkStatus();
      }));
  TL_ASSIGN_OR_RETURN(
      topics->place_,
      node.Advertise(config.initial_pose,
                     messages::PoseWithCovarianceStamped::kName, {}));
  TL_ASSIGN_OR_RETURN(
      topics->diagnostics_,
      node.Advertise("/diagnostics", messages::DiagnosticArray::kName, {}));
  return topics;
}

absl::Status BridgeTopics::Publish(
    const messages::PoseWithCovarianceStamped& place) {
  return place_->Publish(messages::Encode(place));
}

absl::Status BridgeTopics::Publish(
    const messages::DiagnosticArray& diagnostics) {
  return diagnostics_->Publish(messages::Encode(diagnostics));
}

}  // namespace treeline::bridge_app
