// A robot that is known over DDS alone, as Nav2 drives one: wheels, a laser and
// a camera, a map, and a localization that follows what comes on /initialpose.
// It drives in the small map of localization's tests, is carried away once, and
// says how far its localization is off.
//
//   robot_player DOMAIN SECONDS KIDNAP_AT BEAMS PICTURE_BYTES [/namespace]
//
// KIDNAP_AT: seconds after which it is elsewhere; -1: never. Pictures are 8 x 1
// pixels that hold the truth as three doubles, then as many bytes as
// PICTURE_BYTES says, which a reader of pictures skips.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include "common/base/random.h"
#include "common/geometry/planar_pose.h"
#include "common/geometry/rigid3.h"
#include "common/image/decode.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr double kForward_mps = 0.15;
constexpr double kTurn_radps = 0.4;

geometry::Rigid3 Lifted(const geometry::Rigid2& pose) {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}),
          .translation = {pose.translation.x, pose.translation.y, 0}};
}

class RobotPlayer {
 public:
  RobotPlayer(dds::Node& node, int beams, size_t picture_bytes)
      : node_(node), picture_bytes_(picture_bytes) {
    laser_.beams = beams;
    laser_.angle_increment_rad = 3.0 / (beams - 1);
  }

  void Play(double seconds, double kidnap_at_s) {
    Advertise();
    const auto begin = steady_clock::now();
    double last_s = 0;
    double next_scan_s = 0;
    double next_picture_s = 0;
    bool is_kidnapped = kidnap_at_s < 0;
    for (int step = 0;; ++step) {
      // 200 steps a second; wheels speak every fourth time.
      std::this_thread::sleep_until(begin + step * milliseconds(5));
      const double now_s =
          std::chrono::duration<double>(steady_clock::now() - begin).count();
      if (now_s > seconds) break;
      odom_from_base_ = odom_from_base_ *
                        geometry::Rigid2{{kForward_mps * (now_s - last_s), 0},
                                         kTurn_radps * (now_s - last_s)};
      last_s = now_s;
      if (!is_kidnapped && now_s >= kidnap_at_s) {
        // The wheels notice nothing.
        map_from_odom_ =
            geometry::Rigid2{{7.5, 3}, -2} * odom_from_base_.Inverse();
        is_kidnapped = true;
        std::printf("kidnapped\n");
        std::fflush(stdout);
      }
      if (step % 4 == 0) PublishOdometry();
      if (now_s >= next_scan_s) {
        next_scan_s += 1.0 / 40;
        PublishScan();
      }
      if (now_s >= next_picture_s) {
        next_picture_s += 1.0 / 15;
        PublishPicture();
      }
      TakePlaces();
    }
  }

 private:
  template <typename M>
  std::unique_ptr<dds::Publisher> Make(const std::string& topic,
                                       const dds::Quality& quality) {
    return node_.Advertise(topic, M::kName, quality).value();
  }
  template <typename M>
  static void Send(dds::Publisher& publisher, const M& message) {
    if (!publisher.Publish(messages::Encode(message)).ok()) std::abort();
  }
  messages::Header Now(const std::string& frame) const {
    return {.stamp = messages::TimeOf(
                std::chrono::duration_cast<std::chrono::nanoseconds>(
                    std::chrono::system_clock::now().time_since_epoch())
                    .count()),
            .frame_id = frame};
  }
  geometry::Rigid2 MapFromBase() const {
    return map_from_odom_ * odom_from_base_;
  }

  void Advertise() {
    static_frames_ = Make<messages::TFMessage>("/tf_static", dds::kLatched);
    Send(*static_frames_,
         messages::TFMessage{
             .transforms = {
                 {.header = Now("base_footprint"),
                  .child_frame_id = "laser",
                  .transform = conversions::TransformOf(base_from_laser_)},
                 {.header = Now("base_footprint"),
                  .child_frame_id = "optical",
                  .transform = conversions::TransformOf(base_from_camera_)}}});
    map_publisher_ = Make<messages::OccupancyGrid>("map", dds::kLatched);
    Send(*map_publisher_, agent_values::MessageOf(map_, Now("map")));
    odom_ = Make<messages::Odometry>("odom", {});
    frames_ = Make<messages::TFMessage>("/tf", {.depth = 100});
    scan_ = Make<messages::LaserScan>("scan", dds::kSensorData);
    info_ = Make<messages::CameraInfo>("camera/camera_info", dds::kSensorData);
    picture_ = Make<messages::CompressedImage>("camera/image_raw/compressed",
                                               dds::kSensorData);
    places_ = node_
                  .Subscribe("initialpose",
                             messages::PoseWithCovarianceStamped::kName, {})
                  .value();
  }

  void PublishOdometry() {
    messages::Odometry odometry;
    odometry.header = Now("odom");
    odometry.child_frame_id = "base_footprint";
    odometry.pose.pose = conversions::PoseOf(Lifted(odom_from_base_));
    odometry.twist.twist.linear.x = kForward_mps;
    odometry.twist.twist.angular.z = kTurn_radps;
    Send(*odom_, odometry);
    if (!has_place_) return;
    Send(*frames_, messages::TFMessage{
                       .transforms = {{.header = Now("map"),
                                       .child_frame_id = "odom",
                                       .transform = conversions::TransformOf(
                                           Lifted(believed_map_from_odom_))}}});
  }

  void PublishScan() {
    core::LaserScan scan = localization::ScanOf(
        map_, laser_, MapFromBase() * geometry::PlanarPose(base_from_laser_),
        0.01, random_);
    messages::LaserScan message =
        agent_values::MessageOf(scan, laser_, "laser");
    message.header = Now("laser");
    Send(*scan_, message);
  }

  void PublishPicture() {
    messages::CameraInfo info;
    info.header = Now("optical");
    info.width = 8;
    info.height = 1;
    info.k = {8, 0, 3.5, 0, 8, 0, 0, 0, 1};
    Send(*info_, info);
    // A picture without compression: binary PPM would do, PNG is understood.
    messages::CompressedImage picture;
    picture.header = info.header;
    picture.format = "png";
    const geometry::Rigid2 truth = MapFromBase();
    const std::array<double, 3> values = {truth.translation.x,
                                          truth.translation.y, truth.yaw_rad};
    image::ColorImage color = {.width = 8, .height = 1, .rgb = {}};
    color.rgb.resize(24);
    std::memcpy(color.rgb.data(), values.data(), 24);
    const std::string png = image::EncodePng(color).value();
    picture.data.assign(png.begin(), png.end());
    picture.data.resize(std::max(picture.data.size(), picture_bytes_));
    Send(*picture_, picture);
  }

  void TakePlaces() {
    for (const dds::Sample& sample : places_->Take()) {
      const auto place =
          messages::Decode<messages::PoseWithCovarianceStamped>(sample.bytes);
      if (!place.ok()) std::abort();
      const geometry::Rigid2 told =
          geometry::PlanarPose(conversions::RigidOf(place->pose.pose).value());
      // As AMCL takes it; the little way since then is left out.
      believed_map_from_odom_ = told * odom_from_base_.Inverse();
      has_place_ = true;
      const geometry::Rigid2 off = told.Inverse() * MapFromBase();
      std::printf("place off %.3f m %.3f rad\n",
                  geometry::Norm(off.translation), std::abs(off.yaw_rad));
      std::fflush(stdout);
    }
  }

  dds::Node& node_;
  const size_t picture_bytes_;
  const core::OccupancyGrid map_ = localization::TestingMap();
  core::RangeSensorInfo laser_ = localization::TestingLaser();
  const geometry::Rigid3 base_from_laser_ = {.rotation = {},
                                             .translation = {0.2, 0, 0.3}};
  const geometry::Rigid3 base_from_camera_ =
      core::RobotModel::UprightCamera({0.1, 0, 1}, 0.2);
  base::Random random_{3, 4};
  geometry::Rigid2 map_from_odom_ = {{1, 2}, 0.7};
  geometry::Rigid2 odom_from_base_;
  geometry::Rigid2 believed_map_from_odom_;
  bool has_place_ = false;
  std::unique_ptr<dds::Publisher> static_frames_;
  std::unique_ptr<dds::Publisher> map_publisher_;
  std::unique_ptr<dds::Publisher> odom_;
  std::unique_ptr<dds::Publisher> frames_;
  std::unique_ptr<dds::Publisher> scan_;
  std::unique_ptr<dds::Publisher> info_;
  std::unique_ptr<dds::Publisher> picture_;
  std::unique_ptr<dds::Subscription> places_;
};

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  if (argc != 6 && argc != 7) {
    std::fprintf(stderr,
                 "usage: %s DOMAIN SECONDS KIDNAP_AT BEAMS PICTURE_BYTES "
                 "[NAMESPACE]\n",
                 argv[0]);
    return 2;
  }
  using treeline::dds::Domain;
  using treeline::dds::Node;
  const auto domain =
      Domain::Join({.id = std::atoi(argv[1]), .interface = "lo"});
  if (!domain.ok()) return 1;
  const auto node = Node::Create(
      **domain, {.name_space = argc == 7 ? argv[6] : "", .node = "player"});
  if (!node.ok()) return 1;
  treeline::RobotPlayer player(**node, std::atoi(argv[4]),
                               static_cast<size_t>(std::atoi(argv[5])));
  player.Play(std::atof(argv[2]), std::atof(argv[3]));
  return 0;
}
