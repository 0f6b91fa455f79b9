#include "nav_agent/app/bridge/bridge_topics.h"

#include <chrono>
#include <utility>

#include "common/base/sample_statistics.h"
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
// Of which delivery times are kept.
constexpr size_t kDeliveries = 10'000;
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

template <typename M, typename DeliverMessage>
absl::Status BridgeTopics::Subscribe(dds::Node& node, const std::string& topic,
                                     const dds::Quality& quality,
                                     DeliverMessage deliver) {
  TL_ASSIGN_OR_RETURN(std::unique_ptr<dds::Subscription> subscription,
                      node.Subscribe(topic, M::kName, quality));
  inputs_.push_back({.subscription = std::move(subscription),
                     .is_latched = quality.is_latched,
                     .deliver = [deliver](const dds::Sample& sample,
                                          place_finder::PlaceFinder& finder,
                                          RosClock& clock) -> absl::Status {
                       TL_ASSIGN_OR_RETURN(M message,
                                           messages::Decode<M>(sample.bytes));
                       return deliver(std::move(message), finder, clock);
                     }});
  return absl::OkStatus();
}

absl::Status BridgeTopics::SubscribeCamera(dds::Node& node,
                                           const BridgeConfig& config) {
  using place_finder::PlaceFinder;
  dds::Quality quality = dds::kSensorData;
  quality.is_reliable = config.reliable_pictures;
  const auto add_info = [](const messages::CameraInfo& info,
                           PlaceFinder& finder,
                           RosClock&) { return finder.camera().AddInfo(info); };
  const auto add_color = [](auto picture, PlaceFinder& finder, RosClock&) {
    finder.camera().AddColor(std::move(picture));
    return absl::OkStatus();
  };
  const auto add_depth = [](auto picture, PlaceFinder& finder, RosClock&) {
    finder.camera().AddDepth(std::move(picture));
    return absl::OkStatus();
  };
  TL_RETURN_IF_ERROR(Subscribe<messages::CameraInfo>(
      node, config.CameraInfoTopic(), dds::kSensorData, add_info));
  TL_RETURN_IF_ERROR(
      IsCompressed(config.image)
          ? Subscribe<messages::CompressedImage>(node, config.image, quality,
                                                 add_color)
          : Subscribe<messages::Image>(node, config.image, quality, add_color));
  if (config.depth.empty()) return absl::OkStatus();
  return IsCompressed(config.depth)
             ? Subscribe<messages::CompressedImage>(node, config.depth, quality,
                                                    add_depth)
             : Subscribe<messages::Image>(node, config.depth, quality,
                                          add_depth);
}

absl::StatusOr<std::unique_ptr<BridgeTopics>> BridgeTopics::Open(
    dds::Node& node, const BridgeConfig& config) {
  using place_finder::PlaceFinder;
  auto topics = std::make_unique<BridgeTopics>();
  const auto add = [](auto message, PlaceFinder& finder, RosClock&) {
    return finder.Add(message);
  };
  const auto add_frames = [](const messages::TFMessage& message,
                             PlaceFinder& finder, RosClock&) {
    finder.Add(message);
    return absl::OkStatus();
  };
  // In the order in which they are handed over: what tells of the robot before
  // what it saw.
  if (config.use_sim_time) {
    TL_RETURN_IF_ERROR(topics->Subscribe<messages::Clock>(
        node, "/clock", kClock,
        [](messages::Clock message, PlaceFinder&, RosClock& clock) {
          clock.Set(message);
          return absl::OkStatus();
        }));
  }
  TL_RETURN_IF_ERROR(topics->Subscribe<messages::TFMessage>(
      node, "/tf_static", kStaticTransforms, add_frames));
  TL_RETURN_IF_ERROR(topics->Subscribe<messages::TFMessage>(
      node, "/tf", kTransforms, add_frames));
  if (!config.map.empty()) {
    TL_RETURN_IF_ERROR(topics->Subscribe<messages::OccupancyGrid>(
        node, config.map, dds::kLatched, add));
  }
  TL_RETURN_IF_ERROR(topics->Subscribe<messages::Odometry>(
      node, config.odom, dds::kSensorData, add));
  if (!config.scan.empty()) {
    TL_RETURN_IF_ERROR(topics->Subscribe<messages::LaserScan>(
        node, config.scan, dds::kSensorData, add));
  }
  TL_RETURN_IF_ERROR(topics->SubscribeCamera(node, config));
  TL_RETURN_IF_ERROR(topics->Subscribe<messages::Empty>(
      node, "~/relocalize", {},
      [](messages::Empty, PlaceFinder& finder, RosClock&) {
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

void BridgeTopics::Deliver(place_finder::PlaceFinder& finder, RosClock& clock,
                           const BrokenMessage& on_broken) {
  for (const Input& input : inputs_) {
    for (const dds::Sample& sample : input.subscription->Take()) {
      ++delivered_;
      if (!input.is_latched) NoteDelivery(sample.written_ns);
      const absl::Status status = input.deliver(sample, finder, clock);
      if (!status.ok()) on_broken(input.subscription->topic(), status);
    }
  }
}

void BridgeTopics::NoteDelivery(int64_t written_ns) {
  const auto now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                          std::chrono::system_clock::now().time_since_epoch())
                          .count();
  const double ms = 1e-6 * static_cast<double>(now_ns - written_ns);
  if (delivery_ms_.size() < kDeliveries) {
    delivery_ms_.push_back(ms);
    return;
  }
  delivery_ms_[next_delivery_] = ms;
  next_delivery_ = (next_delivery_ + 1) % kDeliveries;
}

double BridgeTopics::Delivery_ms(double share) const {
  return base::Quantile(delivery_ms_, share);
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
