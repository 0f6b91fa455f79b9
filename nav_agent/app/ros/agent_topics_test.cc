// Over DDS, with a robot and a person that this test plays.
#include "nav_agent/app/ros/agent_topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <numbers>
#include <thread>

#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/message_codec.h"
#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/dds/testing_domain.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::ros_app {
namespace {

// Nothing waits for it to pass.
constexpr auto kPatience = std::chrono::seconds(60);
constexpr auto kLook = std::chrono::milliseconds(10);

class AgentTopicsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.domain = {.id = dds::TestingDomain(), .interface = "lo"};
    auto robot =
        RosRobot::Open(config_, /*drives=*/true, real_clock_,
                       [this](const std::string& line) { Warn(line); });
    ASSERT_TRUE(robot.ok()) << robot.status();
    robot_ = *std::move(robot);
    auto node = dds::Node::Create(robot_->domain(), {.node = "player"});
    ASSERT_TRUE(node.ok()) << node.status();
    node_ = *std::move(node);
    frames_ = Advertise<messages::TFMessage>("/tf_static", dds::kLatched);
    odom_ = Advertise<messages::Odometry>("odom", {});
    scan_ = Advertise<messages::LaserScan>("scan", dds::kSensorData);
  }

  template <typename M>
  std::unique_ptr<dds::Publisher> Advertise(const std::string& topic,
                                            const dds::Quality& quality) {
    return node_->Advertise(topic, M::kName, quality).value();
  }
  template <typename M>
  std::unique_ptr<dds::Subscription> Listen(const std::string& topic,
                                            const dds::Quality& quality) {
    return node_->Subscribe(topic, M::kName, quality).value();
  }
  template <typename M>
  static void Send(dds::Publisher& publisher, const M& message) {
    ASSERT_TRUE(publisher.Publish(messages::Encode(message)).ok());
  }
  template <typename Holds>
  static bool Until(Holds holds) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!holds()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(kLook);
    }
    return true;
  }
  void Warn(const std::string& line) {
    const absl::MutexLock lock(&mutex_);
    warnings_ += line + "\n";
  }
  std::string warnings() {
    const absl::MutexLock lock(&mutex_);
    return warnings_;
  }

  messages::Time Now() const {
    return messages::TimeOf(robot_ports::SystemNow_ns());
  }
  void SendMount(const geometry::Rigid3& base_from_laser) {
    Send(*frames_,
         messages::TFMessage{
             .transforms = {
                 {.header = {.stamp = {}, .frame_id = "base_link"},
                  .child_frame_id = "laser",
                  .transform = conversions::TransformOf(base_from_laser)},
                 {.header = {.stamp = {}, .frame_id = "base_link"},
                  .child_frame_id = "base_footprint",
                  .transform = conversions::TransformOf(
                      {.rotation = {}, .translation = {0, 0, -0.1}})}}});
  }
  void SendSensors() {
    messages::Odometry odometry;
    odometry.header = {.stamp = Now(), .frame_id = "odom"};
    odometry.child_frame_id = "base_link";
    odometry.pose.pose.position.x = 3;
    Send(*odom_, odometry);
    messages::LaserScan scan;
    scan.header = {.stamp = Now(), .frame_id = "laser"};
    scan.angle_min = -1;
    scan.angle_increment = 0.5F;
    scan.range_max = 10;
    scan.ranges = {1, 2, 3, 4, 5};
    Send(*scan_, scan);
  }
  // Sends until the robot is known.
  absl::Status Know() {
    std::jthread sender([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        SendSensors();
        std::this_thread::sleep_for(kLook);
      }
    });
    return robot_->WaitUntilKnown({});
  }

  const base::SteadyClock real_clock_{};
  RosRobotConfig config_;
  absl::Mutex mutex_;
  std::string warnings_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<RosRobot> robot_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<dds::Publisher> frames_;
  std::unique_ptr<dds::Publisher> odom_;
  std::unique_ptr<dds::Publisher> scan_;
};

TEST_F(AgentTopicsTest, SensorsAreWhereTheRobotSays) {
  SendMount(
      {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, 0.3}) *
                   geometry::Rotation3::FromAxisAngle({std::numbers::pi, 0, 0}),
       .translation = {0.2, 0.05, 0.4}});
  ASSERT_TRUE(Know().ok());
  // Above the ground, and turned upside up.
  const geometry::Rigid3& laser = robot_->model().base_from_laser;
  EXPECT_NEAR(laser.translation.z, 0.5, 1e-9);
  EXPECT_NEAR((laser.rotation * geometry::Vec3{0, 0, 1}).z, 1, 1e-9);
  EXPECT_NEAR((laser.rotation * geometry::Vec3{1, 0, 0}).y, std::sin(0.3),
              1e-9);
  EXPECT_EQ(robot_->laser().TakeScans().at(0).ranges_m,
            std::vector<float>({5, 4, 3, 2, 1}));
  EXPECT_EQ(robot_->base().Health().state, core::DeviceState::kLost)
      << "nobody listens";
  const auto cmd_vel = Listen<messages::Twist>("cmd_vel", {});
  ASSERT_TRUE(Until([this] {
    return robot_->base().SetVelocity({.forward_mps = 0.5}).ok();
  }));
  ASSERT_TRUE(Until([&cmd_vel] { return !cmd_vel->Take().empty(); }));
  // Nobody renews it.
  ASSERT_TRUE(Until([&cmd_vel] {
    const std::vector<dds::Sample> samples = cmd_vel->Take();
    return !samples.empty() && *messages::Decode<messages::Twist>(
                                   samples.back().bytes) == messages::Twist();
  }));
}

TEST_F(AgentTopicsTest, ALaserThatLooksAtTheGroundIsRefused) {
  SendMount({.rotation = geometry::Rotation3::FromAxisAngle({0, 0.8, 0}),
             .translation = {}});
  const absl::Status status = Know();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition) << status;
}

TEST_F(AgentTopicsTest, GoalsAndPlacesComeInAndWhatHappensGoesOut) {
  SendMount({.rotation = {}, .translation = {0.2, 0, 0.2}});
  ASSERT_TRUE(Know().ok());
  agent_service::SteppingAgent agent(/*is_simulated=*/false);
  const auto topics = AgentTopics::Start(
      *robot_, agent.commands, [this](const std::string& line) { Warn(line); });
  ASSERT_TRUE(topics.ok()) << topics.status();
  const auto map = Listen<messages::OccupancyGrid>("map", dds::kLatched);
  const auto report = Listen<messages::DiagnosticArray>("/diagnostics", {});
  const auto goal = Advertise<messages::PoseStamped>("goal_pose", {});
  const auto place =
      Advertise<messages::PoseWithCovarianceStamped>("initialpose", {});
  const auto cancel = Advertise<messages::Empty>("/treeline/cancel", {});
  ASSERT_TRUE(Until([&] {
    return goal->matched() > 0 && place->matched() > 0 && cancel->matched() > 0;
  }));
  // A map for who comes late, and a report.
  std::vector<dds::Sample> maps;
  ASSERT_TRUE(Until([&] { return !(maps = map->Take()).empty(); }));
  const auto grid = messages::Decode<messages::OccupancyGrid>(maps[0].bytes);
  ASSERT_TRUE(grid.ok()) << grid.status();
  EXPECT_EQ(grid->header.frame_id, "map");
  EXPECT_EQ(grid->data.size(),
            agent.info.map->levels.levels[0].grid.cells.size());
  ASSERT_TRUE(Until([&] { return !report->Take().empty(); }));

  messages::PoseStamped elsewhere;
  elsewhere.header.frame_id = "odom";
  Send(*goal, elsewhere);
  messages::PoseStamped nowhere;
  nowhere.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  Send(*goal, nowhere);
  ASSERT_TRUE(Until([this] {
    return warnings().find("frame odom") != std::string::npos &&
           warnings().find("NaN") != std::string::npos;
  })) << warnings();

  messages::PoseStamped here;
  here.header.frame_id = "map";
  here.pose.position = {0.5, 0.5, 0};
  Send(*goal, here);
  const auto has_goal = [&] {
    bool has = false;
    EXPECT_TRUE(agent.hub
                    .Do([&has](behavior::Navigator& navigator) {
                      has = navigator.goal().has_value();
                      return absl::OkStatus();
                    })
                    .ok());
    return has;
  };
  EXPECT_TRUE(Until(has_goal));
  messages::PoseWithCovarianceStamped told;
  told.header.frame_id = "map";
  told.pose.pose.position = {0.4, 0.3, 0};
  Send(*place, told);
  EXPECT_TRUE(Until([&] {
    bool is_told = false;
    EXPECT_TRUE(agent.hub
                    .Do([&is_told](behavior::Navigator& navigator) {
                      is_told = navigator.Snapshot().pose.has_value();
                      return absl::OkStatus();
                    })
                    .ok());
    return is_told;
  }));
}

class ActionTest : public AgentTopicsTest {
 protected:
  ActionTest() { config_.rmw = Rmw::kCyclone; }
};

TEST_F(ActionTest, GoalsAreSentAsActions) {
  SendMount({.rotation = {}, .translation = {0.2, 0, 0.2}});
  ASSERT_TRUE(Know().ok());
  agent_service::SteppingAgent agent(/*is_simulated=*/false);
  const auto topics = AgentTopics::Start(
      *robot_, agent.commands, [this](const std::string& line) { Warn(line); });
  ASSERT_TRUE(topics.ok()) << topics.status();
  dds::TestingClient send_goal(robot_->domain(),
                               "/navigate_to_pose/_action/send_goal",
                               "nav2_msgs/action/NavigateToPose_SendGoal");
  dds::TestingClient get_result(robot_->domain(),
                                "/navigate_to_pose/_action/get_result",
                                "nav2_msgs/action/NavigateToPose_GetResult");
  ASSERT_TRUE(
      Until([&] { return send_goal.IsMatched() && get_result.IsMatched(); }));
  const auto send = [&](uint8_t id, const std::string& frame, double x) {
    messages::NavigateToPoseSendGoalRequest request;
    request.goal_id.uuid[0] = id;
    request.goal.pose.header.frame_id = frame;
    request.goal.pose.pose.position = {x, 0.5, 0};
    const int64_t asked = send_goal.Ask(messages::Encode(request));
    std::optional<std::vector<uint8_t>> reply;
    EXPECT_TRUE(
        Until([&] { return (reply = send_goal.ReplyTo(asked)).has_value(); }));
    if (!reply.has_value()) return false;
    return messages::Decode<messages::NavigateToPoseSendGoalResponse>(*reply)
        ->accepted;
  };
  EXPECT_FALSE(send(1, "odom", 0.5));
  EXPECT_FALSE(send(2, "map", std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(send(3, "map", 1e9));
  EXPECT_TRUE(Until([this] {
    return warnings().find("rejected: a pose in the frame odom") !=
               std::string::npos &&
           warnings().find("NaN") != std::string::npos;
  })) << warnings();
  EXPECT_TRUE(send(4, "map", 0.5));
  messages::NavigateToPoseGetResultRequest wanted;
  wanted.goal_id.uuid[0] = 4;
  const int64_t asked = get_result.Ask(messages::Encode(wanted));
  std::optional<std::vector<uint8_t>> reply;
  ASSERT_TRUE(
      Until([&] { return (reply = get_result.ReplyTo(asked)).has_value(); }));
  EXPECT_EQ(messages::Decode<messages::NavigateToPoseGetResultResponse>(*reply)
                ->status,
            messages::GoalStatus::kSucceeded);
  // Stopped, it takes none.
  ASSERT_TRUE(agent.commands.Stop("for a test").ok());
  EXPECT_FALSE(send(5, "map", 0.5));
}

}  // namespace
}  // namespace treeline::ros_app
