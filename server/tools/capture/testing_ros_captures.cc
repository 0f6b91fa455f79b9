#include "server/tools/capture/testing_ros_captures.h"

#include <algorithm>
#include <cstring>

#include "common/image/decode.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::capture {
namespace {

constexpr int64_t kStart_ns = 1'700'000'000'123'456'789;
constexpr int64_t kInterval_ns = 66'000'000;
constexpr int64_t kDepthDelay_ns = 5'000'000;
constexpr const char* kColorFrame = "camera_color_optical_frame";
constexpr const char* kDepthFrame = "camera_depth_optical_frame";

// On a robot: 0.3 m ahead and 0.8 m up, looking forward.
geometry::Rigid3 BaseFromCamera() {
  const geometry::Mat3 axes = {{0, 0, 1, -1, 0, 0, 0, -1, 0}};
  return {geometry::Rotation3::FromMatrix(axes), {0.3, 0.05, 0.8}};
}

class Recorder {
 public:
  Recorder(const TrueScene& scene, const RosRecorder& recorder)
      : scene_(scene), recorder_(recorder) {}

  std::vector<bag::TestingMessage> Record() {
    AddStatic();
    for (size_t i = 0; i < scene_.frames.size(); ++i) {
      const int64_t time_ns =
          kStart_ns + kInterval_ns * static_cast<int64_t>(i);
      AddPose(time_ns, scene_.world_from_camera[i]);
      // Half-way there; whoever takes the nearest pose errs.
      if (i + 1 < scene_.frames.size()) {
        const geometry::Rigid3& a = scene_.world_from_camera[i];
        const geometry::Rigid3& b = scene_.world_from_camera[i + 1];
        AddPose(time_ns + kInterval_ns / 2,
                {geometry::Slerp(a.rotation, b.rotation, 0.5),
                 0.5 * (a.translation + b.translation)});
      }
      AddColor(time_ns, scene_.frames[i]);
      if (!recorder_.depth.empty()) {
        AddDepth(time_ns + kDepthDelay_ns, *scene_.frames[i].depth);
      }
    }
    std::ranges::stable_sort(messages_, {}, &bag::TestingMessage::time_ns);
    return std::move(messages_);
  }

 private:
  template <typename M>
  void Add(const char* topic, int64_t time_ns, const M& message) {
    messages_.push_back(bag::Recorded(topic, time_ns, message));
  }

  static messages::Header HeaderOf(int64_t time_ns, const char* frame) {
    return {.stamp = messages::TimeOf(time_ns), .frame_id = frame};
  }

  bool HasOwnDepthFrame() const {
    return !(recorder_.color_from_depth == geometry::Rigid3());
  }

  void AddStatic() {
    messages::TFMessage tf;
    tf.transforms.push_back(
        {.header = HeaderOf(kStart_ns, "base_link"),
         .child_frame_id = kColorFrame,
         .transform = conversions::TransformOf(BaseFromCamera())});
    if (HasOwnDepthFrame()) {
      tf.transforms.push_back(
          {.header = HeaderOf(kStart_ns, kColorFrame),
           .child_frame_id = kDepthFrame,
           .transform = conversions::TransformOf(recorder_.color_from_depth)});
    }
    Add("/tf_static", kStart_ns - 1'000'000'000, tf);
  }

  void AddPose(int64_t time_ns, const geometry::Rigid3& world_from_camera) {
    const geometry::Rigid3 world_from_base =
        world_from_camera * BaseFromCamera().Inverse();
    if (recorder_.poses == "tf") {
      Add("/tf", time_ns,
          messages::TFMessage{
              {{.header = HeaderOf(time_ns, "map"),
                .child_frame_id = "base_link",
                .transform = conversions::TransformOf(world_from_base)}}});
    } else if (recorder_.poses == "odometry") {
      messages::Odometry odometry;
      odometry.header = HeaderOf(time_ns, "odom");
      odometry.child_frame_id = "base_link";
      odometry.pose.pose = conversions::PoseOf(world_from_base);
      Add("/odom", time_ns, odometry);
    } else {
      Add("/camera_pose", time_ns,
          messages::PoseStamped{
              .header = HeaderOf(time_ns, "world"),
              .pose = conversions::PoseOf(world_from_camera)});
    }
  }

  void AddCamera(const char* topic, int64_t time_ns, const char* frame,
                 const camera::Camera& camera) {
    messages::CameraInfo info;
    info.header = HeaderOf(time_ns, frame);
    info.width = static_cast<uint32_t>(camera.width());
    info.height = static_cast<uint32_t>(camera.height());
    info.distortion_model = "plumb_bob";
    info.d = {0, 0, 0, 0, 0};
    info.k = {camera.fx(), 0, camera.cx(), 0, camera.fy(),
              camera.cy(), 0, 0,           1};
    info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    info.p = {camera.fx(), 0, camera.cx(), 0, 0, camera.fy(),
              camera.cy(), 0, 0,           0, 1, 0};
    Add(topic, time_ns, info);
  }

  void AddColor(int64_t time_ns, const image::Frame& frame) {
    AddCamera("/camera/color/camera_info", time_ns, kColorFrame,
              scene_.calibration.color);
    if (recorder_.color == "jpeg") {
      const std::string jpeg = image::EncodeJpeg(frame.color, 98).value();
      messages::CompressedImage image;
      image.header = HeaderOf(time_ns, kColorFrame);
      image.format = "rgb8; jpeg compressed bgr8";
      image.data.assign(jpeg.begin(), jpeg.end());
      Add("/camera/color/image_raw/compressed", time_ns, image);
      return;
    }
    messages::Image image;
    image.header = HeaderOf(time_ns, kColorFrame);
    image.width = static_cast<uint32_t>(frame.color.width);
    image.height = static_cast<uint32_t>(frame.color.height);
    image.encoding = recorder_.color;
    image.step = 3 * image.width;
    image.data = frame.color.rgb;
    if (recorder_.color == "bgr8") {
      for (size_t p = 0; p < image.data.size(); p += 3) {
        std::swap(image.data[p], image.data[p + 2]);
      }
    }
    Add("/camera/color/image_raw", time_ns, image);
  }

  void AddDepth(int64_t time_ns, const image::DepthImage& depth) {
    const char* frame = HasOwnDepthFrame() ? kDepthFrame : kColorFrame;
    AddCamera("/camera/depth/camera_info", time_ns, frame,
              scene_.calibration.depth);
    if (recorder_.depth == "compressedDepth") {
      const std::string png = image::EncodeDepthPng(depth).value();
      messages::CompressedImage image;
      image.header = HeaderOf(time_ns, frame);
      image.format = "16UC1; compressedDepth png";
      image.data.assign(12, 0);
      image.data.insert(image.data.end(), png.begin(), png.end());
      Add("/camera/depth/image_raw/compressedDepth", time_ns, image);
      return;
    }
    messages::Image image;
    image.header = HeaderOf(time_ns, frame);
    image.width = static_cast<uint32_t>(depth.width);
    image.height = static_cast<uint32_t>(depth.height);
    image.encoding = recorder_.depth;
    const auto append = [&image](auto value) {
      const size_t at = image.data.size();
      image.data.resize(at + sizeof(value));
      std::memcpy(image.data.data() + at, &value, sizeof(value));
    };
    for (const uint16_t depth_mm : depth.values) {
      if (recorder_.depth == "32FC1") {
        append(static_cast<float>(depth_mm) / 1000);
      } else {
        append(depth_mm);
      }
    }
    image.step = static_cast<uint32_t>(image.data.size()) / image.height;
    Add("/camera/depth/image_raw", time_ns, image);
  }

  const TrueScene& scene_;
  const RosRecorder& recorder_;
  std::vector<bag::TestingMessage> messages_;
};

}  // namespace

std::vector<bag::TestingMessage> RosMessages(const TrueScene& scene,
                                             const RosRecorder& recorder) {
  return Recorder(scene, recorder).Record();
}

void WriteRosMcap(const TrueScene& scene, const std::string& path) {
  bag::WriteMcapBag(RosMessages(scene, {}), "lz4", path);
}

void WriteRosMcapFolder(const TrueScene& scene, const std::string& path) {
  bag::WriteBagFolder(RosMessages(scene, {.color = "jpeg",
                                          .depth = "compressedDepth",
                                          .poses = "odometry"}),
                      "mcap", path);
}

void WriteRosSqlite(const TrueScene& scene, const std::string& path) {
  bag::WriteBagFolder(
      RosMessages(scene, {.color = "rgb8", .depth = "32FC1", .poses = "pose"}),
      "sqlite3", path);
}

void WriteRos1(const TrueScene& scene, const std::string& path) {
  bag::WriteRos1Bag(
      RosMessages(scene, {.color = "bgr8", .depth = "32FC1", .poses = "tf"}),
      "bz2", /*has_index=*/true, path);
}

}  // namespace treeline::capture
