// Messages of ours, read and written again by Fast DDS and Fast CDR in another
// process (fast_dds_peer.cc), come back byte for byte.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/ros2/messages/action_messages.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/dds/testing_domain.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

using messages::Header;

const int kDomain = dds::TestingDomain();
// No more is waited than the peer needs; on a busy machine, that is much.
constexpr auto kLongest = std::chrono::seconds(15);

class DdsInteropTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    peer_ = new Process({TREELINE_FAST_DDS_PEER, std::to_string(kDomain)});
    ASSERT_TRUE(peer_->WaitForLine("ready").has_value()) << peer_->err();
    auto domain = dds::Domain::Join({.id = kDomain, .interface = "lo"});
    ASSERT_TRUE(domain.ok()) << domain.status();
    domain_ = std::move(*domain).release();
    auto node = dds::Node::Create(*domain_, {});
    ASSERT_TRUE(node.ok()) << node.status();
    node_ = std::move(*node).release();
  }
  static void TearDownTestSuite() {
    delete node_;
    delete domain_;
    delete peer_;
  }

  template <typename M>
  static void ExpectEcho(const M& message) {
    ExpectEchoes(std::vector<M>{message});
  }
  template <typename M>
  static void ExpectEchoes(const std::vector<M>& all) {
    const std::string full = M::kName;
    const std::string name = full.substr(full.rfind('/') + 1) + "_";
    const dds::Quality quality = {.is_latched = true, .depth = 1};
    auto out = node_->Subscribe("/out/" + name, full, quality);
    auto in = node_->Advertise("/in/" + name, full, quality);
    ASSERT_TRUE(out.ok() && in.ok());
    for (const M& message : all) {
      const std::vector<uint8_t> sent = messages::Encode(message);
      ASSERT_TRUE((*in)->Publish(sent).ok());
      ASSERT_TRUE(node_->Wait(kLongest)) << full << "\n" << peer_->err();
      const std::vector<dds::Sample> samples = (*out)->Take();
      ASSERT_EQ(samples.size(), 1U) << full;
      std::vector<uint8_t> echoed = samples[0].bytes;
      // Fast DDS fills samples up to a multiple of four; the options in front
      // may say so.
      EXPECT_LT(echoed.size(), sent.size() + 4) << full;
      echoed.resize(sent.size());
      echoed[3] = 0;
      EXPECT_EQ(echoed, sent) << full;
      const auto decoded = messages::Decode<M>(samples[0].bytes);
      ASSERT_TRUE(decoded.ok()) << decoded.status();
      EXPECT_TRUE(*decoded == message) << full;
    }
  }

  static Process* peer_;
  static dds::Domain* domain_;
  static dds::Node* node_;
};

Process* DdsInteropTest::peer_ = nullptr;
dds::Domain* DdsInteropTest::domain_ = nullptr;
dds::Node* DdsInteropTest::node_ = nullptr;

const Header kHeader = {.stamp = {.sec = 1'700'000'000, .nanosec = 999'999'999},
                        .frame_id = "frame"};
const messages::Pose kPose = {
    .position = {.x = 1.5, .y = -2, .z = 1e-9},
    .orientation = {.x = 0.5, .y = 0.5, .z = -0.5, .w = 0.5}};

TEST_F(DdsInteropTest, CommonMessages) {
  ExpectEcho(kHeader);
  ExpectEcho(messages::Clock{.clock = kHeader.stamp});
  ExpectEcho(messages::DiagnosticArray{
      .header = kHeader,
      .status = {{.level = messages::DiagnosticStatus::kWarn,
                  .name = "treeline: lost",
                  .message = "maybe",
                  .hardware_id = "",
                  .values = {{"probability", "0.41"}, {"", "x"}}},
                 {.name = "second",
                  .message = "",
                  .hardware_id = "h",
                  .values = {}}}});
}

TEST_F(DdsInteropTest, GeometryMessages) {
  ExpectEcho(messages::Twist{.linear = {.x = 0.5, .y = 0, .z = 0},
                             .angular = {.x = 0, .y = 0, .z = -1}});
  ExpectEcho(messages::TwistStamped{.header = kHeader, .twist = {}});
  ExpectEcho(messages::PoseStamped{.header = kHeader, .pose = kPose});
  messages::PoseWithCovarianceStamped with;
  with.header = kHeader;
  with.pose.pose = kPose;
  for (size_t i = 0; i < 36; ++i) {
    with.pose.covariance[i] = static_cast<double>(i) / 8;
  }
  ExpectEcho(with);
  ExpectEcho(messages::TFMessage{
      .transforms = {
          {.header = kHeader, .child_frame_id = "laser", .transform = {}},
          {.header = {}, .child_frame_id = "c", .transform = {}}}});
}

TEST_F(DdsInteropTest, SensorMessages) {
  messages::LaserScan scan;
  scan.header = kHeader;
  scan.angle_min = -2.35F;
  scan.range_max = 30;
  for (int i = 0; i < 1081; ++i) {
    scan.ranges.push_back(static_cast<float>(i) / 64);
  }
  messages::LaserScan with_intensities = scan;
  with_intensities.intensities = scan.ranges;
  ExpectEchoes<messages::LaserScan>({scan, with_intensities});
  ExpectEcho(messages::PointCloud2{
      .header = kHeader,
      .height = 2,
      .width = 1,
      .fields = {{.name = "x", .offset = 0, .datatype = 7, .count = 1},
                 {.name = "intensity", .offset = 4, .datatype = 2, .count = 1}},
      .is_bigendian = false,
      .point_step = 5,
      .row_step = 5,
      .data = std::vector<uint8_t>(10, 7),
      .is_dense = true});
  messages::Image image = {.header = kHeader,
                           .height = 480,
                           .width = 640,
                           .encoding = "rgb8",
                           .is_bigendian = 0,
                           .step = 3 * 640,
                           .data = {}};
  for (size_t i = 0; i < size_t{3} * 640 * 480; ++i) {
    image.data.push_back(static_cast<uint8_t>(i % 251));
  }
  ExpectEcho(image);
  ExpectEcho(messages::CompressedImage{
      .header = kHeader, .format = "jpeg", .data = {0xff, 0xd8, 0xff}});
  messages::CameraInfo info;
  info.header = kHeader;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.k = {525, 0, 319.5, 0, 525, 239.5, 0, 0, 1};
  messages::CameraInfo distorted = info;
  distorted.d = {0.1, -0.2, 0, 0, 0.01};
  distorted.roi.do_rectify = true;
  // Without coefficients nothing is aligned for them.
  ExpectEchoes<messages::CameraInfo>({info, distorted});
}

TEST_F(DdsInteropTest, NavigationMessages) {
  messages::Odometry odometry;
  odometry.header = kHeader;
  odometry.child_frame_id = "base_footprint";
  odometry.pose.pose = kPose;
  odometry.twist.covariance[35] = 0.25;
  ExpectEcho(odometry);
  ExpectEcho(messages::OccupancyGrid{.header = kHeader,
                                     .info = {.map_load_time = kHeader.stamp,
                                              .resolution = 0.05F,
                                              .width = 3,
                                              .height = 1,
                                              .origin = kPose},
                                     .data = {0, 100, -1}});
  ExpectEcho(messages::Path{.header = kHeader,
                            .poses = {{.header = kHeader, .pose = kPose},
                                      {.header = {}, .pose = {}}}});
}

TEST_F(DdsInteropTest, ActionMessages) {
  messages::Uuid id;
  for (size_t i = 0; i < id.uuid.size(); ++i) {
    id.uuid[i] = static_cast<uint8_t>(0xa0 + i);
  }
  const messages::GoalInfo info = {.goal_id = id, .stamp = kHeader.stamp};
  // An odd number of bytes each: what follows is aligned.
  ExpectEcho(messages::GoalStatusArray{
      .status_list = {{.goal_info = info, .status = 2},
                      {.goal_info = info, .status = -1},
                      {.goal_info = {}, .status = 6}}});
  ExpectEcho(messages::CancelGoalRequest{.goal_info = info});
  ExpectEcho(messages::CancelGoalResponse{.return_code = 3,
                                          .goals_canceling = {info, {}}});
  ExpectEcho(messages::NavigateToPoseSendGoalRequest{
      .goal_id = id,
      .goal = {.pose = {.header = kHeader, .pose = kPose},
               .behavior_tree = "/opt/tree.xml"}});
  ExpectEcho(messages::NavigateToPoseSendGoalResponse{.accepted = true,
                                                      .stamp = kHeader.stamp});
  ExpectEcho(messages::NavigateToPoseGetResultRequest{.goal_id = id});
  ExpectEcho(messages::NavigateToPoseGetResultResponse{
      .status = 6, .result = {.error_code = 40'208, .error_msg = "no way"}});
  ExpectEcho(messages::NavigateToPoseFeedbackMessage{
      .goal_id = id,
      .feedback = {.current_pose = {.header = kHeader, .pose = kPose},
                   .navigation_time = {.sec = -3, .nanosec = 999'999'999},
                   .estimated_time_remaining = {.sec = 5, .nanosec = 6},
                   .number_of_recoveries = -7,
                   .distance_remaining = 2.5F}});
}

}  // namespace
}  // namespace treeline
