// Messages of ROS 2 from anybody in the network: decoding never reads beyond
// the bytes, what was decoded can be encoded and comes back, and conversions
// take whatever was decoded. The first byte says which message it is.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/ros2/conversions/camera_values.h"
#include "common/ros2/conversions/frame_tree.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/action_messages.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/bridge/robot_ports/laser_port.h"
#include "nav_agent/bridge/robot_ports/odometry_port.h"

namespace {

namespace messages = treeline::messages;
namespace agent_values = treeline::agent_values;
namespace conversions = treeline::conversions;
namespace robot_ports = treeline::robot_ports;

template <typename M, typename Use>
void Try(std::span<const uint8_t> bytes, const Use& use) {
  const auto message = messages::Decode<M>(bytes);
  if (!message.ok()) return;
  // Bytes, as numbers that are none differ from themselves.
  const auto again = messages::Encode(*message);
  const auto decoded = messages::Decode<M>(again);
  if (!decoded.ok() || messages::Encode(*decoded) != again) std::abort();
  use(*message);
}

// What a port hands over has the beams that it says, whatever came before.
void TryLaser(const messages::LaserScan& scan) {
  const treeline::base::SteadyClock clock;
  const robot_ports::RosTime time(false, clock, [] { return int64_t{0}; });
  messages::LaserScan usual;
  usual.angle_min = -1;
  usual.angle_increment = 0.1F;
  usual.range_max = 10;
  usual.ranges.assign(21, 1);
  for (const bool is_first : {true, false}) {
    robot_ports::LaserPort port("scan", time, clock);
    if (is_first) port.SetUpsideDown();
    (void)port.Add(is_first ? scan : usual);
    (void)port.Add(is_first ? usual : scan);
    for (const auto& taken : port.TakeScans()) {
      if (taken.ranges_m.size() != static_cast<size_t>(port.Info().beams) ||
          (!taken.intensities.empty() &&
           taken.intensities.size() != taken.ranges_m.size())) {
        std::abort();
      }
    }
  }
}

// Wheels stay finite, wherever the robot is said to be.
void TryOdometry(const messages::Odometry& odometry) {
  const treeline::base::SteadyClock clock;
  const robot_ports::RosTime time(false, clock, [] { return int64_t{0}; });
  robot_ports::OdometryPort port("odom", 0.5, time, clock);
  (void)port.Add(messages::Odometry(), {});
  (void)port.Add(odometry, {});
  for (const auto& reading : port.TakeReadings()) {
    if (!std::isfinite(reading.left_wheel_m + reading.right_wheel_m +
                       reading.forward_mps + reading.yaw_rate_radps +
                       reading.pitch_rad + reading.roll_rad)) {
      std::abort();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span<const uint8_t> bytes(data + 1, size - 1);
  switch (data[0] % 12) {
    case 0:
      Try<messages::LaserScan>(bytes, [](const messages::LaserScan& scan) {
        (void)agent_values::SensorInfoOf(scan);
        (void)agent_values::ScanOf(scan);
        TryLaser(scan);
      });
      break;
    case 1:
      Try<messages::Image>(bytes, [](const messages::Image& image) {
        (void)conversions::ColorOf(image);
        (void)conversions::DepthOf(image);
      });
      break;
    case 2:
      Try<messages::CompressedImage>(
          bytes, [](const messages::CompressedImage& image) {
            (void)conversions::ColorOf(image);
            (void)conversions::DepthOf(image);
          });
      break;
    case 3:
      Try<messages::CameraInfo>(bytes, [](const messages::CameraInfo& info) {
        (void)conversions::CameraOf(info, false);
        (void)conversions::CameraOf(info, true);
      });
      break;
    case 4:
      Try<messages::Odometry>(bytes, [](const messages::Odometry& odometry) {
        (void)conversions::RigidOf(odometry.pose.pose);
        TryOdometry(odometry);
      });
      break;
    case 5:
      Try<messages::OccupancyGrid>(bytes,
                                   [](const messages::OccupancyGrid& grid) {
                                     (void)agent_values::GridOf(grid);
                                   });
      break;
    case 6:
      Try<messages::TFMessage>(bytes, [](const messages::TFMessage& message) {
        conversions::FrameTree tree;
        tree.Add(message);
        (void)tree.Find("a", "b");
      });
      break;
    case 7:
      Try<messages::PointCloud2>(bytes, [](const messages::PointCloud2&) {});
      break;
    case 8:
      Try<messages::DiagnosticArray>(bytes,
                                     [](const messages::DiagnosticArray&) {});
      break;
    case 9:
      Try<messages::Path>(bytes, [](const messages::Path&) {});
      break;
    case 10:
      Try<messages::NavigateToPoseSendGoalRequest>(
          bytes, [](const messages::NavigateToPoseSendGoalRequest& request) {
            (void)conversions::RigidOf(request.goal.pose.pose);
          });
      break;
    default:
      Try<messages::CancelGoalRequest>(
          bytes, [](const messages::CancelGoalRequest&) {});
      break;
  }
  return 0;
}
