#include "nav_agent/rgbd_slam/rgbd_slam.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "common/dataset/trajectory_error.h"
#include "gtest/gtest.h"
#include "nav_agent/rgbd_slam/testing_room.h"

namespace treeline::rgbd_slam {
namespace {

constexpr dataset::Time_ns kPeriod = 66'000'000;

// Small, so that the tests are quick under sanitizers too.
RgbdSlamOptions SmallOptions() {
  RgbdSlamOptions options;
  options.features = 350;
  options.local_landmarks = 150;
  options.local_keyframes = 5;
  options.local_iterations = 3;
  options.final_landmarks = 500;
  options.final_iterations = 3;
  options.keyframe_angle_rad = 0.25;
  options.keyframe_distance_m = 0.2;
  return options;
}

// A walk along an arc: place and heading at step i.
geometry::Rigid3 ArcPose(int i) {
  const double angle_rad = 0.05 * i;
  return TestingPose(0.5 * std::sin(angle_rad), 0.5 - 0.5 * std::cos(angle_rad),
                     angle_rad);
}

image::Frame Dark() {
  image::Frame frame;
  frame.color = {320, 240, std::vector<uint8_t>(320 * 240 * 3, 7)};
  frame.depth =
      image::DepthImage{320, 240, std::vector<uint16_t>(320 * 240), 0.001};
  return frame;
}

// SLAM with the poses that it was shown.
struct Walker {
  explicit Walker(const RgbdSlamOptions& options)
      : slam(RgbdSlam::Create(options, TestingCalibration()).value()) {}

  RgbdTrackResult See(const geometry::Rigid3& world_from_camera) {
    const int i = static_cast<int>(truth.size());
    truth.push_back({i * kPeriod, world_from_camera});
    return slam
        ->AddFrame(SeeTestingRoom(TestingCalibration(), world_from_camera,
                                  static_cast<uint64_t>(i)),
                   i * kPeriod)
        .value();
  }
  RgbdTrackResult SeeNothing() {
    const int i = static_cast<int>(truth.size());
    truth.push_back({i * kPeriod, truth.back().world_from_camera});
    return slam->AddFrame(Dark(), i * kPeriod).value();
  }
  // RMSE of the positions (m); infinite if too few frames have a pose.
  double Error_m() const {
    std::vector<dataset::TimedPose> estimate;
    const std::vector<std::optional<geometry::Rigid3>> poses =
        slam->Trajectory();
    for (size_t i = 0; i < poses.size(); ++i) {
      if (poses[i]) estimate.push_back({truth[i].time, *poses[i]});
    }
    const auto score = dataset::ScoreTrajectory(estimate, truth);
    return score.ok() ? score->absolute.position_m.rmse
                      : std::numeric_limits<double>::infinity();
  }

  std::unique_ptr<RgbdSlam> slam;
  std::vector<dataset::TimedPose> truth;
};

TEST(RgbdSlam, FollowsAWalk) {
  Walker run(SmallOptions());
  for (int i = 0; i < 30; ++i) {
    const RgbdTrackResult result = run.See(ArcPose(i));
    EXPECT_TRUE(HasPose(result.tracking)) << i;
    EXPECT_TRUE(result.map_from_camera.has_value());
  }
  run.slam->Finish();
  // Depth is right to 3 mm at 2 m, corners to a pixel (8 mm there), over
  // about 200 features.
  EXPECT_LT(run.Error_m(), 0.01);
  const std::vector<std::optional<geometry::Rigid3>> poses =
      run.slam->Trajectory();
  ASSERT_EQ(poses.size(), 30u);
  // The first frame is the map's frame.
  EXPECT_LT(geometry::ErrorBetween(poses[0].value(), {}).translation_m, 1e-9);
  const RgbdSlamStatistics statistics = run.slam->Statistics();
  EXPECT_EQ(statistics.frames, 30);
  EXPECT_EQ(statistics.tracked, 30);
  EXPECT_EQ(statistics.lost, 0);
  EXPECT_EQ(statistics.submaps, 1);
  // 1.45 rad in steps of 0.25, and the first.
  const std::vector<RgbdKeyframe> keyframes = run.slam->Keyframes();
  EXPECT_GE(keyframes.size(), 6u);
  EXPECT_EQ(static_cast<int>(keyframes.size()), statistics.keyframes);
  EXPECT_EQ(keyframes[0].frame, 0);
  for (const RgbdKeyframe& keyframe : keyframes) {
    EXPECT_EQ(keyframe.map_from_camera,
              poses[static_cast<size_t>(keyframe.frame)].value());
  }
}

TEST(RgbdSlam, IsTheSameInEveryRun) {
  std::vector<std::optional<geometry::Rigid3>> first;
  for (int repeat = 0; repeat < 2; ++repeat) {
    Walker run(SmallOptions());
    for (int i = 0; i < 12; ++i) run.See(ArcPose(i));
    run.slam->Finish();
    if (repeat == 0) first = run.slam->Trajectory();
    EXPECT_EQ(run.slam->Trajectory(), first);
  }
}

TEST(RgbdSlam, FindsItselfAgainAfterTheCameraWasCovered) {
  Walker run(SmallOptions());
  for (int i = 0; i < 24; ++i) run.See(ArcPose(i));
  const RgbdTrackResult covered = run.SeeNothing();
  EXPECT_EQ(covered.tracking, RgbdTracking::kLostFewFeatures);
  EXPECT_FALSE(covered.map_from_camera);
  // Back near the start, which the last keyframes do not see.
  const RgbdTrackResult found = run.See(ArcPose(1));
  EXPECT_EQ(found.tracking, RgbdTracking::kRelocalized);
  ASSERT_TRUE(found.map_from_camera);
  const geometry::Rigid3 truth = ArcPose(0).Inverse() * ArcPose(1);
  EXPECT_LT(geometry::ErrorBetween(*found.map_from_camera, truth).translation_m,
            0.03);
  run.slam->Finish();
  EXPECT_FALSE(run.slam->Trajectory()[24]);
  EXPECT_EQ(run.slam->Statistics().relocalized, 1);
  EXPECT_EQ(run.slam->Statistics().lost, 1);
}

TEST(RgbdSlam, JoinsASecondMapToTheFirst) {
  RgbdSlamOptions options = SmallOptions();
  options.lost_frames = 1;
  Walker run(options);
  for (int i = 0; i < 8; ++i) run.See(ArcPose(i));
  // Now it looks the other way, where nothing is known.
  const double away_rad = std::numbers::pi;
  EXPECT_EQ(run.See(TestingPose(0.2, 0, away_rad)).tracking,
            RgbdTracking::kLostNoMatch);
  EXPECT_EQ(run.See(TestingPose(0.2, 0, away_rad)).tracking,
            RgbdTracking::kNewSubmap);
  EXPECT_EQ(run.slam->Statistics().submaps, 2);
  // It turns until it sees what it knows.
  for (double yaw_rad = away_rad; yaw_rad > 0.3; yaw_rad -= 0.12) {
    EXPECT_TRUE(HasPose(run.See(TestingPose(0.2, 0, yaw_rad)).tracking));
  }
  run.slam->Finish();
  EXPECT_EQ(run.slam->Statistics().joined_submaps, 1);
  const std::vector<std::optional<geometry::Rigid3>> poses =
      run.slam->Trajectory();
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].has_value(), i != 8) << i;
  }
  EXPECT_LT(run.Error_m(), 0.03);
}

TEST(RgbdSlam, ClosesTheLoopOfAFullTurn) {
  double errors_m[2] = {};
  for (const bool closes_loops : {false, true}) {
    RgbdSlamOptions options = SmallOptions();
    options.closes_loops = closes_loops;
    options.final_landmarks = 3000;
    options.final_iterations = 10;
    Walker run(options);
    for (int i = 0; i < 64; ++i) {
      // A little more than once around.
      run.See(TestingPose(0.3 * std::cos(0.1 * i), 0.3 * std::sin(0.1 * i),
                          0.105 * i));
    }
    run.slam->Finish();
    EXPECT_EQ(run.slam->Statistics().loops > 0, closes_loops);
    errors_m[closes_loops ? 1 : 0] = run.Error_m();
  }
  // As in a walk, and half as much again for what the loop leaves.
  EXPECT_LT(errors_m[1], 0.015);
  EXPECT_LT(errors_m[1], errors_m[0]);
}

TEST(RgbdSlam, RefusesWhatIsNoFrame) {
  Walker run(SmallOptions());
  run.See(ArcPose(0));
  image::Frame frame = SeeTestingRoom(TestingCalibration(), ArcPose(1), 1);
  EXPECT_EQ(run.slam->AddFrame(frame, 0).status().code(),
            absl::StatusCode::kInvalidArgument);
  image::Frame flat = frame;
  flat.depth.reset();
  EXPECT_EQ(run.slam->AddFrame(flat, kPeriod).status().code(),
            absl::StatusCode::kInvalidArgument);
  image::Frame small = frame;
  small.color.width = 10;
  EXPECT_FALSE(run.slam->AddFrame(small, kPeriod).ok());
  image::Frame cut = frame;
  cut.color.rgb.resize(100);
  EXPECT_FALSE(run.slam->AddFrame(cut, kPeriod).ok());
  image::Frame shallow = frame;
  shallow.depth->values.resize(100);
  EXPECT_FALSE(run.slam->AddFrame(shallow, kPeriod).ok());
  // None of them was added.
  EXPECT_TRUE(run.slam->AddFrame(frame, kPeriod).ok());
  EXPECT_EQ(run.slam->Trajectory().size(), 2u);
  run.slam->Finish();
  EXPECT_EQ(run.slam->AddFrame(frame, 2 * kPeriod).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(RgbdSlam, HasNoPosesBeforeItHasSeenAnything) {
  const auto slam = RgbdSlam::Create({}, TestingCalibration()).value();
  slam->Finish();
  EXPECT_TRUE(slam->Trajectory().empty());
  EXPECT_TRUE(slam->Keyframes().empty());
  const auto dark = RgbdSlam::Create({}, TestingCalibration()).value();
  EXPECT_EQ(dark->AddFrame(Dark(), 0).value().tracking,
            RgbdTracking::kLostFewFeatures);
  dark->Finish();
  EXPECT_FALSE(dark->Trajectory()[0]);
}

TEST(RgbdSlam, OptionsAreChecked) {
  const auto is_accepted = [](const RgbdSlamOptions& options) {
    return RgbdSlam::Create(options, TestingCalibration()).ok();
  };
  EXPECT_TRUE(is_accepted({}));
  EXPECT_FALSE(is_accepted({.features = 0}));
  EXPECT_FALSE(is_accepted({.max_depth_m = std::nan("")}));
  EXPECT_FALSE(is_accepted({.min_inliers = 1}));
  EXPECT_FALSE(is_accepted({.final_iterations = -1}));
}

}  // namespace
}  // namespace treeline::rgbd_slam
