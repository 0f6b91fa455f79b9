// Messages of ROS 2 from anybody in the network: decoding never reads beyond
// the bytes, what was decoded can be encoded and comes back, and conversions
// take whatever was decoded. The first byte says which message it is.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/ros2/conversions/camera_values.h"
#include "common/ros2/conversions/frame_tree.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"

namespace {

namespace messages = treeline::messages;
namespace agent_values = treeline::agent_values;
namespace conversions = treeline::conversions;

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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span<const uint8_t> bytes(data + 1, size - 1);
  switch (data[0] % 10) {
    case 0:
      Try<messages::LaserScan>(bytes, [](const messages::LaserScan& scan) {
        (void)agent_values::SensorInfoOf(scan);
        (void)agent_values::ScanOf(scan);
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
    default:
      Try<messages::Path>(bytes, [](const messages::Path&) {});
      break;
  }
  return 0;
}
