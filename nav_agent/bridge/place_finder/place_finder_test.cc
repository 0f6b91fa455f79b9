#include "nav_agent/bridge/place_finder/place_finder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/geometry/planar_pose.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/bridge/place_finder/place_report.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::place_finder {
namespace {

using ::testing::HasSubstr;

// Answers what it is told to.
class FakeServer final : public core::RelocalizationPort {
 public:
  void Ask(const core::RgbdFrame& frame, double /*timeout_s*/) override {
    stamp_ = frame.stamp;
    ++asked;
  }
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> TakeAnswer()
      override {
    if (!next.has_value()) return std::nullopt;
    auto answer = *std::move(next);
    next.reset();
    if (answer.ok()) answer->stamp = stamp_;
    return answer;
  }
  bool IsAsking() const override { return false; }
  void Cancel() override {}

  int asked = 0;
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> next;

 private:
  base::MonotonicTime stamp_;
};

geometry::Rigid3 Lifted(const geometry::Rigid2& pose) {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}),
          .translation = {pose.translation.x, pose.translation.y, 0}};
}

// A robot in localization's testing map, whose messages arrive ten times a
// second.
class PlaceFinderTest : public ::testing::Test {
 protected:
  static PlaceFinderOptions Options() {
    PlaceFinderOptions options;
    options.base_frame = "base";
    return options;
  }
  PlaceFinderTest() : map_(localization::TestingMap()) { Use(Options()); }

  void Use(const PlaceFinderOptions& options) {
    finder_ = std::make_unique<PlaceFinder>(server_, options);
    finder_->Add(messages::TFMessage{
        .transforms = {Edge("base", "camera", base_from_camera_),
                       Edge("base", "laser", base_from_laser_)}});
    messages::CameraInfo info;
    info.width = 2;
    info.height = 1;
    info.k = {2, 0, 0.5, 0, 2, 0, 0, 0, 1};
    ASSERT_TRUE(finder_->camera().AddInfo(info).ok());
  }

  messages::TransformStamped Edge(const std::string& parent,
                                  const std::string& child,
                                  const geometry::Rigid3& transform) const {
    return {.header = {.stamp = messages::TimeOf(now_ns_), .frame_id = parent},
            .child_frame_id = child,
            .transform = conversions::TransformOf(transform)};
  }

  // Where the robot is, and where its wheels think it is.
  geometry::Rigid2 MapFromBase() const {
    return map_from_odom_ * odom_from_base_;
  }

  void PutMap() {
    ASSERT_TRUE(finder_
                    ->Add(agent_values::MessageOf(
                        map_, {.stamp = {}, .frame_id = "map"}))
                    .ok());
  }

  // A tenth of a second in which the robot moves so in its own frame.
  PlaceFinder::Output Go(const geometry::Rigid2& way = {}) {
    now_ns_ += 100'000'000;
    odom_from_base_ = odom_from_base_ * way;
    const messages::Header header = {.stamp = messages::TimeOf(now_ns_),
                                     .frame_id = "odom"};
    messages::Odometry odometry;
    odometry.header = header;
    odometry.pose.pose = conversions::PoseOf(Lifted(odom_from_base_));
    EXPECT_TRUE(finder_->Add(odometry).ok());
    if (has_scan_) {
      core::LaserScan scan = localization::ScanOf(
          map_, localization::TestingLaser(),
          MapFromBase() * geometry::PlanarPose(base_from_laser_), 0.01,
          random_);
      scan.stamp = conversions::TimeOf(header.stamp);
      EXPECT_TRUE(finder_
                      ->Add(agent_values::MessageOf(
                          scan, localization::TestingLaser(), "laser"))
                      .ok());
    }
    finder_->camera().AddColor(
        messages::Image{.header = {.stamp = header.stamp, .frame_id = "camera"},
                        .height = 1,
                        .width = 2,
                        .encoding = "mono8",
                        .step = 2,
                        .data = {1, 2}});
    return finder_->Step(conversions::TimeOf(header.stamp));
  }

  // Until the server is asked, for a second at most.
  bool GoUntilAsked() {
    const int before = server_.asked;
    for (int i = 0; i < 10 && server_.asked == before; ++i) Go();
    return server_.asked > before;
  }

  // What a server says that saw the robot there.
  core::RelocalizationAnswer AnswerAt(const geometry::Rigid2& map_from_base,
                                      double confidence = 0.97) const {
    core::RelocalizationAnswer answer;
    answer.localized = true;
    answer.confidence = confidence;
    answer.confidence_threshold = 0.5;
    answer.map_from_camera = Lifted(map_from_base) * base_from_camera_;
    for (size_t i = 0; i < 6; ++i) answer.covariance[7 * i] = 1e-4;
    return answer;
  }

  static geometry::Rigid2 PoseIn(
      const messages::PoseWithCovarianceStamped& message) {
    return geometry::PlanarPose(
        conversions::RigidOf(message.pose.pose).value());
  }

  static void ExpectNear(const geometry::Rigid2& a, const geometry::Rigid2& b,
                         double tolerance_m, double tolerance_rad) {
    EXPECT_NEAR(a.translation.x, b.translation.x, tolerance_m);
    EXPECT_NEAR(a.translation.y, b.translation.y, tolerance_m);
    EXPECT_NEAR(geometry::NormalizedAngle_rad(a.yaw_rad - b.yaw_rad), 0,
                tolerance_rad);
  }

  const core::OccupancyGrid map_;
  const geometry::Rigid3 base_from_camera_ =
      core::RobotModel::UprightCamera({0.1, 0, 1}, 0.2);
  const geometry::Rigid3 base_from_laser_ = {.rotation = {},
                                             .translation = {0.2, 0, 0.3}};
  FakeServer server_;
  std::unique_ptr<PlaceFinder> finder_;
  base::Random random_{1, 2};
  int64_t now_ns_ = 1'700'000'000'000'000'000;
  geometry::Rigid2 map_from_odom_ = {{1, 2}, 0.7};
  geometry::Rigid2 odom_from_base_;
  bool has_scan_ = false;
};

TEST_F(PlaceFinderTest, WithALaserOneSureViewIsEnoughAndTheLaserMendsIt) {
  PutMap();
  has_scan_ = true;
  ASSERT_TRUE(GoUntilAsked());
  EXPECT_EQ(finder_->state().need, Need::kNoPlaceYet);
  geometry::Rigid2 off = MapFromBase();
  off.translation = off.translation + geometry::Vec2{0.08, -0.08};
  server_.next = AnswerAt(off);
  // Meanwhile the robot goes on: the place is that of the newest odometry.
  const PlaceFinder::Output output = Go({{0.05, 0}, 0.02});
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  EXPECT_EQ(output.initial_pose->header.frame_id, "map");
  EXPECT_EQ(messages::Nanoseconds(output.initial_pose->header.stamp), now_ns_);
  // The search's last step is a third of its 0.15 m.
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 0.06, 0.05);
  EXPECT_GT(output.initial_pose->pose.covariance[0], 0);
  EXPECT_GT(output.initial_pose->pose.covariance[35], 0);
  EXPECT_EQ(output.initial_pose->pose.covariance[14], 0);
  // Now it is known, and nobody is asked any more.
  EXPECT_FALSE(GoUntilAsked());
  EXPECT_EQ(finder_->state().need, Need::kNone);
}

TEST_F(PlaceFinderTest, WhatTheLaserContradictsIsNeverPublished) {
  PutMap();
  has_scan_ = true;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(GoUntilAsked());
    geometry::Rigid2 wrong = MapFromBase();
    wrong.translation = wrong.translation + geometry::Vec2{3, 0.5};
    server_.next = AnswerAt(wrong, 0.99);
    EXPECT_FALSE(Go().initial_pose.has_value());
  }
  EXPECT_EQ(finder_->state().refused, 5);
  EXPECT_TRUE(finder_->state().is_server_elsewhere);
  const auto report = ReportOf(finder_->state(), {});
  EXPECT_EQ(report.status[1].level, messages::DiagnosticStatus::kError);
  EXPECT_THAT(report.status[1].message, HasSubstr("map_from_world"));
}

TEST_F(PlaceFinderTest, WithoutALaserTwoDifferentViewsMustAgree) {
  ASSERT_TRUE(GoUntilAsked());
  server_.next = AnswerAt(MapFromBase());
  EXPECT_FALSE(Go().initial_pose.has_value());
  // The same view again says nothing new.
  ASSERT_TRUE(GoUntilAsked());
  server_.next = AnswerAt(MapFromBase());
  EXPECT_FALSE(Go().initial_pose.has_value());
  for (int i = 0; i < 5; ++i) Go({{}, 0.1});
  ASSERT_TRUE(server_.asked > 2 || GoUntilAsked());
  server_.next = AnswerAt(MapFromBase());
  const PlaceFinder::Output output = Go();
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 0.11, 0.11);
}

TEST_F(PlaceFinderTest, ViewsThatDisagreeAreNotTaken) {
  ASSERT_TRUE(GoUntilAsked());
  server_.next = AnswerAt(MapFromBase());
  Go();
  for (int i = 0; i < 5; ++i) Go({{}, 0.1});
  ASSERT_TRUE(server_.asked > 1 || GoUntilAsked());
  server_.next = AnswerAt({{5, 5}, 0});
  EXPECT_FALSE(Go().initial_pose.has_value());
}

TEST_F(PlaceFinderTest, OneViewIsEnoughForWhoSaysSo) {
  PlaceFinderOptions options = Options();
  options.is_one_view_enough = true;
  Use(options);
  ASSERT_TRUE(GoUntilAsked());
  server_.next = AnswerAt(MapFromBase(), 0.6);
  EXPECT_FALSE(Go().initial_pose.has_value()) << "the server is not sure";
  ASSERT_TRUE(GoUntilAsked());
  server_.next = AnswerAt(MapFromBase());
  EXPECT_TRUE(Go().initial_pose.has_value());
}

// Of a robot whose calibration is in a file: /tf may have it otherwise.
TEST_F(PlaceFinderTest, ACameraThatWasToldGoesBeforeTf) {
  PlaceFinderOptions options = Options();
  options.is_one_view_enough = true;
  // As far as a calibration and a drawing differ, nobody minds.
  options.base_from_camera = base_from_camera_;
  options.base_from_camera->translation.x += 0.01;
  Use(options);
  ASSERT_TRUE(GoUntilAsked());
  EXPECT_EQ(finder_->state().camera_dispute, "");
  options.base_from_camera->translation.x += 0.1;
  Use(options);
  std::vector<std::string> events;
  for (int i = 0; i < 10; ++i) {
    for (std::string& event : Go().events) events.push_back(std::move(event));
  }
  EXPECT_THAT(events,
              testing::Contains(HasSubstr(
                  "the camera (camera) is 11.0 cm and 0.0 degrees from where")))
      << events.size();
  EXPECT_EQ(ReportOf(finder_->state(), {}).status[1].values.back().key,
            "camera");
  server_.next = AnswerAt(MapFromBase());
  const PlaceFinder::Output output = Go();
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  const geometry::Rigid2 off =
      PoseIn(*output.initial_pose).Inverse() * MapFromBase();
  EXPECT_NEAR(off.translation.x, 0.11, 1e-6);
  EXPECT_NEAR(off.translation.y, 0, 1e-6);
}

TEST_F(PlaceFinderTest, PicturesWhoseStampsAreLateAreOfTheMomentBefore) {
  PlaceFinderOptions options = Options();
  options.is_one_view_enough = true;
  options.camera.delay_s = 0.1;
  Use(options);
  // A picture that is stamped now was taken a step ago, where the robot was
  // then.
  const geometry::Rigid2 way = {{0.05, 0}, 0};
  while (server_.asked == 0) {
    Go(way);
    ASSERT_LT(MapFromBase().translation.x, 20);
  }
  server_.next = AnswerAt(MapFromBase() * way.Inverse());
  const PlaceFinder::Output output = Go(way);
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 1e-6, 1e-6);
  options.camera.delay_s = 3;
  EXPECT_FALSE(options.Validate().ok());
}

TEST_F(PlaceFinderTest, GravityAndTheFloorAreWitnesses) {
  ASSERT_TRUE(GoUntilAsked());
  core::RelocalizationAnswer leaning = AnswerAt(MapFromBase());
  leaning.map_from_camera.rotation =
      geometry::Rotation3::FromAxisAngle({0.2, 0, 0}) *
      leaning.map_from_camera.rotation;
  server_.next = leaning;
  Go();
  EXPECT_THAT(finder_->state().last_fix, HasSubstr("against gravity"));
  ASSERT_TRUE(GoUntilAsked());
  core::RelocalizationAnswer flying = AnswerAt(MapFromBase());
  flying.map_from_camera.translation.z += 2;
  server_.next = flying;
  Go();
  EXPECT_THAT(finder_->state().last_fix, HasSubstr("not on free ground"));
  PutMap();
  ASSERT_TRUE(GoUntilAsked());
  // In the wall on the left, as the map lies.
  server_.next = AnswerAt(map_.map_from_grid * geometry::Rigid2{{0.05, 4}, 0});
  Go();
  EXPECT_THAT(finder_->state().last_fix, HasSubstr("not on free ground"));
}

TEST_F(PlaceFinderTest, TheWorldOfTheServerIsTurnedIntoTheMap) {
  PlaceFinderOptions options = Options();
  options.is_one_view_enough = true;
  options.map_from_world = Lifted({{4, -1}, 1.2});
  Use(options);
  ASSERT_TRUE(GoUntilAsked());
  core::RelocalizationAnswer answer = AnswerAt(MapFromBase());
  answer.map_from_camera =
      options.map_from_world.Inverse() * answer.map_from_camera;
  // Along x of the server's world it is not sure.
  answer.covariance[0] = 0.04;
  server_.next = answer;
  const PlaceFinder::Output output = Go();
  ASSERT_TRUE(output.initial_pose.has_value());
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 1e-6, 1e-6);
  const double s = std::sin(1.2);
  const double c = std::cos(1.2);
  EXPECT_NEAR(output.initial_pose->pose.covariance[7],
              0.04 * s * s + 1e-4 * c * c, 1e-9);
}

TEST_F(PlaceFinderTest, ALostRobotIsSeenAndAskedFor) {
  PutMap();
  has_scan_ = true;
  // AMCL believes what is true: nobody is asked.
  finder_->Add(messages::TFMessage{
      .transforms = {Edge("map", "odom", Lifted(map_from_odom_))}});
  for (int i = 0; i < 30; ++i) Go({{0.02, 0}, 0});
  EXPECT_EQ(server_.asked, 0);
  ASSERT_TRUE(finder_->state().verdict.has_value());
  EXPECT_EQ(finder_->state().verdict->state,
            localization::LostState::kLocalized);
  // Somebody carries the robot away; the wheels and AMCL do not notice.
  map_from_odom_ = {{7.5, 3}, -2};
  for (int i = 0; i < 100 && server_.asked == 0; ++i) Go({{0.02, 0}, 0.02});
  EXPECT_EQ(server_.asked, 1);
  EXPECT_EQ(finder_->state().need, Need::kLost);
  EXPECT_EQ(ReportOf(finder_->state(), {}).status[0].level,
            messages::DiagnosticStatus::kError);
  server_.next = AnswerAt(MapFromBase());
  const PlaceFinder::Output output = Go();
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 0.06, 0.05);
}

TEST_F(PlaceFinderTest, ErrorsOfTheServerAreToldAndItIsAskedAgain) {
  ASSERT_TRUE(GoUntilAsked());
  server_.next = absl::UnavailableError("no route");
  Go();
  const auto report = ReportOf(finder_->state(), {});
  EXPECT_EQ(report.status[0].level, messages::DiagnosticStatus::kStale);
  EXPECT_EQ(report.status[1].level, messages::DiagnosticStatus::kError);
  EXPECT_THAT(report.status[1].message, HasSubstr("no route"));
  EXPECT_TRUE(GoUntilAsked());
}

TEST_F(PlaceFinderTest, ASlowAnswerCountsFromWhereItsPictureWasTaken) {
  PlaceFinderOptions options = Options();
  options.is_one_view_enough = true;
  options.answer_timeout_s = 30;
  Use(options);
  ASSERT_TRUE(GoUntilAsked());
  const core::RelocalizationAnswer answer = AnswerAt(MapFromBase());
  // Longer than odometry is remembered.
  for (int i = 0; i < 120; ++i) Go({{0.02, 0}, 0.01});
  server_.next = answer;
  const PlaceFinder::Output output = Go();
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 1e-6, 1e-6);
}

TEST_F(PlaceFinderTest, WhatIsOfBeforeTheClockBeganAnewIsLeftOut) {
  PlaceFinderOptions options = Options();
  options.is_one_view_enough = true;
  Use(options);
  ASSERT_TRUE(GoUntilAsked());
  // A simulation begins anew: the robot is where it was at first, and so is
  // its odometry.
  const core::RelocalizationAnswer answer = AnswerAt({{4, 4}, 1});
  now_ns_ -= 30'000'000'000;
  odom_from_base_ = {};
  Go();
  server_.next = answer;
  EXPECT_FALSE(Go().initial_pose.has_value());
  // Nobody waits for the old clock's time.
  ASSERT_TRUE(GoUntilAsked());
  server_.next = AnswerAt(MapFromBase());
  const PlaceFinder::Output output = Go();
  ASSERT_TRUE(output.initial_pose.has_value()) << finder_->state().last_fix;
  ExpectNear(PoseIn(*output.initial_pose), MapFromBase(), 1e-6, 1e-6);
}

TEST_F(PlaceFinderTest, AClockThatGoesBackMakesNobodyWait) {
  ASSERT_TRUE(GoUntilAsked());
  server_.next = absl::UnavailableError("no route");
  Go();
  now_ns_ -= 30'000'000'000;
  EXPECT_TRUE(GoUntilAsked());
}

TEST_F(PlaceFinderTest, WhoAsksIsAnsweredThoughThePlaceIsKnown) {
  finder_->Add(messages::TFMessage{.transforms = {Edge("map", "odom", {})}});
  EXPECT_FALSE(GoUntilAsked());
  finder_->AskNow();
  EXPECT_TRUE(GoUntilAsked());
  EXPECT_EQ(finder_->state().need, Need::kAsked);
}

TEST_F(PlaceFinderTest, WhatIsMissingIsTold) {
  FakeServer server;
  PlaceFinder finder(server, Options());
  finder.Step(conversions::TimeOf({1, 0}));
  EXPECT_THAT(std::string(finder.state().obstacle.message()),
              HasSubstr("no odometry"));
  messages::Odometry odometry;
  odometry.header = {.stamp = {1, 0}, .frame_id = "odom"};
  ASSERT_TRUE(finder.Add(odometry).ok());
  finder.Step(conversions::TimeOf({1, 0}));
  EXPECT_THAT(std::string(finder.state().obstacle.message()),
              HasSubstr("camera_info"));
}

}  // namespace
}  // namespace treeline::place_finder
