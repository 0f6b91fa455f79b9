// Writes a bag whose contents another program can foretell:
//   mcap_sample PACKING FILE.mcap|FILE.bag [COUNT]
// COUNT (200) messages of each of three topics, 10 ms apart. PACKING: for MCAP
// "none", "lz4" or "zstd", for .bag "none", "bz2" or "lz4".
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/ros2/bag/testing_bags.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline {
namespace {

constexpr int64_t kStart_ns = 1'700'000'000'000'000'000;
constexpr int64_t kInterval_ns = 10'000'000;

messages::Header HeaderOf(int64_t time_ns, const char* frame) {
  return {.stamp = messages::TimeOf(time_ns), .frame_id = frame};
}

std::vector<bag::TestingMessage> Recording(int count) {
  std::vector<bag::TestingMessage> recording;
  for (int i = 0; i < count; ++i) {
    const int64_t time_ns = kStart_ns + kInterval_ns * i;
    messages::LaserScan scan;
    scan.header = HeaderOf(time_ns, "laser");
    scan.angle_increment = 0.25;
    for (int beam = 0; beam < 90; ++beam) {
      scan.ranges.push_back(static_cast<float>(i) +
                            static_cast<float>(beam) / 4);
    }
    recording.push_back(bag::Recorded("/scan", time_ns, scan));
    messages::Odometry odometry;
    odometry.header = HeaderOf(time_ns, "odom");
    odometry.child_frame_id = "base_link";
    odometry.pose.pose.position.x = 0.5 * i;
    odometry.pose.covariance[35] = 0.25;
    odometry.twist.twist.angular.z = -1;
    recording.push_back(bag::Recorded("/odom", time_ns + 1, odometry));
    messages::TransformStamped transform;
    transform.header = HeaderOf(time_ns, "map");
    transform.child_frame_id = "odom";
    transform.transform.translation.y = i;
    recording.push_back(bag::Recorded(
        "/tf", time_ns + 2, messages::TFMessage{.transforms = {transform}}));
  }
  return recording;
}

int Main(const std::string& packing, const std::string& path, int count) {
  const auto recording = Recording(count);
  if (path.size() > 4 && path.substr(path.size() - 4) == ".bag") {
    bag::WriteRos1Bag(recording, packing, /*has_index=*/true, path);
  } else {
    bag::WriteMcapBag(recording, packing == "none" ? "" : packing, path);
  }
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "mcap_sample PACKING FILE [COUNT]\n");
    return 2;
  }
  return treeline::Main(argv[1], argv[2], argc > 3 ? std::atoi(argv[3]) : 200);
}
